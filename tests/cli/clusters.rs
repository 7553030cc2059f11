//! Evaluations of the clusters of trajectories: discretizations against each other.

use super::{assert_done, assert_refused, folder, json, text, tracecut, write_shot};
use std::fs;

#[test]
fn five_discretizations_are_swept_printed_and_plotted() {
    let root = folder("discretizations");
    write_shot(&root);
    let (svg, file) = (root.join("curves.svg"), root.join("curves.json"));
    let arguments = ["eval", "discretization", root.to_str().unwrap(), "--eigenvectors", "6"];
    let output =
        tracecut(arguments.iter().copied().chain(["--svg", svg.to_str().unwrap(), "--json", file.to_str().unwrap()]));
    assert_done(&output);
    let table = text(&output.stdout);
    for line in ["toy ", "rot-disc against K-means: ", "rot-disc against rot-gap: ", "rot-disc lies below the others"] {
        assert!(table.lines().any(|l| l.starts_with(line)), "\"{line}\" is missing: {table}");
    }
    let report = json(&file);
    let curves = report["curves"].as_array().unwrap();
    let names: Vec<_> = curves.iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["rot-disc", "K-means", "rot", "K-means-gap", "rot-gap"]);
    let toy = &report["sequences"][0];
    assert_eq!(toy["eigenvalues"].as_array().unwrap().len(), 6);
    // Two objects, one cluster: the smaller of them at least is missed. With merging two are found at any number of eigenvectors.
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
    let picture = fs::read_to_string(&svg).unwrap();
    assert!(picture.starts_with("<svg ") && names.iter().all(|n| picture.contains(n)), "{picture}");

    let refused = tracecut(arguments.into_iter().chain(["--fragment-share", "101"]));
    assert!(text(&refused.stderr).contains("expected a number, 0..=100"), "{}", text(&refused.stderr));
    assert_refused(&tracecut(["eval", "discretization", folder("nothing").to_str().unwrap()]), 1, &["no sequence"]);
}
