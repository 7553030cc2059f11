//! `bench masks` and `bench stability` on folders whose true masks are made from the program's own, so that the scores
//! are known.

use super::*;

/// Writes the moving clip as `frames` and `masks` of a folder.
fn wild(place: &Path, truth: &dyn Fn(usize, bool) -> u8) {
    write_clip(&place.join("frames"), &place.join("masks"), truth);
}

/// Mean share of the scored frames that has a label.
fn labelled_share(found: &[Found]) -> f64 {
    let share = |f: &Found| f.iter().filter(|&&l| l).count() as f64 / f.len() as f64;
    let scored = &found[1..found.len() - 1];
    scored.iter().map(share).sum::<f64>() / scored.len() as f64
}

fn close(value: &serde_json::Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!((value - expected).abs() < 1e-9, "{value} (expected {expected})");
}

#[test]
fn known_masks_have_known_scores_per_clip_kind_and_in_all() {
    let root = folder("wild");
    let grey = |is: bool| if is { 255 } else { 0 };
    wild(&root.join("toy--right"), &|_, label| grey(label));
    // Upside down, but for the upper half of the frame, which is not scored.
    let half = (SIZE.0 * SIZE.1 / 2) as usize;
    wild(&root.join("toy--ignored"), &|i, label| if i < half { 128 } else { grey(label) });
    wild(&root.join("odd--empty"), &|_, _| 0);
    wild(&root.join("odd--inverse"), &|_, label| grey(!label));
    // A frame without its mask is left out; the masks of the first and the last do not count.
    for t in [0, 4, FRAMES - 1] {
        fs::remove_file(root.join(format!("toy--right/masks/{t:05}.png"))).unwrap();
    }
    let (table, report) = scored("masks", &root, &["--jobs", "1"]);
    let objects = row(&table, "toy--right")[2].to_owned();
    let all = format!("{objects}/{objects}");
    assert_eq!(row(&table, "toy--right")[1], FRAMES.to_string());
    assert_eq!(row(&table, "toy--right")[3..7], ["1.000", "1.000", "1.000", "1.000"], "{table}");
    assert_eq!(row(&table, "toy--right")[7..10], ["0.000", "1/1", &format!("0/{objects}")]);
    assert_eq!(row(&table, "toy--ignored")[3..5], ["1.000", "1.000"]);
    assert_eq!(row(&table, "odd--inverse")[3..8], ["0.000", "1.000", "0.000", "0.000", "1.000"]);
    assert_eq!(row(&table, "odd--inverse")[9], all);
    assert_eq!(row(&table, "odd--empty")[4..7], ["-", "-", "-"]);
    assert_eq!(row(&table, "odd--empty")[8..10], ["0/0", &all]);

    let clip = |name: &str| report["clips"].as_array().unwrap().iter().find(|c| c["name"] == name).unwrap().clone();
    let empty = 1.0 - labelled_share(found());
    close(&clip("odd--empty")["runs"][0]["j"], empty);
    close(&clip("odd--empty")["runs"][0]["falseShare"], 1.0 - empty);
    let right = clip("toy--right");
    let frames: Vec<u64> =
        right["runs"][0]["ofFrames"].as_array().unwrap().iter().map(|f| f["frame"].as_u64().unwrap()).collect();
    assert_eq!(frames, [1, 2, 3, 5, 6, 7, 8]);
    close(&report["kinds"]["toy"]["j"]["mean"], 1.0);
    close(&report["kinds"]["odd"]["j"]["mean"], empty / 2.0);
    close(&report["meanOfKinds"]["j"]["mean"], 0.5 + empty / 4.0);
    close(&report["meanOfClips"]["j"]["mean"], 0.5 + empty / 4.0);
    // Three clips have an object.
    close(&report["meanOfClips"]["best"]["mean"], 2.0 / 3.0);
}

