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

#[cfg(test)]
mod tests {
    use crate::helpers::seeds::{Reader, of_target, read_with_faults};

    const READERS: [Reader; 5] = [
        ("animation", super::animation),
        ("y4m", super::y4m),
        ("bmf", super::bmf),
        ("setting", super::setting),
        ("parameters", super::parameters),
    ];

    #[test]
    fn files_with_faults_give_an_error_or_a_valid_value() {
        read_with_faults(&READERS, 0..4000);
    }

    /// Found by fuzzing: the size of the picture was checked, the size of its frames was not.
    #[test]
    fn a_frame_that_claims_to_be_larger_than_its_gif_takes_no_memory() {
        let (_, whole) = of_target("animation").into_iter().rfind(|(name, _)| name.ends_with(".gif")).unwrap();
        let at = whole.windows(9).position(|b| b == [0x2c, 0, 0, 0, 0, 4, 0, 3, 0]).unwrap();
        let mut bytes = whole.clone();
        bytes[at + 5..at + 9].fill(0xff);
        let reason = tracecut_cli::readers::animation(&bytes, 9).unwrap_err();
        assert!(reason.contains("frame 0 cannot be decoded: Memory limit exceeded"), "{reason}");
    }

    #[test]
    #[ignore = "a minute; part of npm run test:long"]
    fn many_more_files_with_faults() {
        read_with_faults(&READERS, 4000..204_000);
    }

    #[test]
    fn seed_files_are_valid() {
        use tracecut_cli::readers;
        for (target, files) in
            [("animation", 4), ("y4m", 4), ("bmf", 1), ("setting", 2)].map(|(t, n)| (t, (n, of_target(t))))
        {
            assert_eq!(files.1.len(), files.0, "{target}");
            for (name, bytes) in files.1 {
                let text = String::from_utf8_lossy(&bytes);
                let read = match target {
                    "animation" => readers::animation(&bytes, 9).map(|frames| frames.len()),
                    "y4m" => readers::y4m(&bytes, 9).map(|frames| frames.len()),
                    "bmf" => readers::list(&text).map(|names| names.len()),
                    _ => readers::setting(&text).map(|_| 1),
                };
                assert!(read.as_ref().is_ok_and(|&count| count > 0), "{name}: {read:?}");
            }
        }
    }
}
