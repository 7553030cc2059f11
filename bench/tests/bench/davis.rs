//! `bench davis` on folders whose true masks are made from the program's own, so that the scores are known.

use super::*;

/// Writes the moving clip as a sequence whose true mask is white where `truth` says so of whether a pixel has a label.
fn sequence(images: &Path, annotations: &Path, truth: &dyn Fn(bool) -> bool) {
    write_clip(images, annotations, &|_, label| if truth(label) { 255 } else { 0 });
}

#[test]
fn known_masks_have_known_scores_in_both_layouts() {
    let (own, original) = (folder("davis-own"), folder("davis-original"));
    let right: &dyn Fn(bool) -> bool = &|label| label;
    let inverse: &dyn Fn(bool) -> bool = &|label| !label;
    for (name, truth) in [("right", right), ("inverse", inverse)] {
        let place = own.join(name);
        sequence(&place.join("JPEGImages"), &place.join("Annotations"), truth);
        let place = |kind: &str| original.join(kind).join("480p").join(name);
        sequence(&place("JPEGImages"), &place("Annotations"), truth);
    }
    let (table, report) = scored("davis", &own, &[]);
    // Name, frames, objects; J and F with recall and decay; the oracle's J, which finds the inverse too.
    assert_eq!(row(&table, "right")[3..10], ["1.000", "1.000", "0.000", "1.000", "1.000", "0.000", "1.000"]);
    assert_eq!(row(&table, "inverse")[3..6], ["0.000", "0.000", "0.000"]);
    // The inverse has the same boundary.
    assert_eq!(row(&table, "inverse")[6..10], ["1.000", "1.000", "0.000", "1.000"]);
    assert_eq!(row(&table, "mean of 2")[3..10], ["0.500", "0.500", "0.000", "1.000", "1.000", "0.000", "1.000"]);
    assert!(!table.contains("trc"), "{table}");
    assert_eq!((&report["mean"]["j"]["mean"], &report["mean"]["f"]["mean"]), (&0.5.into(), &1.0.into()));
    assert_eq!(report["sequences"][1]["jOfFrames"].as_array().unwrap().len(), FRAMES as usize - 2);

    let scores_only = |table: &str| -> Vec<Vec<String>> {
        ["inverse", "right"].map(|n| row(table, n)[..10].iter().map(|w| (*w).to_owned()).collect()).to_vec()
    };
    assert_eq!(scores_only(&scored("davis", &original, &[]).0), scores_only(&table));
}

#[test]
fn masks_at_source_are_scored_beside_those_of_the_nearest_pixels() {
    let root = folder("davis-source");
    sequence(&root.join("toy/JPEGImages"), &root.join("toy/Annotations"), &|label| label);
    let (table, report) = scored("davis", &root, &["--at-source", "--set", "clip.maxSide=120"]);
    let toy = row(&table, "toy").iter().skip(11).map(|v| v.parse().unwrap()).collect::<Vec<f64>>();
    assert_eq!(toy.len(), 7, "J, F and fine F of both, and milliseconds");
    // The truth is what was found at full size; a smaller one finds less of it, whose borders come nearer to its own.
    assert!(toy[0] > 0.4 && toy[5] > toy[4], "{toy:?}");
    let mean = &report["mean"]["atSource"];
    for (k, name) in ["j", "f", "fineF"].into_iter().enumerate() {
        assert!((mean[name]["nearest"].as_f64().unwrap() - toy[2 * k]).abs() < 1e-4, "{name}");
        assert!((mean[name]["enlarged"].as_f64().unwrap() - toy[2 * k + 1]).abs() < 1e-4, "{name}");
    }
    // At the frames' own size nothing is to be enlarged.
    let (table, _) = scored("davis", &root, &["--at-source"]);
    assert_eq!(row(&table, "toy")[11..17], ["1.0000"; 6]);
}

#[test]
fn published_figures_stand_beside_and_overlays_are_written_on_demand() {
    let root = folder("published");
    sequence(&root.join("toy/JPEGImages"), &root.join("toy/Annotations"), &|label| label);
    // The best without learning is msg; arp has learned parts; key has no figures for the sequence.
    let figures =
        r#"{"trc": {"toy": [0.25, 0.5]}, "msg": {"toy": [0.625, 0.125]}, "arp": {"toy": [0.75, 0.75]}, "key": {}}"#;
    fs::write(root.join("published.json"), figures).unwrap();
    let pictures = root.join("pictures");
    let overlay = ["--overlay", pictures.to_str().unwrap(), "--overlay-step", "3"];
    let (table, _) = scored("davis", &root, &[&["--frames", "7"], &overlay[..]].concat());
    assert_eq!(row(&table, "toy")[11..], ["|", "0.250", "0.500", "0.625", "0.125", "msg"]);
    assert_eq!(row(&table, "  arp")[..5], ["arp", "J", "0.750", "F", "0.750"]);
    assert!(table.lines().all(|l| !l.starts_with("  key")), "{table}");
    assert_eq!(names_in(&pictures.join("toy")), ["00000.png", "00003.png", "00006.png"]);
    let picture = image::open(pictures.join("toy/00003.png")).unwrap().into_rgb8();
    let outline = picture.pixels().filter(|p| p.0 == [255; 3]).count();
    assert!(outline > 60, "{outline} white pixels");

    fs::write(root.join("published.json"), "[]").unwrap();
    assert_refused(&score("davis", &root, &[]), 3, &["published.json", "sequence"]);
}

#[test]
fn folders_that_cannot_be_scored_are_refused_with_the_reason() {
    let root = folder("davis-bad");
    assert_refused(&score("davis", &root, &[]), 3, &["holds no sequence", "JPEGImages/480p/NAME"]);
    assert_refused(&score("davis", &root.join("nowhere"), &[]), 1, &["nowhere", "cannot be read"]);
    let (images, annotations) = (root.join("toy/JPEGImages"), root.join("toy/Annotations"));
    fs::create_dir_all(&images).unwrap();
    assert_refused(&score("davis", &root, &[]), 3, &["toy", "has no images"]);
    clip(&images, 2, SIZE, &moving);
    assert_refused(&score("davis", &root, &[]), 3, &["toy", "2 images (expected at least 3"]);
    clip(&images, 4, SIZE, &moving);
    assert_refused(&score("davis", &root, &[]), 3, &["Annotations/f0.png", "is missing"]);
    fs::create_dir_all(&annotations).unwrap();
    clip(&annotations, 3, SIZE, &|_, _, _| 255);
    assert_refused(&score("davis", &root, &[]), 3, &["Annotations/f3.png", "is missing"]);
    png(&annotations.join("f3.png"), 96, 128, &|_, _| 255);
    assert_refused(&score("davis", &root, &[]), 3, &["f3.png", "96x128 (expected 128x96"]);
    fs::write(annotations.join("f3.png"), "no image").unwrap();
    assert_refused(&score("davis", &root, &[]), 3, &["f3.png", "cannot be decoded"]);
    // The fourth frame is not used.
    assert_done(&score("davis", &root, &["--frames", "3"]));
    clip(&images, 3, SIZE, &|_, _, _| 0);
    let (still, _) = scored("davis", &root, &["--frames", "3"]);
    assert_eq!(row(&still, "toy")[1..4], ["3", "0", "0.000"]);
    assert_refused(&score("davis", &root, &["--only", "toy,boat"]), 3, &["holds no sequence named boat"]);
    assert_refused(&score("davis", &root, &["--frames", "2"]), 2, &["--frames"]);
    assert_refused(&score("davis", &root, &["--set", "clip.dense=false"]), 2, &["clip.dense"]);
}
