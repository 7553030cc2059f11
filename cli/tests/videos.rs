//! Files of many kinds, read frame by frame: what is damaged, cut off or odd. `tests/intake.mjs` has what every language must
//! give; here is what only the reader of the command line can show.

use crate::helpers::{folder, text};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tracecut_cli::failure::{Damage, Failure, Kind};
use tracecut_cli::input::{ClipFrame, Input};

/// Pictures of the clip that most tests store.
const COUNT: usize = 16;
/// A moving pattern, with key pictures four apart.
const PATTERN: &str = "-f lavfi -i testsrc2=s=160x120:r=25 -frames:v 16";
const H264: &str = "-c:v libx264 -crf 20 -pix_fmt yuv420p -g 4";

/// Runs ffmpeg in a folder with arguments that hold no spaces; returns whether there is one.
pub(crate) fn ffmpeg(folder: &Path, line: &str) -> bool {
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-nostdin", "-y"]).args(line.split(' ')).current_dir(folder);
    match command.output() {
        Ok(output) => assert!(output.status.success(), "{line}: {}", text(&output.stderr)),
        Err(e) => {
            println!("skipped: no ffmpeg ({e})");
            return false;
        }
    }
    true
}

/// What a file gives: whole frames, and the failure after them.
#[derive(Debug)]
struct Outcome {
    frames: Vec<ClipFrame>,
    failure: Option<Failure>,
}

impl Outcome {
    fn of(path: &Path, count: Option<u32>) -> Self {
        let (mut frames, mut failure) = (Vec::new(), None);
        match Input::open(path, count).and_then(|input| input.frames()) {
            Err(e) => failure = Some(e),
            Ok(read) => read.for_each(|frame| match frame {
                Ok(frame) => frames.push(frame),
                Err(e) => assert!(failure.replace(e).is_none(), "more comes after a failure"),
            }),
        }
        Self { frames, failure }
    }

    fn times(&self) -> Vec<f64> {
        self.frames.iter().map(|frame| (frame.timing.unwrap().time * 1e4).round() / 1e4).collect()
    }

    /// Fails unless all frames of a file were read; returns them.
    fn whole(path: &Path) -> Self {
        let outcome = Self::of(path, None);
        assert!(outcome.failure.is_none(), "{}: {:?}", path.display(), outcome.failure);
        outcome
    }

    /// Fails unless exactly the first `count` frames of `whole` were read, and damage was told after them.
    fn assert_damaged(&self, whole: &Self, count: usize, name: &str) {
        let damage = self.failure.as_ref().and_then(|failure| failure.damage.as_ref());
        assert_eq!(damage.map(|damage| damage.frames), Some(count), "{name}: {:?}", self.failure);
        assert_eq!(self.frames.len(), count, "{name}");
        for (one, other) in self.frames.iter().zip(&whole.frames) {
            assert!(one.frame == other.frame, "{name}: {} differs", one.name);
        }
        assert_eq!(self.times(), whole.times()[..count], "{name}");
    }

    /// The words of a file that gives nothing.
    fn refusal(path: &Path) -> (Kind, String) {
        let Self { frames, failure } = Self::of(path, None);
        assert_eq!(frames.len(), 0, "{}", path.display());
        let failure = failure.unwrap();
        assert_eq!(failure.damage, None);
        (failure.kind, failure.reason)
    }
}

/// The file with another name in whose bytes something was changed.
fn changed(path: &Path, name: &str, change: impl FnOnce(&mut Vec<u8>)) -> PathBuf {
    let mut bytes = fs::read(path).unwrap();
    change(&mut bytes);
    let path = path.with_file_name(name);
    fs::write(&path, bytes).unwrap();
    path
}

/// Place of the first `words` from `share` of the file on.
fn place_of(bytes: &[u8], words: &[u8], share: f64) -> usize {
    let from = (bytes.len() as f64 * share) as usize;
    from + bytes[from..].windows(words.len()).position(|found| found == words).unwrap()
}

