//! Which file of a crate imports from which, as far as the text of its paths tells.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The names of a module, from the crate's root on, or of something in it.
type Names = Vec<String>;

/// A module that has a file.
struct Module {
    file: String,
    /// What its `use` gives a name to.
    uses: Vec<(String, Names)>,
    /// All other paths in it, and those of macros.
    paths: Vec<Names>,
}

/// All modules of a crate that have a file, without tests.
pub(crate) struct Sources(BTreeMap<Names, Module>);

impl Sources {
    /// The files in a folder and the folders in it.
    pub(crate) fn of(folder: &Path) -> Self {
        let mut texts = Vec::new();
        read(folder, "", &mut texts);
        Self::from_texts(texts)
    }

    /// Files by their path in the crate.
    pub(crate) fn from_texts(texts: impl IntoIterator<Item = (String, String)>) -> Self {
        let code = texts.into_iter().filter(|(file, _)| !file.ends_with("tests.rs"));
        Self(code.map(|(file, text)| (module_of(&file), Module::new(file, &text))).collect())
    }

    /// The files that each file imports from.
    pub(crate) fn imports(&self) -> BTreeMap<String, BTreeSet<String>> {
        let files = self.0.iter().map(|(at, module)| {
            let paths = module.uses.iter().map(|(_, path)| path).chain(&module.paths);
            let mut found: BTreeSet<Names> = paths.filter_map(|path| self.find(at, path, 0)).collect();
            found.extend(self.0.keys().filter(|child| child.len() == at.len() + 1 && child.starts_with(at)).cloned());
            found.remove(at);
            (module.file.clone(), found.iter().map(|name| self.0[name].file.clone()).collect())
        });
        files.collect()
    }

    /// The module whose file has what a path in module `at` names; `None` where that is in no file of the crate.
    fn find(&self, at: &[String], path: &[String], depth: usize) -> Option<Names> {
        assert!(depth < 50, "{at:?}: {path:?}");
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.descend(Vec::new(), rest, depth),
            "self" => self.descend(at.to_vec(), rest, depth),
            "super" => {
                let ups = path.iter().take_while(|name| *name == "super").count();
                self.descend(at[..at.len().checked_sub(ups)?].to_vec(), &path[ups..], depth)
            }
            _ if self.child(at, first).is_some() || self.passed_on(at, first).is_some_and(|own| own != path) => {
                self.descend(at.to_vec(), path, depth)
            }
            _ => None,
        }
    }

    fn descend(&self, at: Names, path: &[String], depth: usize) -> Option<Names> {
        let Some((first, rest)) = path.split_first() else { return Some(at) };
        if let Some(child) = self.child(&at, first) {
            return self.descend(child, rest, depth + 1);
        }
        match self.passed_on(&at, first) {
            Some(own) => self.find(&at, &[own, rest].concat(), depth + 1),
            // All macros stand at the root.
            None if at.is_empty() && first == "choices" => self.child(&["base".to_owned()], "params"),
            None => Some(at),
        }
    }

    fn child(&self, at: &[String], name: &str) -> Option<Names> {
        let child = [at, &[name.to_owned()]].concat();
        self.0.contains_key(&child).then_some(child)
    }

    /// What a name stands for that module `at` has from elsewhere.
    fn passed_on(&self, at: &[String], name: &str) -> Option<&[String]> {
        let (_, path) = self.0.get(at)?.uses.iter().find(|(own, _)| own == name)?;
        Some(path)
    }
}

fn read(folder: &Path, within: &str, texts: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{within}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            read(&path, &format!("{name}/"), texts);
        } else if name.ends_with(".rs") {
            texts.push((name, fs::read_to_string(&path).unwrap().replace('\r', "")));
        }
    }
}

fn module_of(file: &str) -> Names {
    let names = file.trim_end_matches(".rs").split('/').map(str::to_owned);
    names.filter(|name| name != "mod" && name != "lib").collect()
}

impl Module {
    fn new(file: String, text: &str) -> Self {
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        let code: String = code.lines().map(|line| format!("{}\n", line.split("//").next().unwrap())).collect();
        let tokens = tokens(&code);
        let mut module = Self { file, uses: Vec::new(), paths: Vec::new() };
        let mut k = 0;
        while k < tokens.len() {
            if tokens[k..].starts_with(&["#", "[", "cfg", "(", "test", ")", "]"]) {
                k = after_test(&tokens, k + 7);
            } else if tokens[k] == "use" {
                k = used(&tokens, k + 1, &[], &mut module.uses);
            } else if is_name(tokens[k]) && tokens.get(k + 1) == Some(&"::") {
                let (path, end) = path(&tokens, k);
                module.paths.push(path);
                k = end;
            } else {
                k += 1;
            }
        }
        module
    }
}

/// Names, `::`, and all other signs one by one.
fn tokens(code: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let length = match first {
            _ if rest.starts_with("::") => 2,
            c if is_part(c) => rest.find(|c| !is_part(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        tokens.push(token);
        rest = after.trim_start();
    }
    tokens
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Where it goes on after what is for tests alone: a line that ends in a semicolon.
fn after_test(tokens: &[&str], from: usize) -> usize {
    let end = tokens[from..].iter().position(|token| [";", "{", "="].contains(token));
    match end.map(|end| from + end) {
        Some(end) if tokens[end] == ";" => end + 1,
        // `use` with a list.
        Some(end) if tokens[from..end].contains(&"use") => {
            end + tokens[end..].iter().position(|token| *token == ";").unwrap_or(0)
        }
        _ => from,
    }
}

/// The names from `k` on with `::` between them, and where they end.
fn path(tokens: &[&str], mut k: usize) -> (Names, usize) {
    let mut names = vec![tokens[k].to_owned()];
    while tokens.get(k + 1) == Some(&"::") && tokens.get(k + 2).is_some_and(|token| is_name(token)) {
        k += 2;
        names.push(tokens[k].to_owned());
    }
    (names, k + 1)
}

/// Reads a tree of `use` from `k` on, whose names stand behind `before`; returns where it ends.
fn used(tokens: &[&str], k: usize, before: &[String], uses: &mut Vec<(String, Names)>) -> usize {
    let (mut path, mut k) = if is_name(tokens[k]) { path(tokens, k) } else { (Vec::new(), k) };
    path.splice(..0, before.iter().cloned());
    k += usize::from(tokens[k] == "::");
    match tokens[k] {
        "{" => {
            k += 1;
            while tokens[k] != "}" {
                k = used(tokens, k, &path, uses);
                k += usize::from(tokens[k] == ",");
            }
            return k + 1;
        }
        "*" => {
            uses.push(("*".to_owned(), path));
            return k + 1;
        }
        _ => {}
    }
    if path.len() > 1 && path.last().is_some_and(|name| name == "self") {
        path.pop();
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if tokens[k] == "as" {
        name = tokens[k + 1].to_owned();
        k += 2;
    }
    uses.push((name, path));
    k
}
