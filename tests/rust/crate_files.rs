//! The files of the published crates.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// What Cargo adds to a crate.
const ADDED: [&str; 4] = [".cargo_vcs_info.json", "Cargo.lock", "Cargo.toml", "Cargo.toml.orig"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What `cargo package` would pack of a crate, with `/` between folders.
fn packed(package: &str) -> BTreeSet<String> {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let arguments = ["package", "--list", "--allow-dirty", "--offline", "--package", package];
    let output = Command::new(cargo).args(arguments).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let files = String::from_utf8(output.stdout).unwrap();
    files.lines().map(|line| line.replace('\\', "/")).filter(|file| !ADDED.contains(&file.as_str())).collect()
}

/// All files in a folder and the folders in it.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files_in(&path) } else { vec![path] }).collect()
}

/// The sources of a crate in `folder`, and these files beside them.
fn wanted(folder: &Path, others: &[&str]) -> BTreeSet<String> {
    let name = |path: PathBuf| path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/");
    let sources = files_in(&folder.join("src")).into_iter().map(name);
    sources.chain(others.iter().map(|&file| file.to_owned())).collect()
}

#[test]
fn each_crate_has_its_sources_and_texts_and_nothing_else() {
    let texts = ["CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "README.md"];
    let examples = ["examples/masks.rs", "examples/method.rs"];
    assert_eq!(packed("tracecut"), wanted(root(), &[&texts[..], &examples].concat()));
    assert_eq!(packed("tracecut-cli"), wanted(&root().join("cli"), &texts[1..]));
}

#[test]
fn the_licences_of_the_command_line_are_those_of_the_library() {
    for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
        let files = [root().join(name), root().join("cli").join(name), root().join("python").join(name)];
        let [ours, cli, python] = files.map(|path| fs::read_to_string(path).unwrap());
        assert!(ours == cli && ours == python, "{name}");
    }
}