fn largest_difference(one: &ClipFrame, other: &ClipFrame) -> u8 {
    one.frame.rgb().iter().zip(other.frame.rgb()).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn files_that_are_cut_off_give_what_is_whole() {
    let folder = folder("videos-cut");
    for (name, codec) in [
        ("index-in-front.mp4", &format!("{H264} -movflags +faststart")),
        ("fragments.mp4", &format!("{H264} -movflags frag_keyframe+empty_moov")),
        ("h264.mkv", &H264.to_owned()),
        ("h264.ts", &H264.to_owned()),
        ("h264.flv", &H264.to_owned()),
        ("mpeg4.avi", &"-c:v mpeg4 -g 4 -b:v 900k".to_owned()),
        ("mpeg2.mpg", &"-c:v mpeg2video -g 4 -b:v 900k".to_owned()),
        ("vp9.webm", &"-c:v libvpx-vp9 -g 4 -b:v 900k -pix_fmt yuv420p".to_owned()),
    ] {
        if !ffmpeg(&folder, &format!("{PATTERN} {codec} {name}")) {
            return;
        }
        let whole = Outcome::whole(&folder.join(name));
        assert_eq!(whole.frames.len(), COUNT, "{name}");
        let cut = changed(&folder.join(name), &format!("cut-{name}"), |bytes| bytes.truncate(bytes.len() * 7 / 10));
        let outcome = Outcome::of(&cut, None);
        let count = outcome.frames.len();
        assert!((8..COUNT).contains(&count), "{name}: {count} frames");
        outcome.assert_damaged(&whole, count, name);
        assert_eq!(outcome.failure.unwrap().kind, Kind::Input);
        // Who wants only what is whole is not told.
        let first = Outcome::of(&cut, Some(count as u32 - 1));
        assert!(first.failure.is_none() && first.frames.len() == count - 1, "{name}: {:?}", first.failure);
    }
}

#[test]
fn damage_in_the_middle_ends_a_clip_before_the_first_wrong_picture() {
    let folder = folder("videos-hole");
    let streams = [format!("{H264} fast.mp4"), format!("{H264} -bf 0 whole.ts"), format!("{H264} -bf 2 whole.mkv")];
    if !streams.iter().all(|line| ffmpeg(&folder, &format!("{PATTERN} {line}"))) {
        return;
    }
    // The ninth picture is the third key picture.
    let mp4 = folder.join("fast.mp4");
    let key = |bytes: &[u8]| {
        let sizes = place_of(bytes, b"stsz", 0.0) + 16;
        let size = |k: usize| u32::from_be_bytes(bytes[sizes + 4 * k..][..4].try_into().unwrap()) as usize;
        place_of(bytes, b"mdat", 0.0) + 4 + (0..8).map(size).sum::<usize>()
    };
    let hole = changed(&mp4, "hole.mp4", |bytes| {
        let at = key(bytes) + 200;
        bytes[at..at + 400].fill(0x55);
    });
    Outcome::of(&hole, None).assert_damaged(&Outcome::whole(&mp4), 8, "a hole in a key picture");

    let ts = folder.join("whole.ts");
    let lost = changed(&ts, "lost.ts", |bytes| {
        let packets = bytes.len() / 188;
        bytes.drain(packets / 2 * 188..(packets / 2 + 8) * 188);
    });
    let outcome = Outcome::of(&lost, None);
    outcome.assert_damaged(&Outcome::whole(&ts), outcome.frames.len(), "packets that are lost");
    assert!(outcome.frames.len() >= 4, "{} frames", outcome.frames.len());

    let nothing = changed(&folder.join("whole.mkv"), "first.mkv", |bytes| {
        let at = bytes.len() / 12;
        bytes[at..at + 400].fill(0x55);
    });
    let outcome = Outcome::of(&nothing, None);
    // Pictures up to the next key picture are made of the wrong one.
    let whole = Outcome::whole(&folder.join("whole.mkv"));
    assert!(outcome.frames[0].frame == whole.frames[4].frame && outcome.failure.is_none(), "{:?}", outcome.failure);
    assert_eq!(outcome.times(), whole.times()[4..]);
}

#[test]
fn pictures_that_a_file_has_lost_are_missed_at_their_place() {
    let folder = folder("videos-lost");
    let pattern = "-f lavfi -i testsrc2=s=160x120:r=25:d=6 -f lavfi -i sine=d=6";
    if !ffmpeg(
        &folder,
        &format!("{pattern} -c:v libvpx -g 25 -b:v 300k -c:a libvorbis -cluster_time_limit 1000 a.webm"),
    ) {
        return;
    }
    let file = folder.join("a.webm");
    let lost = changed(&file, "lost.webm", |bytes| {
        let at = bytes.len() / 2;
        bytes.drain(at..at + 3000);
    });
    let (whole, outcome) = (Outcome::whole(&file), Outcome::of(&lost, None));
    assert_eq!(whole.frames.len(), 150);
    let count = outcome.frames.len();
    assert!((60..100).contains(&count), "{count} frames");
    assert_eq!(outcome.failure.unwrap().damage.map(|Damage { frames, .. }| frames), Some(count));
    assert_eq!(outcome.frames.last().unwrap().timing.unwrap().time, whole.frames[count - 1].timing.unwrap().time);
}

#[test]
fn streams_that_begin_between_key_pictures_are_whole_from_the_first_one_on() {
    let folder = folder("videos-begin");
    if !ffmpeg(&folder, &format!("{PATTERN} {H264} -bf 0 whole.ts")) {
        return;
    }
    let whole = Outcome::whole(&folder.join("whole.ts"));
    let late = changed(&folder.join("whole.ts"), "late.ts", |bytes| {
        let packets = bytes.len() / 188;
        bytes.drain(..packets * 3 / 10 * 188);
    });
    let outcome = Outcome::whole(&late);
    let first = COUNT - outcome.frames.len();
    assert!(first > 0 && first.is_multiple_of(4), "it begins with picture {first}");
    assert!(outcome.frames[0].frame == whole.frames[first].frame);
    assert_eq!(outcome.times(), whole.times()[first..]);
}

#[test]
fn times_are_the_files_own_and_mended_where_they_are_equal_or_missing() {
    let folder = folder("videos-times");
    if !ffmpeg(&folder, &format!("{PATTERN} -c:v mjpeg plain.mkv")) {
        return;
    }
    ffmpeg(&folder, r"-i plain.mkv -c copy -bsf:v setts=ts=if(eq(N\,3)\,80\,TS) equal.mkv");
    let equal = Outcome::whole(&folder.join("equal.mkv"));
    assert_eq!(equal.times()[..6], [0.0, 0.04, 0.08, 0.12, 0.16, 0.2]);
    assert_eq!(equal.frames.len(), COUNT);

    ffmpeg(&folder, &format!("{PATTERN} {H264} none.h264"));
    let none = Outcome::whole(&folder.join("none.h264"));
    assert_eq!((none.frames.len(), none.times()[15]), (COUNT, 0.6));

    ffmpeg(&folder, &format!("{PATTERN} {H264} -bf 0 -g 1 keys.mp4"));
    ffmpeg(&folder, "-ss 0.2 -i keys.mp4 -c copy edited.mp4");
    let (keys, edited) = (Outcome::whole(&folder.join("keys.mp4")), Outcome::whole(&folder.join("edited.mp4")));
    assert_eq!((edited.frames.len(), edited.times()[0]), (11, 0.0));
    assert!(edited.frames[0].frame == keys.frames[5].frame);
    let input = Input::open(&folder.join("edited.mp4"), None).unwrap();
    assert_eq!(input.num_frames(), Some(11));
    assert_eq!(Input::open(&folder.join("edited.mp4"), Some(3)).unwrap().num_frames(), Some(3));
}

#[test]
fn a_file_is_what_its_bytes_say_whatever_its_name() {
    let folder = folder("videos-kind");
    if !ffmpeg(&folder, &format!("{PATTERN} {H264} plain.mp4")) {
        return;
    }
    let expected = Outcome::whole(&folder.join("plain.mp4"));
    for name in ["plain.png", "plain.txt", "plain.bmp", "plain", "-v", "a%03d, b: c|d.gif"] {
        fs::copy(folder.join("plain.mp4"), folder.join(name)).unwrap();
        let outcome = Outcome::whole(&folder.join(name));
        assert!(outcome.frames.len() == COUNT && outcome.frames[9].frame == expected.frames[9].frame, "{name}");
    }
    ffmpeg(&folder, "-f lavfi -i testsrc2=s=160x120 -frames:v 1 -update 1 one.png");
    ffmpeg(&folder, "-i one.png one.jpg");
    ffmpeg(&folder, "-i one.png -c:v libx264 one.mp4");
    for name in ["one.png", "one.jpg"] {
        let renamed = folder.join(name).with_extension(format!("{name}.mp4"));
        fs::rename(folder.join(name), &renamed).unwrap();
        let (kind, reason) = Outcome::refusal(&renamed);
        assert!(kind == Kind::Input && reason.contains("is a single picture"), "{reason}");
    }
    assert_eq!(Outcome::whole(&folder.join("one.mp4")).frames.len(), 1);
    for (name, bytes, words) in [
        ("words.mp4", &b"Only words.\n"[..], "is not a video"),
        ("words.nfo", b"\x1b[31mOnly words, in colours.\n\x1b[0m", "is not a video"),
        ("numbers.webm", &[7; 4000], "is not a video"),
        ("empty.webm", b"", "is empty"),
        ("index.mp4", b"\0\0\0\x18ftypisom\0\0\x02\0isomavc1\0\0\x10\0mdat", "is cut off"),
        ("broken.webp", b"RIFF\x24\0\0\0WEBPVP8X", "is not a whole WebP"),
    ] {
        fs::write(folder.join(name), bytes).unwrap();
        let (kind, reason) = Outcome::refusal(&folder.join(name));
        assert!(kind == Kind::Input && reason.contains(words) && reason.contains(name), "{reason}");
    }
    ffmpeg(&folder, "-f lavfi -i sine=d=0.3 -c:a aac sound.m4a");
    ffmpeg(&folder, "-i sound.m4a -i one.mp4 -map 0 -map 1 -c:a copy -c:v mjpeg -disposition:v attached_pic cover.m4a");
    for name in ["sound.m4a", "cover.m4a"] {
        assert!(Outcome::refusal(&folder.join(name)).1.contains("has no video track"), "{name}");
    }
}

#[test]
fn the_pipe_that_is_told_where_there_is_no_ffmpeg_gives_the_same_colours() {
    let folder = folder("videos-pipe");
    let colours = "-vf scale=out_color_matrix=bt709:out_range=tv,format=yuv444p -colorspace bt709 -color_range tv";
    if !ffmpeg(&folder, &format!("{PATTERN} {colours} -c:v ffv1 bt709.mkv")) {
        return;
    }
    let (file, program) = (folder.join("bt709.mkv"), env!("CARGO_BIN_EXE_tracecut"));
    let without = Command::new(program).args(["segment", "--out", "out"]).arg(&file).env("PATH", "").output().unwrap();
    let words = text(&without.stderr);
    assert_eq!(without.status.code(), Some(1), "{words}");
    let command = words.split_once("machine that has it: ").unwrap().1.split_once(" | tracecut segment -").unwrap().0;
    let arguments = command.strip_prefix("ffmpeg ").unwrap().split(' ');
    let y4m = Command::new("ffmpeg").args(["-v", "error"]).args(arguments).output().unwrap();
    fs::write(folder.join("piped.y4m"), y4m.stdout).unwrap();
    let (direct, piped) = (Outcome::whole(&file), Outcome::whole(&folder.join("piped.y4m")));
    assert_eq!(direct.times(), piped.times());
    for (one, other) in direct.frames.iter().zip(&piped.frames) {
        let most = largest_difference(one, other);
        assert!(most <= 6, "{} differs by {most}", one.name);
    }
}

#[cfg(unix)]
#[test]
fn an_old_ffmpeg_and_one_that_lacks_a_decoder_are_named() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("videos-old");
    fs::write(folder.join("clip.mp4"), [7; 100]).unwrap();
    let list = "echo '[info] Input #0, mov, from x:' >&2; echo '[info]   Stream #0:0: Video: av1 (default)' >&2; \
        echo '#tb 0: 1/25'; echo '#codec_id 0: av1'; echo '0, 0, 0, 1, 9, 0x0'; echo '0, 1, 1, 1, 9, 0x0'";
    for (says, code, words) in [
        ("Unrecognized option 'fps_mode'.", 1, "too old (expected 5.1 or later)"),
        ("[error] Decoding requested, but no decoder found for: av1", 3, "has no decoder for its video (av1)"),
        ("[dec:av1 @ 0x1] [error] Error submitting packet to decoder: Invalid data", 3, "can be decoded"),
    ] {
        let script =
            format!("#!/bin/sh\ncase \"$*\" in *framecrc*) {list} ;; *) echo \"{says}\" >&2; exit 1 ;; esac\n");
        fs::write(folder.join("ffmpeg"), script).unwrap();
        fs::set_permissions(folder.join("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_tracecut"));
        command.arg("segment").arg(folder.join("clip.mp4")).args(["--out", "out"]).env("PATH", &folder);
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    }
}

