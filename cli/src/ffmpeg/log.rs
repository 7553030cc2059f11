//! Messages that `ffmpeg` logs while it decodes (`-loglevel level+info -debug_ts`, filter `showinfo`).
//!
//! Checked with ffmpeg 5.1 and 9. Threads of `ffmpeg` write at once: one may begin a message on the line of another,
//! but the words looked for here are never torn.

/// A message about the pictures.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Message {
    /// The next packet of the track was read from the file.
    PacketRead,
    /// Reading the file failed. `is_end` where the words say so themselves.
    ReadingFailed {
        is_end: bool,
    },
    /// A packet could not be decoded.
    DecodingFailed,
    /// The next decoded picture has faults.
    PictureIsFaulty,
    PictureDecoded,
    /// A picture is next on standard output.
    Shown(ShownPicture),
    NoDecoder,
    UnknownOption,
}

/// A picture as the filters give it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ShownPicture {
    /// Counts from 0.
    pub(super) index: usize,
    /// Presentation time of the file, in seconds.
    pub(super) time: Option<f64>,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) is_key: bool,
}

/// A unit of time: `numerator / denominator` seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeBase {
    numerator: f64,
    denominator: f64,
}

impl TimeBase {
    /// Parses `1/90000`.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (numerator, denominator) = text.split_once('/')?;
        let base = Self { numerator: numerator.parse().ok()?, denominator: denominator.parse().ok()? };
        (base.numerator > 0.0 && base.denominator > 0.0).then_some(base)
    }

    pub(super) fn seconds(self, ticks: i64) -> f64 {
        ticks as f64 * self.numerator / self.denominator
    }
}

/// Reads the log line by line.
#[derive(Debug)]
pub(super) struct LogReader {
    /// Begins the messages of the demuxer in ffmpeg 5 and 6: `[matroska,webm @`.
    demuxer: String,
    time_base: Option<TimeBase>,
}

/// Begins the messages of the demuxer from ffmpeg 7 on.
const DEMUXER: &str = "[in#0";
const SHOWINFO: &str = "[Parsed_showinfo";

/// Texts of demuxers at an unexpected end of the file.
const END_TEXTS: [&str; 4] =
    ["ended prematurely", "partial file", "exceeds containing master element", "invalid as first byte of an EBML"];

impl LogReader {
    /// Reads the log about a file that `demuxer` reads, as ffmpeg names it.
    pub(super) fn new(demuxer: &str) -> Self {
        Self { demuxer: format!("[{demuxer} @"), time_base: None }
    }

    /// Returns the messages of a line in their order.
    pub(super) fn read_line(&mut self, line: &str) -> Vec<Message> {
        let mut messages: Vec<(usize, Message)> = Vec::new();
        for (text, message) in [
            ("demuxer -> ", Message::PacketRead),
            ("decoder -> ", Message::PictureDecoded),
            ("corrupt decoded frame", Message::PictureIsFaulty),
            ("Error while decoding stream", Message::DecodingFailed),
            ("Decoding error:", Message::DecodingFailed),
            ("Error submitting packet to decoder:", Message::DecodingFailed),
            ("no decoder found for", Message::NoDecoder),
            ("not found for input stream", Message::NoDecoder),
            ("Unrecognized option", Message::UnknownOption),
        ] {
            messages.extend(line.match_indices(text).map(|(at, _)| (at, message.clone())));
        }
        for prefix in [DEMUXER, self.demuxer.as_str()] {
            let errors = line.match_indices(prefix).filter(|&(at, _)| is_error(&line[at..]));
            let is_end = END_TEXTS.iter().any(|text| line.contains(text));
            messages.extend(errors.map(|(at, _)| (at, Message::ReadingFailed { is_end })));
        }
        if line.starts_with("[error] file:") {
            messages.push((0, Message::ReadingFailed { is_end: false }));
        }
        for (at, _) in line.match_indices(SHOWINFO) {
            let text = &line[at + SHOWINFO.len()..];
            let text = text.find(SHOWINFO).map_or(text, |next| &text[..next]);
            if let Some((_, base)) = text.split_once("config in time_base: ") {
                self.time_base = base.split(',').next().and_then(TimeBase::parse);
            }
            messages.extend(self.parse_picture(text).map(|picture| (at, Message::Shown(picture))));
        }
        messages.sort_by_key(|&(at, _)| at);
        messages.into_iter().map(|(_, message)| message).collect()
    }

    /// Parses `n:   0 pts:   1024 pts_time:0.08 ... s:240x180 i:P iskey:1 ...`.
    fn parse_picture(&self, text: &str) -> Option<ShownPicture> {
        let (width, height) = value(text, " s:")?.split_once('x')?;
        let ticks = value(text, " pts:")?.parse().ok();
        Some(ShownPicture {
            index: value(text, " n:")?.parse().ok()?,
            time: ticks.and_then(|ticks| self.time_base.map(|base| base.seconds(ticks))),
            width: width.parse().ok()?,
            height: height.parse().ok()?,
            is_key: value(text, " iskey:") == Some("1"),
        })
    }
}

