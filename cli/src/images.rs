//! Which image files make up a clip.

use crate::failure::{Failure, Result, cannot_read, read_text};
use std::path::{Path, PathBuf};

/// Images taken from a folder. Masks in other formats may lie beside them.
const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "ppm"];

/// The images of a folder in the order of their names, as a person would put them. Hidden files are none: names that begin
/// with a point, such as the `._1.jpg` that a Mac writes beside `1.jpg`.
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

/// Part of a file name: a run of digits, by its value, or another character in small letters, before or after digits.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Sign(char),
    Number { length: usize, digits: String },
    Letter(char),
}

/// Key that file names are sorted by; the name itself decides between `1.png` and `01.png`. Package and Python have the
/// same order.
fn name_key(name: &str) -> (Vec<Part>, String) {
    let small = name.to_lowercase();
    let (mut parts, mut rest) = (Vec::new(), small.as_str());
    while let Some(first) = rest.chars().next() {
        let after = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        if after.len() < rest.len() {
            let digits = rest[..rest.len() - after.len()].trim_start_matches('0');
            parts.push(Part::Number { length: digits.len(), digits: digits.to_owned() });
            rest = after;
        } else {
            parts.push(if first < '0' { Part::Sign(first) } else { Part::Letter(first) });
            rest = &rest[first.len_utf8()..];
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
