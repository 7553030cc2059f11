//! The crates as crates.io would get them.

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

/// What `cargo package` would pack of a crate, with `/` between folders.
fn packed(package: &str) -> Vec<String> {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let arguments = ["package", "--list", "--allow-dirty", "--offline", "--package", package];
    let output = Command::new(cargo).args(arguments).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.replace('\\', "/")).collect()
}

/// All files in a folder and the folders in it.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files_in(&path) } else { vec![path] }).collect()
}

/// Paths of all sources and words that a crate in `folder` is to have.
fn wanted(folder: &Path, words: &[&str]) -> Vec<String> {
    let name = |path: PathBuf| path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/");
    let sources = files_in(&folder.join("src")).into_iter().map(name);
    sources.chain(words.iter().map(|&word| word.to_owned())).collect()
}

fn assert_all(packed: &[String], wanted: &[String]) {
    for file in wanted {
        assert!(packed.contains(file), "{file} is missing");
    }
}

#[test]
fn the_crate_holds_sources_rust_examples_and_words_and_nothing_else() {
    for file in packed("tracecut") {
        let source = file.starts_with("src/") || file.starts_with("examples/") && file.matches('/').count() == 1;
        assert!(source && file.ends_with(".rs") || OTHERS.contains(&file.as_str()), "{file} is in the crate");
    }
}

#[test]
fn every_source_and_every_word_is_in_the_crate() {
    let packed = packed("tracecut");
    let name = |path: PathBuf| path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
    let examples = fs::read_dir(root().join("examples")).unwrap().map(|entry| entry.unwrap().path());
    let examples: Vec<String> =
        examples.filter(|path| path.extension().is_some_and(|end| end == "rs")).map(name).collect();
    assert!(examples.len() > 1, "{examples:?}");
    assert_all(&packed, &wanted(root(), &["CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "README.md"]));
    assert_all(&packed, &examples);
}

#[test]
fn the_command_line_holds_its_sources_and_words_and_nothing_else() {
    let packed = packed("tracecut-cli");
    // What the self test compares with.
    let data = "src/selftest/expected.json";
    assert_all(&packed, &wanted(&root().join("cli"), &["LICENSE-APACHE", "LICENSE-MIT", "README.md", data]));
    for file in packed {
        let source = file.starts_with("src/") && file.ends_with(".rs") || file == data;
        assert!(source || OTHERS.contains(&file.as_str()), "{file} is in the crate");
    }
}

#[test]
fn the_licences_of_the_command_line_are_those_of_the_library() {
    for name in ["LICENSE-APACHE", "LICENSE-MIT"] {
        let texts = [root().join(name), root().join("cli").join(name), root().join("python").join(name)];
        let [ours, cli, python] = texts.map(|path| fs::read_to_string(path).unwrap());
        assert!(ours == cli && ours == python, "{name}");
    }
}

/// A registry takes no dependency that is known by its path alone, and one of another version is another library.
#[test]
fn the_command_line_names_the_version_of_the_library() {
    let manifest = fs::read_to_string(root().join("cli/Cargo.toml")).unwrap();
    let expected = format!(r#"tracecut = {{ path = "..", version = "{}","#, env!("CARGO_PKG_VERSION"));
    assert!(manifest.lines().any(|line| line.starts_with(&expected)), "expected {expected}");
}

/// What the project measures itself with is for nobody who uses it.
#[test]
fn nothing_that_is_published_carries_the_benchmarks() {
    let read = |name: &str| fs::read_to_string(root().join(name)).unwrap();
    assert!(read("bench/Cargo.toml").lines().any(|line| line == "publish = false"));
    for manifest in ["Cargo.toml", "cli/Cargo.toml", "python/Cargo.toml", "decoder/Cargo.toml"] {
        assert!(!read(manifest).contains("tracecut-bench"), "{manifest}");
    }
}