/// Returns the word after `name`.
fn value<'a>(words: &'a str, name: &str) -> Option<&'a str> {
    words.split_once(name)?.1.split_whitespace().next()
}

/// Returns whether a message that begins with the name of who says it, `[name @ 0x12] [error] ...`, is an error.
fn is_error(message: &str) -> bool {
    let text = message.split_once("] ").map_or("", |(_, text)| text);
    text.starts_with("[error]") || text.starts_with("[fatal]")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(lines: &[&str]) -> Vec<Message> {
        let mut log = LogReader::new("matroska,webm");
        lines.iter().flat_map(|line| log.read_line(line)).collect()
    }

    const CONFIG: &str = "[Parsed_showinfo_3 @ 0x1] [info] config in time_base: 1/1000, frame_rate: 25/1";

    #[test]
    fn pictures_have_times_sizes_and_keys() {
        let shown = "[Parsed_showinfo_3 @ 0x1] [info] n:  12 pts:    306 pts_time:0.306   pos:  485 fmt:rgb24 sar:1/1 \
            s:240x180 i:P iskey:1 type:I ";
        let expected = ShownPicture { index: 12, time: Some(0.306), width: 240, height: 180, is_key: true };
        assert_eq!(messages(&[CONFIG, shown]), [Message::Shown(expected)]);
        let newer = "[Parsed_showinfo_3 @ 0x1] [info] n:   0 pts:  NOPTS pts_time:NOPTS duration:     40 \
            duration_time:0.04    fmt:rgb24 cl:left sar:1/1 s:240x180 i:P iskey:0 type:B ";
        let expected = ShownPicture { index: 0, time: None, width: 240, height: 180, is_key: false };
        assert_eq!(messages(&[CONFIG, newer]), [Message::Shown(expected)]);
        assert_eq!(messages(&["[Parsed_showinfo_3 @ 0x1] [info] color_range:tv color_space:unknown"]), []);
    }

    #[test]
    fn messages_on_one_line_keep_their_order() {
        let torn = "[Parsed_showinfo_3 @ 0x1] [info] n:   1 pts:     40 pts_time:0.04 sar:1/1 s:4x2 i:P iskey:0 type:B \
            [vist#0:0/h264 @ 0x2] [dec:h264 @ 0x3] [warning] corrupt decoded frame";
        let shown = ShownPicture { index: 1, time: Some(0.04), width: 4, height: 2, is_key: false };
        assert_eq!(messages(&[CONFIG, torn]), [Message::Shown(shown), Message::PictureIsFaulty]);
        let other = "[info] color_range:tv[vist#0:0/h264 @ 0x2] [info] demuxer -> ist_index:0:0 type:video pkt_pts:0";
        assert_eq!(messages(&[other]), [Message::PacketRead]);
        assert_eq!(messages(&["[info] demuxer+ffmpeg -> ist_index:0 type:video"]), []);
    }

    #[test]
    fn only_errors_of_the_demuxer_are_errors_of_reading() {
        let end = Message::ReadingFailed { is_end: true };
        assert_eq!(messages(&["[matroska,webm @ 0x1] [error] File ended prematurely"]), [end]);
        let newer = "[in#0/matroska,webm @ 0x1] [error] File ended prematurely";
        assert_eq!(messages(&[newer]), messages(&[newer.replace("in#0/", "").as_str()]));
        for message in ["[in#0/matroska,webm @ 0x1] [error] Seek failed", "[error] file:a.mkv: Input/output error"] {
            assert_eq!(messages(&[message]), [Message::ReadingFailed { is_end: false }], "{message}");
        }
        for harmless in [
            "[matroska,webm @ 0x1] [warning] Packet corrupt (stream = 0, dts = 3072).",
            "[h264 @ 0x1] [error] mmco: unref short failure",
            "[NULL @ 0x1] [error] Invalid NAL unit size (23238 > 9633).",
            "[vist#0:0/h264 @ 0x1] [info] Output #0, rawvideo, to 'pipe:':",
        ] {
            assert_eq!(messages(&[harmless]), [], "{harmless}");
        }
    }

    #[test]
    fn failures_of_decoding_have_the_words_of_each_version() {
        for line in [
            "[error] Error while decoding stream #0:0: Invalid data found when processing input",
            "[dec:h264 @ 0x1] [error] Decoding error: Invalid data found when processing input",
            "[dec:h264 @ 0x1] [error] Error submitting packet to decoder: Invalid data found when processing input",
        ] {
            assert_eq!(messages(&[line]), [Message::DecodingFailed], "{line}");
        }
        let five = "Decoder (codec none) not found for input stream #0:0";
        let nine = "Decoding requested, but no decoder found for: av1";
        assert_eq!(messages(&[five, nine]), [Message::NoDecoder, Message::NoDecoder]);
    }
}
