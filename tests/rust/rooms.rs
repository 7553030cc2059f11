//! Rooms import only from the rooms above them in the table of ARCHITECTURE.md. A room is an entry of a group of `src`, or of
//! `src` itself; paths name it after `crate::`, those of `session` after `crate::session::`.

use std::fs;
use std::path::{Path, PathBuf};

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

fn add_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { add_files(&path, files) } else { files.push(path) }
    }
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
    let (rooms, src) = (rooms(), Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    let place = |name: &String| rooms.iter().position(|room| room == name);
    let (mut files, mut num_imports) = (Vec::new(), 0);
    add_files(&src, &mut files);
    for path in files {
        let file = path.strip_prefix(&src).unwrap().to_string_lossy().replace('\\', "/");
        let Some(room) = room_of(&file).filter(|_| !file.ends_with("tests.rs")) else { continue };
        let own = place(&room).unwrap_or_else(|| panic!("{file}: ARCHITECTURE.md has no row of {room}"));
        for import in imports_of(&fs::read_to_string(path).unwrap().replace('\r', "")) {
            let above = place(&import).unwrap_or_else(|| panic!("{file} imports crate::{import}, which is no room"));
            assert!(above <= own, "{file} imports {import}, which is below {room}");
            num_imports += 1;
        }
    }
    assert!(num_imports > 300, "{num_imports}");
}