#[test]
fn seeds_layouts_and_parts_of_a_folder_can_be_chosen() {
    let root = folder("chosen");
    wild(&root.join("toy--right"), &|_, label| if label { 255 } else { 0 });
    let davis = root.join("other");
    wild(&davis, &|_, label| if label { 100 } else { 0 });
    fs::rename(davis.join("frames"), davis.join("JPEGImages")).unwrap();
    fs::rename(davis.join("masks"), davis.join("Annotations")).unwrap();
    let pictures = root.join("pictures");
    let (table, _) = scored("masks", &root, &["--seeds", "0,5", "--overlay", pictures.to_str().unwrap()]);
    assert!(table.lines().next().unwrap().contains(" SE "), "{table}");
    // The folder's own name is the kind of what names none.
    assert_eq!(row(&table, "chosen (1)")[0], "chosen");
    assert_eq!(names_in(&pictures.join("other")), ["00000.png"]);

    let (table, _) = scored("masks", &root, &["--only", "nothing,othe", "--frames", "6"]);
    assert_eq!(row(&table, "other")[1], "6");
    assert!(!table.contains("toy--right") && !table.contains(" SE "), "{table}");
    // A single clip.
    let (single, _) = scored("masks", &davis, &["--frames", "6"]);
    assert_eq!(row(&single, "other")[..9], row(&table, "other")[..9]);
    assert_refused(&score("masks", &root, &["--only", "boat"]), 3, &["no clip", "boat"]);
}

#[test]
fn a_clip_is_run_from_each_start_mirrored_and_compared_run_by_run() {
    let root = folder("runs");
    wild(&root.join("toy--right"), &|_, label| if label { 255 } else { 0 });
    let runs = ["--frames", "5", "--starts", "2", "--mirror", "--seeds", "0,5"];
    for command in ["masks", "points"] {
        let (table, report) = scored(command, &root, &runs);
        assert!(row(&table, "clip").contains(&"SE"), "{table}");
        let found = report["clips"][0]["runs"].as_array().unwrap();
        let id = |run: &serde_json::Value| (run["start"].clone(), run["mirrored"].clone(), run["seed"].clone());
        let expected = [0, 5].map(|start| [false, true].map(|mirrored| [0, 5].map(|seed| (start, mirrored, seed))));
        let expected = expected.concat().concat().into_iter().map(|(a, b, c)| (a.into(), b.into(), c.into()));
        assert_eq!(found.iter().map(id).collect::<Vec<_>>(), expected.collect::<Vec<_>>());
        // The mean and its standard error, naively.
        let figure = if command == "masks" { "j" } else { "error" };
        let values: Vec<f64> = found.iter().map(|run| run[figure].as_f64().unwrap()).collect();
        let mean = values.iter().sum::<f64>() / 8.0;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 7.0;
        let estimate = &report["clips"][0]["mean"][figure];
        close(&estimate["mean"], mean);
        close(&estimate["standardError"], (variance / 8.0).sqrt());
        assert_eq!(&report["meanOfKinds"][figure], estimate, "one clip is all");

        // The last start as a clip of its own.
        let part = root.join("part").join(command);
        for kind in ["frames", "masks"] {
            fs::create_dir_all(part.join(kind)).unwrap();
            for name in &names_in(&root.join("toy--right").join(kind))[5..] {
                fs::copy(root.join("toy--right").join(kind).join(name), part.join(kind).join(name)).unwrap();
            }
        }
        let (_, alone) = scored(command, &part, &["--frames", "5", "--seeds", "5"]);
        close(&alone["clips"][0]["runs"][0][figure], values[5]);

        let old = root.join(format!("{command}.json"));
        fs::rename(root.join("scores.json"), &old).unwrap();
        let compare = [&["--compare", old.to_str().unwrap()], &runs[..5]].concat();
        let (table, _) = scored(command, &root, &compare);
        let rows: Vec<&str> = table.lines().skip_while(|line| !line.starts_with("compared with")).collect();
        assert_eq!(row(&rows[2..].join("\n"), "toy (1)")[2].trim_start_matches('+').parse(), Ok(0.0), "{table}");
        assert!(table.trim_end().ends_with(if command == "masks" { "than 0.05" } else { "than 5" }), "{table}");
        let missing = score(command, &root, &[&compare[..], &["--seeds", "1"]].concat());
        assert_refused(&missing, 3, &["toy--right from frame 0, seed 1"]);
        let other = score(command, &root, &["--compare", old.to_str().unwrap(), "--frames", "6"]);
        assert_refused(&other, 3, &["--frames 5", "--frames 6"]);
        assert_refused(&score(command, &part, &compare), 3, &["has no clip"]);
        fs::write(&old, "[]").unwrap();
        assert_refused(&score(command, &root, &compare), 3, &["no file of figures"]);
    }
    assert_refused(&score("masks", &root, &["--starts", "0"]), 2, &["--starts"]);
}

