//! The one error type. Every message names the offending value and what is legal.

use std::fmt;

/// Longest accepted side of a frame, in pixels: twice the width of an 8K frame, rounded up to a power of two.
pub const MAX_SIDE: usize = 16_384;
/// Largest accepted number of pixels of one frame unless `clip.max_pixels` sets another: twice an 8K frame.
pub const MAX_PIXELS: usize = 1 << 26;

/// True in the wasm modules for JavaScript, whose errors have the names that its users set.
pub(crate) const IS_JAVASCRIPT: bool = cfg!(all(target_arch = "wasm32", feature = "wasm"));

/// The errors of this crate, grouped by cause: the input, a parameter, or the order of calls.
///
/// Degenerate but legal input (a still video, a black frame) is never an error.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A frame's width or height is not in `1..=`[`MAX_SIDE`].
    FrameSize {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
    },
    /// The input is larger than a parameter allows. Checked before memory is allocated for it.
    TooLarge {
        /// The thing counted, e.g. `pixels in a frame`.
        what: &'static str,
        /// Its number.
        actual: usize,
        /// The largest number allowed.
        limit: usize,
        /// The field that sets this limit, e.g. `clip.max_pixels`.
        name: String,
    },
    /// A frame's byte count does not match its size.
    FrameBytes {
        /// Bytes that width × height × channels needs.
        expected: usize,
        /// Bytes given.
        actual: usize,
    },
    /// A frame's size differs from the first frame's.
    FrameSizeChanged {
        /// Index of the offending frame.
        index: usize,
        /// Size of the first frame.
        expected: (usize, usize),
        /// Size of this frame.
        actual: (usize, usize),
    },
    /// Fewer frames than motion needs.
    TooFewFrames {
        /// Frames given.
        got: usize,
        /// Frames needed.
        needed: usize,
    },
    /// An image file that cannot be decoded.
    Decode {
        /// The decoder's message.
        reason: String,
    },
    /// A parameter is unknown, of the wrong type, or out of range.
    Param {
        /// Its field, e.g. `flow.patch_stride`.
        name: String,
        /// The value given.
        value: String,
        /// The legal values.
        expected: String,
    },
    /// Data from outside (trajectories, files) that break their documented form.
    Data {
        /// The breach, with the value and the legal range.
        reason: String,
    },
    /// A call that the session's present state does not allow.
    State {
        /// The call, and what to do instead.
        reason: String,
    },
}

impl Error {
    /// Returns [`Error::TooLarge`] if `actual` exceeds the `limit` that the parameter `name` sets.
    pub(crate) fn check_limit(actual: usize, limit: u32, what: &'static str, field: &str) -> Result<(), Self> {
        let limit = limit as usize;
        if actual <= limit {
            return Ok(());
        }
        Err(Self::TooLarge { what, actual, limit, name: shown_name(field) })
    }

    /// Returns the error with the JSON names of parameters.
    #[doc(hidden)] // For the command line.
    #[must_use]
    pub fn in_camel_case(mut self) -> Self {
        if let Self::TooLarge { name, .. } | Self::Param { name, .. } = &mut self {
            *name = camel_case(name);
        }
        if let Self::Param { expected, .. } = &mut self {
            *expected = camel_case(expected);
        }
        self
    }

    /// Returns an [`Error::State`] with this reason.
    pub(crate) fn state(reason: &str) -> Self {
        Self::State { reason: reason.to_owned() }
    }

    /// Returns a short stable code, the same in Rust, on the command line and in JavaScript.
    pub fn code(&self) -> &'static str {
        match self {
            Self::FrameSize { .. } => "frame-size",
            Self::TooLarge { .. } => "too-large",
            Self::FrameBytes { .. } => "frame-bytes",
            Self::FrameSizeChanged { .. } => "frame-size-changed",
            Self::TooFewFrames { .. } => "too-few-frames",
            Self::Decode { .. } => "decode",
            Self::Param { .. } => "param",
            Self::Data { .. } => "data",
            Self::State { .. } => "state",
        }
    }
}

/// Returns [`Error::FrameSize`] unless both sides are in `1..=`[`MAX_SIDE`].
pub(crate) fn check_size(width: usize, height: usize) -> Result<(), Error> {
    let legal = 1..=MAX_SIDE;
    if legal.contains(&width) && legal.contains(&height) { Ok(()) } else { Err(Error::FrameSize { width, height }) }
}

/// Returns the name that an error gives to the field `section.name_of_field`: the field itself, and in the wasm module for
/// JavaScript the name that its users set.
pub(crate) fn shown_name(field: &str) -> String {
    if IS_JAVASCRIPT { camel_case(field) } else { field.to_owned() }
}

pub(crate) fn camel_case(snake_case: &str) -> String {
    let mut name = String::with_capacity(snake_case.len());
    let mut begins_word = false;
    for letter in snake_case.chars() {
        if letter != '_' {
            name.push(if begins_word { letter.to_ascii_uppercase() } else { letter });
        }
        begins_word = letter == '_';
    }
    name
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FrameSize { width, height } => {
                write!(f, "frame size {width}x{height} is not supported (each side must be 1..={MAX_SIDE})")
            }
            Self::TooLarge { what, actual, limit, name } => {
                write!(f, "{actual} {what} (expected at most {limit}; the parameter {name} sets this limit)")
            }
            Self::FrameBytes { expected, actual } => write!(f, "frame data has {actual} bytes (expected {expected})"),
            Self::FrameSizeChanged { index, expected, actual } => write!(
                f,
                "frame {index} is {}x{} (expected {}x{}, the size of the first frame)",
                actual.0, actual.1, expected.0, expected.1
            ),
            Self::TooFewFrames { got, needed } => {
                write!(f, "{got} frame(s) given (expected at least {needed}: motion needs two images)")
            }
            Self::Decode { reason } => {
                write!(f, "image cannot be decoded: {reason} (expected a whole PNG or JPEG file)")
            }
            Self::Param { name, value, expected } => write!(f, "{name} = {value} (expected {expected})"),
            Self::Data { reason } | Self::State { reason } => f.write_str(reason),
        }
    }
}

impl std::error::Error for Error {}
