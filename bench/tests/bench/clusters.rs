//! Evaluations of the clusters of trajectories: discretizations against each other; entangled people.

use super::*;
use std::fs;
use std::path::Path;
use tracecut::synth::Scene;

#[test]
fn five_discretizations_are_swept_and_printed() {
    let root = folder("discretizations");
    write_shot(&root);
    let (table, report) = scored("discretization", &root, &["--eigenvectors", "6"]);
    for line in ["toy ", "rot-disc against K-means: ", "rot-disc against rot-gap: ", "rot-disc lies below the others"] {
        assert!(table.lines().any(|l| l.starts_with(line)), "\"{line}\" is missing: {table}");
    }
    let curves = report["curves"].as_array().unwrap();
    let names: Vec<_> = curves.iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["rot-disc", "K-means", "rot", "K-means-gap", "rot-gap"]);
    let toy = &report["sequences"][0];
    assert_eq!(toy["eigenvalues"].as_array().unwrap().len(), 6);
    // Two objects, one cluster: the smaller of them at least is missed. With merging two are found at any number of
    // eigenvectors.
    for method in ["rotationMerge", "kMeans", "rotation"] {
        let errors = toy[method].as_array().unwrap();
        assert_eq!(errors.len(), 6, "{method}");
        assert!(errors[0]["missed"].as_f64().unwrap() >= 1.0, "{method}: {errors:?}");
        assert_eq!((&errors[1]["missed"], &errors[1]["oversegmentation"]), (&0.0.into(), &0.0.into()), "{method}");
    }
    for errors in &toy["rotationMerge"].as_array().unwrap()[1..] {
        assert_eq!((&errors["missed"], &errors["oversegmentation"]), (&0.0.into(), &0.0.into()), "{toy}");
    }
    assert!(toy["rotation"][5]["oversegmentation"].as_f64().unwrap() > 0.0, "{toy}");

    let refused = score("discretization", &root, &["--fragment-share", "101"]);
    assert!(text(&refused.stderr).contains("expected a number, 0..=100"), "{}", text(&refused.stderr));
    assert_refused(&score("discretization", &folder("nothing"), &[]), 3, &["no sequence"]);
}

/// A sequence in the layout of `bench figment`, with a mask of every seventh frame: palette images, or grey ones of two
/// bits a pixel.
fn write_players(folder: &Path, scene: &Scene) {
    fs::create_dir_all(folder.join("frames")).unwrap();
    fs::create_dir_all(folder.join("masks")).unwrap();
    let (width, height) = scene.size();
    let encoder = |path: &Path| png::Encoder::new(fs::File::create(path).unwrap(), width as u32, height as u32);
    for t in 0..scene.num_frames() {
        let mut frame = encoder(&folder.join(format!("frames/{t:05}.png")));
        frame.set_color(png::ColorType::Rgb);
        frame.write_header().unwrap().write_image_data(scene.frame(t).rgb()).unwrap();
    }
    for t in (0..scene.num_frames()).step_by(7) {
        let (mask, mut file) = (scene.mask(t), encoder(&folder.join(format!("masks/{t:05}.png"))));
        if t % 2 == 0 {
            file.set_color(png::ColorType::Indexed);
            file.set_palette(vec![0, 0, 0, 200, 200, 200, 200, 200, 200]);
            file.write_header().unwrap().write_image_data(mask.data()).unwrap();
        } else {
            file.set_depth(png::BitDepth::Two);
            let packed = |four: &[u8]| (0..4).map(|k| four.get(k).map_or(0, |v| v << (6 - 2 * k))).sum::<u8>();
            let rows = mask.data().chunks(width).flat_map(|row| row.chunks(4).map(packed)).collect::<Vec<u8>>();
            file.write_header().unwrap().write_image_data(&rows).unwrap();
        }
    }
}

#[test]
fn entangled_players_are_run_and_scored_with_and_without_connectedness() {
    let root = folder("figment");
    // An odd width: rows of packed masks end within a byte.
    write_players(&root.join("players"), &Scene::entangled((241, 180), 29, 1));
    let step = ["--set", "trajectory.gridStep=6"];
    let (table, report) = scored("figment", &root, &step);
    for line in ["players ", "    without connectedness ", "mean, with connectedness ", "mean, without "] {
        assert!(table.lines().any(|l| l.starts_with(line)), "\"{line}\" is missing: {table}");
    }
    let scores = &report["sequences"][0];
    assert_eq!((&scores["frames"], &scores["labelled"], &scores["objects"]), (&29.into(), &5.into(), &2.0.into()));
    let without = &scores["withoutConnectedness"];
    assert_eq!(without, &report["withoutConnectedness"]);
    // Both players are one cluster by their motion: it is one player's, and all of the other is wrong.
    let of = |scores: &serde_json::Value, name: &str| scores[name].as_f64().unwrap();
    assert!(of(without, "perRegionError") > 45.0 && of(without, "trackingTime") < 60.0, "{without}");
    assert!(of(without, "density") > 1.0 && of(without, "clusteringError") < 20.0, "{without}");
    assert!(of(scores, "perRegionError") <= of(without, "perRegionError"), "{scores}");

    let (_, off) = scored("figment", &root, &[&step[..], &["--set", "connectedness.mode=off"]].concat());
    assert!(off["withoutConnectedness"].is_null());
    assert_eq!(&off["mean"], without);

    let masks = root.join("players/masks");
    fs::rename(masks.join("00028.png"), masks.join("00029.png")).unwrap();
    assert_refused(&score("figment", &root, &step), 3, &["players", "frame 29"]);
    fs::rename(masks.join("00029.png"), masks.join("last.png")).unwrap();
    assert_refused(&score("figment", &root, &step), 3, &["last.png", "number"]);
    fs::copy(root.join("players/frames/00000.png"), masks.join("last.png")).unwrap();
    fs::rename(masks.join("last.png"), masks.join("1.png")).unwrap();
    assert_refused(&score("figment", &root, &step), 3, &["1.png", "palette"]);
    assert_refused(&score("figment", &folder("no-players"), &[]), 3, &["no sequence"]);
}
