//! The crate as crates.io would get it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// Beside sources and Rust examples: words, licences, the manifest, and what cargo adds.
const OTHERS: [&str; 8] = [
    ".cargo_vcs_info.json",
    "CHANGELOG.md",
    "Cargo.lock",
    "Cargo.toml",
    "Cargo.toml.orig",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What `cargo package` would pack, with `/` between folders.
fn packed() -> Vec<String> {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let arguments = ["package", "--list", "--allow-dirty", "--offline", "--package", "tracecut"];
    let output = Command::new(cargo).args(arguments).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.replace('\\', "/")).collect()
}

/// All files in a folder and the folders in it.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files_in(&path) } else { vec![path] }).collect()
}

#[test]
fn the_crate_holds_sources_rust_examples_and_words_and_nothing_else() {
    for file in packed() {
        let source = file.starts_with("src/") || file.starts_with("examples/") && file.matches('/').count() == 1;
        assert!(source && file.ends_with(".rs") || OTHERS.contains(&file.as_str()), "{file} is in the crate");
    }
}

#[test]
fn every_source_and_every_word_is_in_the_crate() {
    let packed = packed();
    let name = |path: PathBuf| path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
    let sources = files_in(&root().join("src")).into_iter().map(name);
    let examples = fs::read_dir(root().join("examples")).unwrap().map(|entry| entry.unwrap().path());
    let examples: Vec<String> =
        examples.filter(|path| path.extension().is_some_and(|end| end == "rs")).map(name).collect();
    assert!(examples.len() > 1, "{examples:?}");
    let words = ["CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "README.md"].map(String::from);
    for file in sources.chain(examples).chain(words) {
        assert!(packed.contains(&file), "{file} is missing");
    }
}
