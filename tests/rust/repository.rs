//! Rules of the repository. Rooms import only from the rooms above them in the table of ARCHITECTURE.md: a room is an entry of a
//! group of `src`, or of `src` itself; paths name it after `crate::`, those of `session` after `crate::session::`. Published
//! crates have their sources and texts, and nothing else.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files in a folder and the folders in it.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files_in(&path) } else { vec![path] }).collect()
}

const GROUPS: [&str; 5] = ["base", "motion", "dense", "figure", "session"];

/// Returns the rooms of the table from top to bottom, those of `session` as `session::NAME`.
fn rooms() -> Vec<String> {
    let text = include_str!("../../ARCHITECTURE.md").replace('\r', "");
    let (_, table) = text.split_once("| group | room | content |\n").unwrap();
    let (mut rooms, mut is_session) = (Vec::new(), false);
    for row in table.lines().skip(1).take_while(|line| line.starts_with('|')) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        is_session = if cells[1].is_empty() { is_session } else { cells[1] == "`session`" };
        let names = cells[2].split('`').skip(1).step_by(2);
        rooms.extend(names.map(|name| if is_session { format!("session::{name}") } else { name.to_owned() }));
    }
    rooms
}

/// Returns the room of a file in `src`; `None` for files that only declare modules.
fn room_of(file: &str) -> Option<String> {
    let names: Vec<&str> = file.trim_end_matches(".rs").split('/').collect();
    match names[..] {
        ["lib"] => None,
        [group, "mod"] if GROUPS.contains(&group) => None,
        ["session", room, ..] => Some(format!("session::{room}")),
        [group, room, ..] if GROUPS.contains(&group) => Some(room.to_owned()),
        [room, ..] => Some(room.to_owned()),
        [] => None,
    }
}

/// Returns the rooms named in the paths of a file, without comments and unit tests.
fn imports_of(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let code: String = code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let is_name = |name: &str| name.starts_with(|c: char| c.is_ascii_lowercase());
    let name_at = |path: &str| path.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("").to_owned();
    // Public names of `session` count as of its last room; `choices` is a macro.
    let in_session = |name: String| if is_name(&name) { name } else { "read".to_owned() };
    let room = |path: &str| match name_at(path).as_str() {
        "choices" => "params".to_owned(),
        "session" => format!("session::{}", in_session(name_at(path.split_once("::").map_or("", |(_, rest)| rest)))),
        name => name.to_owned(),
    };
    code.split("crate::").skip(1).map(room).filter(|name| is_name(name)).collect()
}

#[test]
fn rooms_import_only_from_rooms_above_them() {
    let (rooms, src) = (rooms(), root().join("src"));
    let place = |name: &String| rooms.iter().position(|room| room == name);
    let mut num_imports = 0;
    for path in files_in(&src) {
        let file = path.strip_prefix(&src).unwrap().to_string_lossy().replace('\\', "/");
        let Some(room) = room_of(&file) else { continue };
        let own = place(&room).unwrap_or_else(|| panic!("{file}: ARCHITECTURE.md has no row of {room}"));
        for import in imports_of(&fs::read_to_string(path).unwrap().replace('\r', "")) {
            let above = place(&import).unwrap_or_else(|| panic!("{file} imports crate::{import}, which is no room"));
            assert!(above <= own, "{file} imports {import}, which is below {room}");
            num_imports += 1;
        }
    }
    assert!(num_imports > 300, "{num_imports}");
}

/// What Cargo adds to a crate.
const ADDED: [&str; 4] = [".cargo_vcs_info.json", "Cargo.lock", "Cargo.toml", "Cargo.toml.orig"];

/// What `cargo package` would pack of a crate, with `/` between folders.
fn packed(package: &str) -> BTreeSet<String> {
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let arguments = ["package", "--list", "--allow-dirty", "--offline", "--package", package];
    let output = Command::new(cargo).args(arguments).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let files = String::from_utf8(output.stdout).unwrap();
    files.lines().map(|line| line.replace('\\', "/")).filter(|file| !ADDED.contains(&file.as_str())).collect()
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