#[test]
fn a_window_as_long_as_the_clip_is_the_clip_and_shorter_ones_cover_it() {
    let root = folder("windows");
    wild(&root.join("toy--right"), &|_, label| if label { 255 } else { 0 });
    let row_with = |window: &str| {
        let (table, _) = scored("masks", &root, &["--window", window]);
        row(&table, "toy--right").iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(row_with("100")[3..8], ["1.000", "1.000", "1.000", "1.000", "0.000"]);
    let shorter = row_with("7");
    assert_eq!(shorter[1], FRAMES.to_string());
    assert!(shorter[3].parse::<f64>().unwrap() > 0.8, "{shorter:?}");
    assert_refused(&score("masks", &root, &["--window", "1"]), 2, &["--window"]);
}

#[test]
fn clips_that_cannot_be_scored_are_refused_with_the_reason() {
    let root = folder("wild-bad");
    assert_refused(&score("masks", &root, &[]), 3, &["NAME/frames and NAME/masks"]);
    let (frames, masks) = (root.join("toy--bad/frames"), root.join("toy--bad/masks"));
    fs::create_dir_all(&frames).unwrap();
    fs::create_dir_all(&masks).unwrap();
    assert_refused(&score("masks", &root, &[]), 3, &["toy--bad", "has no images"]);
    clip(&frames, 4, SIZE, &moving);
    clip(&masks, 1, SIZE, &|_, _, _| 255);
    assert_refused(&score("masks", &root, &[]), 3, &["toy--bad", "no mask of a frame but the first"]);
    png(&masks.join("f1.png"), 96, 128, &|_, _| 255);
    assert_refused(&score("masks", &root, &[]), 3, &["toy--bad", "96x128"]);
    assert_refused(&score("masks", &root, &["--set", "clip.dense=false"]), 2, &["clip.dense"]);
}

#[test]
fn stability_is_measured_under_each_change() {
    let root = folder("stable");
    wild(&root.join("toy--right"), &|_, label| if label { 255 } else { 0 });
    let changes = "base,seed1,crop1,mirror,dark,jpeg,later";
    let (table, report) = scored("stability", &root, &["--changes", changes]);
    assert_eq!(row(&table, "toy--right").len(), 1 + 7 + 2, "{table}");
    let clip = &report["clips"][0];
    // The truth is what comes of the clip as it is, at the size that it has.
    close(&clip["j"]["base"], 1.0);
    let scores: Vec<f64> = changes.split(',').map(|c| clip["j"][c].as_f64().unwrap()).collect();
    // A clip that was mirrored before scores what the change makes of the first.
    let mirrored = root.join("toy--mirrored");
    for kind in ["frames", "masks"] {
        fs::create_dir_all(mirrored.join(kind)).unwrap();
        for name in names_in(&root.join("toy--right").join(kind)) {
            let picture = image::open(root.join("toy--right").join(kind).join(&name)).unwrap();
            picture.fliph().save(mirrored.join(kind).join(&name)).unwrap();
        }
    }
    let (_, there) = scored("stability", &root, &["--only", "mirrored", "--changes", "base,mirror"]);
    let other = &there["clips"][0];
    assert_eq!((&other["j"]["base"], &other["j"]["mirror"]), (&clip["j"]["mirror"], &clip["j"]["base"]));
    let lowest = scores.iter().copied().fold(1.0, f64::min);
    close(&clip["spread"], 1.0 - lowest);
    close(&report["mean"]["j"], scores.iter().sum::<f64>() / 7.0);
    assert!(clip["sd"].as_f64().unwrap() <= (1.0 - lowest) / 2.0 + 1e-9, "{clip}");
    assert_refused(
        &score("stability", &root, &["--only", "right", "--changes", "crop96"]),
        1,
        &["toy--right crop96", "crop96 leaves"],
    );
    assert_refused(&score("stability", &root, &["--changes", "bright"]), 2, &["bright", "mirror"]);
}
