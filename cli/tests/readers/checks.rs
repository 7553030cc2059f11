//! Readers of the command line: any bytes give an error or a valid value. The fuzz targets call them too.

use tracecut::image::Frame;
use tracecut_cli::readers;

/// Frames that are read of a stream at most: cost grows with them.
const MOST: usize = 20;

fn check_frames(frames: Result<Vec<Frame>, String>) {
    match frames {
        Ok(frames) => {
            let whole = |frame: &Frame| frame.rgb().len() == 3 * frame.width() * frame.height();
            assert!(frames.len() <= MOST && frames.iter().all(whole));
        }
        Err(reason) => assert!(!reason.is_empty()),
    }
}

/// An animated GIF, PNG or WebP.
pub fn animation(bytes: &[u8]) {
    check_frames(readers::animation(bytes, MOST));
}

/// Y4M. All frames of a stream have one size.
pub fn y4m(bytes: &[u8]) {
    let frames = readers::y4m(bytes, MOST);
    if let Ok([first, others @ ..]) = frames.as_deref() {
        assert!(others.iter().all(|f| (f.width(), f.height()) == (first.width(), first.height())));
    }
    check_frames(frames);
}

/// A `.bmf` list.
pub fn bmf(bytes: &[u8]) {
    let Ok(names) = readers::list(&String::from_utf8_lossy(bytes)) else { return };
    assert!(!names.is_empty() && names.iter().all(|name| !name.is_empty() && name.trim() == name));
}

/// A setting: what was taken is legal.
pub fn setting(bytes: &[u8]) {
    if let Ok(params) = readers::setting(&String::from_utf8_lossy(bytes)) {
        params.validate().unwrap();
    }
}

/// Parameters of a file: what was taken is legal.
pub fn parameters(bytes: &[u8]) {
    if let Ok(params) = readers::parameters(&String::from_utf8_lossy(bytes)) {
        params.validate().unwrap();
    }
}
