//! `selftest` gives the hashes of the wasm build, from which the file of expected ones is made.

use super::*;
use std::collections::BTreeMap;

#[test]
fn this_machine_gives_the_hashes_of_every_engine() {
    let found = tracecut(["selftest", "--threads", "2"]);
    let printed = text(&found.stdout);
    assert!(found.status.success(), "{printed}{}", text(&found.stderr));
    let expected: serde_json::Value =
        serde_json::from_str(include_str!("../../src/selftest/expected.json")).expect("a list of hashes");
    let expected: BTreeMap<&str, &str> =
        expected["hashes"].as_object().unwrap().iter().map(|(k, v)| (k.as_str(), v.as_str().unwrap())).collect();
    let lines = printed.lines().filter(|line| line.contains("  same  ("));
    let hashes: BTreeMap<&str, &str> = lines
        .map(|line| line.split_once(' ').unwrap())
        .map(|(k, v)| (k, v.trim_start().split(' ').next().unwrap()))
        .collect();
    assert_eq!(hashes, expected);
    assert!(hashes.len() >= 15, "{} hashes", hashes.len());
}
