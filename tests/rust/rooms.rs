//! The library's files, rooms and groups of rooms: imports lead down only, and no files import each other in a circle,
//! nor do those of the programs and of the Python module.
//!
//! A room is an entry of a group of `src`, or of `src` itself. A path is followed through `use` to the file that has what
//! it names; a file that declares modules imports their files.

use crate::imports::Sources;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The entries of `src` that are groups of rooms.
const GROUPS: [&str; 5] = ["base", "motion", "dense", "figure", "session"];

/// The entries of `src`. What is in one imports only from it and from those before.
const ORDER: [&str; 11] =
    ["base", "motion", "dense", "still", "figure", "mask", "correction", "session", "synth", "tracks", "wasm"];

/// Which name imports which others.
type Imports = BTreeMap<String, BTreeSet<String>>;

fn library() -> Imports {
    let imports = Sources::of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).imports();
    assert!(imports.len() > 130 && imports.values().map(BTreeSet::len).sum::<usize>() > 600, "{imports:?}");
    imports
}

/// The first `depth` names of a file's path.
fn upper(file: &str, depth: usize) -> String {
    let names: Vec<&str> = file.trim_end_matches(".rs").split('/').take(depth).collect();
    names.join("/")
}

fn room_of(file: &str) -> String {
    upper(file, if GROUPS.contains(&upper(file, 1).as_str()) { 2 } else { 1 })
}

/// The same between what `name` makes of files, without those files that declare modules alone.
fn between(files: &Imports, name: impl Fn(&str) -> String) -> Imports {
    let declares = |file: &str| file == "lib.rs" || GROUPS.iter().any(|group| file == format!("{group}/mod.rs"));
    let mut found = Imports::new();
    for (from, to) in files.iter().filter(|(from, _)| !declares(from)) {
        let from = name(from);
        let to: Vec<String> = to.iter().map(|to| name(to)).filter(|to| *to != from).collect();
        found.entry(from).or_default().extend(to);
    }
    found
}

/// What `from` imports, what these import, and so on.
fn reached(imports: &Imports, from: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(next) = open.pop() {
        open.extend(
            imports.get(next).into_iter().flatten().filter(|to| found.insert((*to).clone())).map(String::as_str),
        );
    }
    found
}

/// The imports that lead back to where they come from.
fn circles(imports: &Imports) -> Imports {
    let reached: BTreeMap<&String, _> = imports.keys().map(|from| (from, reached(imports, from))).collect();
    let leads_back = |from: &String, to: &String| reached.get(to).is_some_and(|found| found.contains(from));
    let back = |from: &String, to: &BTreeSet<String>| to.iter().filter(|to| leads_back(from, to)).cloned().collect();
    let all = imports.iter().map(|(from, to)| (from.clone(), back(from, to)));
    all.filter(|(_, to): &(String, BTreeSet<String>)| !to.is_empty()).collect()
}

#[test]
fn imports_between_groups_lead_down_only() {
    let groups = between(&library(), |file| upper(file, 1));
    assert_eq!(groups.keys().cloned().collect::<BTreeSet<_>>(), BTreeSet::from(ORDER.map(String::from)));
    let place = |name: &str| ORDER.iter().position(|entry| *entry == name);
    for (from, to) in &groups {
        let up: Vec<_> = to.iter().filter(|to| place(to) >= place(from)).collect();
        assert!(up.is_empty(), "{from} imports {up:?}");
    }
}

#[test]
fn imports_between_rooms_lead_down_only() {
    let rooms = between(&library(), room_of);
    assert!(rooms.len() > 20 && rooms["session/run"].contains("dense/cut"), "{rooms:?}");
    assert!(rooms["dense/cut"].contains("base/params"));
    let circles = circles(&rooms);
    assert!(circles.is_empty(), "imports in a circle: {circles:#?}");
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let circles = circles(&library());
    assert!(circles.is_empty(), "imports in a circle: {circles:#?}");
}

#[test]
fn no_files_of_the_programs_or_the_python_module_import_each_other_in_a_circle() {
    for (folder, num_imports) in [("bench/src", 80), ("cli/src", 80), ("python/src", 30)] {
        let imports = Sources::of(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).imports();
        assert!(imports.values().map(BTreeSet::len).sum::<usize>() > num_imports, "{folder}: {imports:?}");
        let circles = circles(&imports);
        assert!(circles.is_empty(), "{folder}: imports in a circle: {circles:#?}");
    }
}

#[test]
fn a_circle_is_seen_through_what_passes_names_on() {
    let imports = |deep: &str| {
        let files = [
            ("lib.rs", "mod group;\npub use group::{low, high};"),
            ("group/mod.rs", "//! use crate::high::Top;\npub mod low;\npub mod high;"),
            ("group/low/mod.rs", "mod deep;\npub use deep::Deep;\npub struct Own;"),
            ("group/low/deep.rs", deep),
            ("group/high.rs", "use crate::low::{self, Deep as Base};\npub struct Top(Base, low::Own);"),
        ];
        Sources::from_texts(files.map(|(file, text)| (file.to_owned(), text.to_owned()))).imports()
    };
    let found = imports("#[cfg(test)]\nmod tests {\n    use crate::high::Top;\n}\n");
    assert_eq!(found["group/high.rs"], BTreeSet::from(["group/low/deep.rs", "group/low/mod.rs"].map(String::from)));
    assert!(circles(&found).is_empty());
    for (text, length) in [("use crate::{high::Top as Up};", 3), ("struct Deep(super::Own);", 2)] {
        let files = circles(&imports(text));
        assert_eq!(files.len(), length, "{text}: {files:?}");
        assert!(files.contains_key("group/low/deep.rs"));
    }
}
