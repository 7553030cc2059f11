//! Human segmentations of the Berkeley benchmark: the MATLAB files of `groundTruth/`.
//!
//! A file of level 5 holds, after a header of 128 bytes, elements of one tag (type and length) and its bytes each, most
//! often packed by zlib. The benchmark's files hold one cell array `groundTruth` with a structure for each person:
//! `Segmentation`, the number of the region that each pixel belongs to, and `Boundaries`, true on the pixels of the
//! outlines. Arrays are stored column by column. Source: "MAT-File Format", The MathWorks, 2023.

use flate2::read::ZlibDecoder;
use std::io::Read;
use std::path::Path;
use tracecut::image::{MAX_PIXELS, MAX_SIDE, Plane};
use tracecut_cli::failure::{Failure, Result, read as read_bytes};

/// The annotation of one person.
///
/// Law: both planes have the same size.
#[derive(Debug, Clone, PartialEq)]
pub struct Annotation {
    /// Number of the region of each pixel.
    pub segmentation: Plane<u16>,
    /// True for pixels on an outline.
    pub boundaries: Plane<bool>,
}

/// The annotations in the file at `path`, at least one, all of the same size.
pub(crate) fn read(path: &Path) -> Result<Vec<Annotation>> {
    parse(&read_bytes(path)?).map_err(|reason| Failure::about(path.display(), reason))
}

/// Longest element that is unpacked, in bytes: a benchmark file takes about 4 MB.
const MAX_UNPACKED: u64 = 1 << 28;
/// Deepest nesting of arrays that is followed; the benchmark's files need three.
const MAX_DEPTH: u32 = 8;

const HEADER: usize = 128;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const CLASS_CELL: u8 = 1;
const CLASS_STRUCT: u8 = 2;
/// Classes of arrays of numbers: 6 double, 7 single, 8..=15 integers of 8 to 64 bits.
const CLASS_NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;

type Parsed<T> = std::result::Result<T, String>;

/// The annotations in a file of these bytes, at least one, all of the same size.
///
/// # Errors
/// As the program says it.
pub fn parse(file: &[u8]) -> Parsed<Vec<Annotation>> {
    let elements = match file.get(HEADER - 4..HEADER) {
        Some([0, 1, b'I', b'M']) => &file[HEADER..],
        Some([1, 0, b'M', b'I']) => {
            return Err("is a MATLAB file of a big-endian machine (expected little-endian)".into());
        }
        Some(_) => return Err("is not a MATLAB file of level 5".into()),
        None => {
            return Err(format!(
                "has {} bytes (expected a MATLAB file of level 5, header of {HEADER} bytes)",
                file.len()
            ));
        }
    };
    let mut rest = Cursor(elements);
    while !rest.0.is_empty() {
        let (kind, body) = rest.element()?;
        let array = match kind {
            COMPRESSED => Cursor(&unpack(body)?).array(0)?,
            MATRIX => Array::parse(body, 0)?,
            _ => continue,
        };
        if array.name == "groundTruth"
            && let Value::Cell(people) = array.value
        {
            return annotations(&people);
        }
    }
    Err("holds no cell array `groundTruth`".into())
}

fn unpack(body: &[u8]) -> Parsed<Vec<u8>> {
    let mut bytes = Vec::new();
    ZlibDecoder::new(body)
        .take(MAX_UNPACKED)
        .read_to_end(&mut bytes)
        .map_err(|e| format!("its compressed data are broken or truncated: {e}"))?;
    Ok(bytes)
}

fn annotations(people: &[Array]) -> Parsed<Vec<Annotation>> {
    let mut annotations: Vec<Annotation> = Vec::new();
    for (k, person) in people.iter().enumerate() {
        let about = |reason: String| format!("annotation {} of {}: {reason}", k + 1, people.len());
        let annotation = Annotation {
            segmentation: person.plane("Segmentation", |v| v as u16).map_err(about)?,
            boundaries: person.plane("Boundaries", |v| v != 0.0).map_err(about)?,
        };
        let size = |p: &Annotation| (p.segmentation.width(), p.segmentation.height());
        let edges = (annotation.boundaries.width(), annotation.boundaries.height());
        let first = annotations.first().map_or(edges, size);
        if size(&annotation) != edges || first != edges {
            return Err(about(format!("its arrays differ in size from each other or from the first's {first:?}")));
        }
        annotations.push(annotation);
    }
    if annotations.is_empty() { Err("its cell array `groundTruth` is empty".into()) } else { Ok(annotations) }
}

/// A named array.
struct Array {
    name: String,
    value: Value,
}

enum Value {
    Cell(Vec<Array>),
    /// Fields of the first structure of an array of them.
    Struct(Vec<(String, Array)>),
    /// Columns of numbers; integers of more than 53 bits lose their last digits.
    Numbers {
        rows: usize,
        columns: usize,
        values: Vec<f64>,
    },
    Other,
}

