//! Folders and lists of image files.

use crate::failure::{Failure, Result, cannot_read, read_text};
use std::path::{Path, PathBuf};

/// File extensions of the images in a folder. Masks in other formats may lie beside them.
const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "ppm"];

/// Returns the images of a folder in natural order of their names. Hidden files, such as the `._1.jpg` that a Mac writes beside
/// `1.jpg`, are left out.
pub fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let cannot = |e| cannot_read(folder, &e);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.is_file() && has_image_extension(&path) && !file_name(&path).starts_with('.') {
            paths.push(path);
        }
    }
    if paths.is_empty() {
        return Err(Failure::about(folder.display(), "has no images (expected PNG, JPEG or PPM files, one per frame)"));
    }
    paths.sort_by_cached_key(|path| name_key(&file_name(path)));
    Ok(paths)
}

fn has_image_extension(path: &Path) -> bool {
    path.extension().is_some_and(|e| EXTENSIONS.iter().any(|extension| e.eq_ignore_ascii_case(extension)))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Part of a sort key: a run of digits, by its value, or another character in lower case, sorted before or after digits.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum NamePart {
    Sign(char),
    Number { length: usize, digits: String },
    Letter(char),
}

/// Returns the sort key of a file name; the name itself decides between `1.png` and `01.png`. The packages for JavaScript and
/// Python have the same order.
fn name_key(name: &str) -> (Vec<NamePart>, String) {
    let small = name.to_lowercase();
    let (mut parts, mut rest) = (Vec::new(), small.as_str());
    while let Some(first) = rest.chars().next() {
        let after = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        if after.len() < rest.len() {
            let digits = rest[..rest.len() - after.len()].trim_start_matches('0');
            parts.push(NamePart::Number { length: digits.len(), digits: digits.to_owned() });
            rest = after;
        } else {
            parts.push(if first < '0' { NamePart::Sign(first) } else { NamePart::Letter(first) });
            rest = &rest[first.len_utf8()..];
        }
    }
    (parts, name.to_owned())
}

/// Returns the images in a `.bmf` list: a first line of counts, then one file name per line, relative to the list.
///
/// Names may lead to any file that the caller may read. Devices and pipes, which may never end, are errors.
///
/// Lists of the Moseg benchmark have `.ppm` names for `.jpg` files; a file of the same stem is used instead.
pub fn in_list(list: &Path) -> Result<Vec<PathBuf>> {
    let text = read_text(list)?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let paths: Vec<PathBuf> = names_in(list, &text)?.into_iter().map(|name| stand_in(folder.join(name))).collect();
    match paths.iter().find(|path| is_endless(path)) {
        Some(path) => Err(Failure::about(list.display(), format_args!("has {}, which is not a file", path.display()))),
        None => Ok(paths),
    }
}

/// Returns whether a path is a pipe or a device, which may never end.
pub fn is_endless(path: &Path) -> bool {
    path.exists() && !path.is_file()
}

/// Returns the file names in a list, which is called `list` in errors.
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

/// Returns `path` if it exists, or else a file of the same stem with another image extension.
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
        let sorted = [
            "1.png",
            "02.png",
            "2.png",
            "10.png",
            "a-3.png",
            "a.png",
            "a1.png",
            "a1_2.png",
            "A1_10.png",
            "a2_1.png",
            "b.png",
            "IMG_2.JPG",
            "IMG_2.jpg",
            "img_3.jpg",
            "IMG_10.jpg",
            "img_a.jpg",
        ];
        let mut names = sorted;
        names.reverse();
        names.sort_by_cached_key(|name| name_key(name));
        assert_eq!(names, sorted);
    }
}
