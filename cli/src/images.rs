//! Which image files make up a clip.

use crate::failure::{Failure, Result, cannot_read, read_text};
use std::path::{Path, PathBuf};

/// Images taken from a folder. Masks in other formats may lie beside them.
const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "ppm"];

/// The images of a folder in the order of their names; runs of digits count as numbers, so that `2.png` comes before
/// `10.png`.
pub fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let cannot = |e| cannot_read(folder, &e);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.is_file() && has_image_extension(&path) {
            paths.push(path);
        }
    }
    if paths.is_empty() {
        return Err(Failure::about(folder.display(), "holds no images (expected PNG, JPEG or PPM files, one a frame)"));
    }
    paths.sort_by_cached_key(|path| name_key(&file_name(path)));
    Ok(paths)
}

fn has_image_extension(path: &Path) -> bool {
    path.extension().is_some_and(|e| EXTENSIONS.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Part of a file name: a run of digits, by its value, or what stands between two such runs.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Number { length: usize, digits: String },
    Text(String),
}

/// What file names are sorted by; the name itself decides between `1.png` and `01.png`.
fn name_key(name: &str) -> (Vec<Part>, String) {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        if digits > 0 {
            let value = rest[..digits].trim_start_matches('0');
            parts.push(Part::Number { length: value.len(), digits: value.to_owned() });
            rest = &rest[digits..];
        } else {
            let end = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
            parts.push(Part::Text(rest[..end].to_owned()));
            rest = &rest[end..];
        }
    }
    (parts, name.to_owned())
}

/// The images that a `.bmf` list names: a first line of counts, then one file name a line, relative to the list.
///
/// Names may lead anywhere that the caller may read; what is no file there, such as a device that never ends, is refused.
///
/// Lists of the Moseg benchmark name `.ppm` files where `.jpg` files stand; a file of the same stem is taken instead.
pub(crate) fn in_list(list: &Path) -> Result<Vec<PathBuf>> {
    let text = read_text(list)?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let paths: Vec<PathBuf> = names_in(list, &text)?.into_iter().map(|name| stand_in(folder.join(name))).collect();
    match paths.iter().find(|path| is_endless(path)) {
        Some(path) => Err(Failure::about(list.display(), format_args!("names {}, which is no file", path.display()))),
        None => Ok(paths),
    }
}

/// Whether something is there that may have no end: a pipe or a device.
pub fn is_endless(path: &Path) -> bool {
    path.exists() && !path.is_file()
}

/// The file names in such a list, which is called `list` in errors.
pub(crate) fn names_in<'a>(list: &Path, text: &'a str) -> Result<Vec<&'a str>> {
    let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty());
    let first = lines.next().and_then(|l| l.split_whitespace().next()?.parse::<usize>().ok());
    let count = first.ok_or_else(|| {
        Failure::about(list.display(), "is not a .bmf list (expected the number of images on its first line)")
    })?;
    let names: Vec<&str> = lines.collect();
    if names.is_empty() || names.len() < count {
        return Err(Failure::about(
            list.display(),
            format_args!("names {} images (expected {count}, as its first line says)", names.len()),
        ));
    }
    Ok(names)
}

/// `path`, or if there is no such file one of the same stem and another image extension.
fn stand_in(path: PathBuf) -> PathBuf {
    if path.exists() {
        return path;
    }
    EXTENSIONS.iter().map(|e| path.with_extension(e)).find(|p| p.exists()).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_sort_by_the_numbers_in_them() {
        let sorted = ["1.png", "02.png", "2.png", "10.png", "a1_2.png", "a1_10.png", "a2_1.png", "b.png"];
        let mut names = sorted;
        names.reverse();
        names.sort_by_cached_key(|name| name_key(name));
        assert_eq!(names, sorted);
    }
}
