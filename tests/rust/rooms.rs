//! The rooms of the library, which are the entries of `src`: their imports lead down only.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

type Rooms = BTreeMap<String, BTreeSet<String>>;

/// All rooms that the code in `path` imports from, without its tests, into `found`.
fn imports(path: &Path, found: &mut BTreeSet<String>) {
    if path.is_dir() {
        fs::read_dir(path).unwrap().for_each(|entry| imports(&entry.unwrap().path(), found));
        return;
    }
    if path.file_stem().unwrap().to_str().unwrap().ends_with("tests") {
        return;
    }
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code: String = code.lines().map(|line| line.split("//").next().unwrap()).collect();
    for after in code.split("crate::").skip(1) {
        let end = if after.starts_with('{') { '}' } else { ';' };
        let names = after.split(end).next().unwrap().trim_start_matches('{');
        let names = names.split(',').take(if end == '}' { usize::MAX } else { 1 });
        found.extend(names.map(|name| room_of(name.trim())));
    }
}

/// The room of a path that begins behind `crate::`.
fn room_of(path: &str) -> String {
    let name: String = path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    match name.as_str() {
        "Error" => "error".to_owned(),
        "Params" | "Session" | "Progress" | "Stage" | "Step" => "pipeline".to_owned(),
        // The macros of parameters.
        "choices" => "params".to_owned(),
        _ => name,
    }
}

fn rooms() -> Rooms {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut rooms = Rooms::new();
    for entry in fs::read_dir(source).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if !["bin", "lib"].contains(&name.as_str()) {
            let mut found = BTreeSet::new();
            imports(&path, &mut found);
            found.remove(&name);
            rooms.insert(name, found);
        }
    }
    rooms
}

#[test]
fn imports_between_rooms_lead_down_only() {
    let mut rooms = rooms();
    assert!(rooms.len() > 20 && rooms["pipeline"].contains("cut") && rooms["cut"].contains("params"), "{rooms:?}");
    // Rooms that import nothing from those that are left are taken away, until none can be.
    loop {
        let left: BTreeSet<String> = rooms.keys().cloned().collect();
        let before = rooms.len();
        rooms.retain(|_, imports| !imports.is_disjoint(&left));
        if rooms.len() == before {
            break;
        }
    }
    assert!(rooms.is_empty(), "imports in a circle: {rooms:?}");
}