impl Array {
    /// From what stands after the tag.
    fn parse(body: &[u8], depth: u32) -> Parsed<Self> {
        if body.is_empty() {
            return Ok(Self { name: String::new(), value: Value::Other });
        }
        if depth > MAX_DEPTH {
            return Err(format!("its arrays are nested deeper than {MAX_DEPTH}"));
        }
        let mut rest = Cursor(body);
        let (_, flags) = rest.element()?;
        let class = *flags.first().ok_or_else(truncated)?;
        let (_, dimensions) = rest.element()?;
        let dimensions: Vec<usize> =
            dimensions.as_chunks::<4>().0.iter().map(|&d| u32::from_le_bytes(d) as usize).collect();
        let count = dimensions.iter().try_fold(1_usize, |n, &d| n.checked_mul(d)).filter(|&n| n <= MAX_PIXELS);
        let count = count
            .ok_or_else(|| format!("has an array of size {dimensions:?} (expected {MAX_PIXELS} numbers at most)"))?;
        let name = text(rest.element()?.1);
        let value = match class {
            CLASS_CELL => Value::Cell((0..count).map(|_| rest.array(depth + 1)).collect::<Parsed<_>>()?),
            CLASS_STRUCT => Value::Struct(rest.fields(count, depth + 1)?),
            _ if CLASS_NUMBERS.contains(&class) => numbers(&mut rest, &dimensions, count)?,
            _ => Value::Other,
        };
        Ok(Self { name, value })
    }

    /// Field `name` as an image.
    fn plane<T: Copy>(&self, name: &str, convert: impl Fn(f64) -> T) -> Parsed<Plane<T>> {
        let Value::Struct(fields) = &self.value else { return Err("is not a structure".into()) };
        let field = fields.iter().find(|(n, _)| n == name).ok_or_else(|| format!("has no field `{name}`"))?;
        let Value::Numbers { rows, columns, values } = &field.1.value else {
            return Err(format!("its field `{name}` is not a matrix of numbers"));
        };
        if !(1..=MAX_SIDE).contains(rows) || !(1..=MAX_SIDE).contains(columns) {
            return Err(format!("its field `{name}` is {columns}x{rows} (expected sides in 1..={MAX_SIDE})"));
        }
        Ok(Plane::from_fn(*columns, *rows, |x, y| convert(values[x * rows + y])))
    }
}

/// Numbers may be stored in a smaller type than their array's, so the element's own type counts.
fn numbers(rest: &mut Cursor<'_>, dimensions: &[usize], count: usize) -> Parsed<Value> {
    let &[rows, columns] = dimensions else { return Ok(Value::Other) };
    let (kind, bytes) = rest.element()?;
    let values: Box<dyn ExactSizeIterator<Item = f64>> = match kind {
        1 => Box::new(bytes.iter().map(|&v| f64::from(v.cast_signed()))),
        2 => Box::new(bytes.iter().map(|&v| f64::from(v))),
        3 => Box::new(bytes.as_chunks().0.iter().map(|&v| f64::from(i16::from_le_bytes(v)))),
        4 => Box::new(bytes.as_chunks().0.iter().map(|&v| f64::from(u16::from_le_bytes(v)))),
        5 => Box::new(bytes.as_chunks().0.iter().map(|&v| f64::from(i32::from_le_bytes(v)))),
        6 => Box::new(bytes.as_chunks().0.iter().map(|&v| f64::from(u32::from_le_bytes(v)))),
        7 => Box::new(bytes.as_chunks().0.iter().map(|&v| f64::from(f32::from_le_bytes(v)))),
        9 => Box::new(bytes.as_chunks().0.iter().map(|&v| f64::from_le_bytes(v))),
        _ => return Ok(Value::Other),
    };
    // Before memory is taken: eight bytes for each, however small it is in the file.
    if values.len() != count {
        return Err(format!("has an array of {} numbers (expected {rows}x{columns})", values.len()));
    }
    Ok(Value::Numbers { rows, columns, values: values.collect() })
}

fn text(bytes: &[u8]) -> String {
    bytes.iter().take_while(|&&b| b != 0).map(|&b| char::from(b)).collect()
}

fn truncated() -> String {
    "is truncated".to_owned()
}

/// Bytes not yet read.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, length: usize) -> Parsed<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(length).ok_or_else(truncated)?;
        self.0 = rest;
        Ok(head)
    }

    fn word(&mut self) -> Parsed<u32> {
        self.take(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }

    /// Type and bytes of the next element. Short ones share eight bytes with their tag; others are filled up to a
    /// multiple of eight, except compressed ones.
    fn element(&mut self) -> Parsed<(u32, &'a [u8])> {
        let word = self.word()?;
        if word >> 16 != 0 {
            let length = (word >> 16) as usize;
            let bytes = self.take(4)?;
            return Ok((word & 0xffff, bytes.get(..length).ok_or_else(truncated)?));
        }
        let length = self.word()? as usize;
        let body = self.take(length)?;
        if word != COMPRESSED {
            let padding = length.next_multiple_of(8) - length;
            self.0 = self.0.get(padding..).unwrap_or(&[]);
        }
        Ok((word, body))
    }

    fn array(&mut self, depth: u32) -> Parsed<Array> {
        match self.element()? {
            (MATRIX, body) => Array::parse(body, depth),
            (kind, _) => Err(format!("has an element of type {kind} where an array (type {MATRIX}) should be")),
        }
    }

    /// Names and values of the fields of the first of `count` structures.
    fn fields(&mut self, count: usize, depth: u32) -> Parsed<Vec<(String, Array)>> {
        let (_, length) = self.element()?;
        let &[a, b, c, d] = length else { return Err("has a structure without a length of its field names".into()) };
        let length = u32::from_le_bytes([a, b, c, d]).max(1) as usize;
        let names: Vec<String> = self.element()?.1.chunks(length).map(text).collect();
        if count == 0 {
            return Ok(Vec::new());
        }
        names.into_iter().map(|name| Ok((name, self.array(depth)?))).collect()
    }
}