#[test]
fn a_reader_that_is_left_ends_ffmpeg() {
    let folder = folder("videos-left");
    if !ffmpeg(&folder, "-f lavfi -i testsrc2=s=640x480:r=25:d=20 -c:v mpeg4 long.mp4") {
        return;
    }
    let input = Input::open(&folder.join("long.mp4"), None).unwrap();
    assert_eq!(input.num_frames(), Some(500));
    let mut frames = input.frames().unwrap();
    assert_eq!(frames.by_ref().take(3).filter(|frame| frame.is_ok()).count(), 3);
    // Far more than fits into a pipe is left: this would wait for ever for a program that nobody reads.
    drop(frames);
}

#[test]
fn animated_images_have_all_pictures_with_their_delays() {
    let folder = folder("videos-animated");
    let delays = r"-vf format=rgb24,settb=1/100,setpts=4*N+8*gte(N\,3) -fps_mode passthrough -enc_time_base 1:100";
    let times: Vec<f64> = (0..COUNT).map(|n| f64::from(4 * n as u32 + 8 * u32::from(n >= 3)) / 100.0).collect();
    let files = [
        ("a.gif", "-c:v gif"),
        ("a.png", "-c:v apng -f apng"),
        ("a.webp", "-c:v libwebp_anim -lossless 1 -pix_fmt bgra"),
    ];
    let mut read = Vec::new();
    for (name, codec) in files {
        if !ffmpeg(&folder, &format!("{PATTERN} {delays} {codec} {name}")) {
            return;
        }
        let whole = Outcome::whole(&folder.join(name));
        assert_eq!(whole.times(), times, "{name}");
        let cut = changed(&folder.join(name), &format!("cut-{name}"), |bytes| bytes.truncate(bytes.len() * 7 / 10));
        let outcome = Outcome::of(&cut, None);
        assert!((4..COUNT).contains(&outcome.frames.len()), "{name}: {} frames", outcome.frames.len());
        outcome.assert_damaged(&whole, outcome.frames.len(), name);
        read.push(whole);
    }
    // PNG and lossless WebP hold the same pixels; the decoder rounds down where pictures of WebP are laid over others.
    for (png, webp) in read[1].frames.iter().zip(&read[2].frames) {
        assert!(largest_difference(png, webp) <= 1, "{}", webp.name);
    }
}
