//! A list of the packets in a file's video tracks (`-f framecrc`), and the choice of a track.

use super::log::TimeBase;
use std::cmp::Reverse;
use std::io::{self, BufRead};

/// A packet that is missing its time has this one in lists.
const NO_TIME: i64 = i64::MIN;

/// `AV_PKT_FLAG_CORRUPT`: the packet is not whole.
const CORRUPT: u32 = 2;
/// `AV_PKT_FLAG_DISCARD`: the packet is needed for decoding, but an edit list leaves its picture out.
const DISCARD: u32 = 4;

/// Share of a duration by which steps between pictures may differ from it and be the same, for times in whole milliseconds.
const STEP_TOLERANCE: f64 = 0.25;

/// A video track, attached pictures left out.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct Track {
    /// Counts the video tracks: `0:V:position`.
    pub(super) position: usize,
    pub(super) codec: String,
    pub(super) num_pixels: u64,
    /// In the order of the file.
    pub(super) packets: Vec<Packet>,
    pub(super) time_base: Option<TimeBase>,
}

/// A packet, which as a rule holds one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Packet {
    /// Decoding time in seconds.
    pub(super) decoding_time: Option<f64>,
    /// Presentation time in seconds.
    pub(super) time: Option<f64>,
    /// Seconds; 0 where the file does not say.
    pub(super) duration: f64,
    pub(super) is_corrupt: bool,
    pub(super) is_shown: bool,
}

/// A picture that a packet holds, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ListedPicture {
    pub(super) time: f64,
    /// 0 where the file does not say.
    pub(super) duration: f64,
}

impl Track {
    /// Number of pictures to show.
    pub(super) fn num_pictures(&self) -> usize {
        let ends_before_start =
            |packet: &Packet| packet.time.is_some_and(|time| time < 0.0 && time + packet.duration <= 0.0);
        self.packets.iter().filter(|packet| packet.is_shown && !ends_before_start(packet)).count()
    }

    /// The pictures whose time is known, in the order of display.
    ///
    /// ffmpeg 5 and 6 make up a duration of packets, the average of the track, where an MP4 file tells it by decoding
    /// times only. One that all packets have, while the pictures are not so far apart, counts as unknown.
    pub(super) fn pictures(&self) -> Vec<ListedPicture> {
        let picture = |packet: &Packet| packet.time.map(|time| ListedPicture { time, duration: packet.duration });
        let mut pictures: Vec<_> = self.packets.iter().filter(|p| p.is_shown).filter_map(picture).collect();
        pictures.sort_by(|a, b| a.time.total_cmp(&b.time));
        let average = pictures.first().map_or(0.0, |picture| picture.duration);
        let is_off = |pair: &[ListedPicture]| (pair[1].time - pair[0].time - average).abs() > STEP_TOLERANCE * average;
        if pictures.iter().all(|picture| picture.duration == average) && pictures.windows(2).any(is_off) {
            pictures.iter_mut().for_each(|picture| picture.duration = 0.0);
        }
        pictures
    }
}

/// Returns the tracks in a list.
///
/// # Errors
/// When reading fails.
pub(super) fn parse_tracks(list: impl BufRead) -> io::Result<Vec<Track>> {
    let mut tracks: Vec<Track> = Vec::new();
    for line in list.lines() {
        let line = line?;
        let Some(fact) = line.strip_prefix('#') else {
            parse_packet(&line, &mut tracks);
            continue;
        };
        // `#codec_id 0: h264`.
        let Some((name, text)) = fact.split_once(": ") else { continue };
        let Some((name, position)) = name.split_once(' ') else { continue };
        let Ok(position) = position.parse::<usize>() else { continue };
        if name == "tb" && position == tracks.len() {
            tracks.push(Track { position, time_base: TimeBase::parse(text), ..Track::default() });
        }
        let Some(track) = tracks.get_mut(position) else { continue };
        match name {
            "codec_id" => text.clone_into(&mut track.codec),
            "dimensions" => track.num_pixels = parse_num_pixels(text).unwrap_or_default(),
            _ => {}
        }
    }
    Ok(tracks)
}

fn parse_num_pixels(text: &str) -> Option<u64> {
    let (width, height) = text.split_once('x')?;
    Some(u64::from(width.parse::<u32>().ok()?) * u64::from(height.parse::<u32>().ok()?))
}

/// Parses `track, decoding time, presentation time, duration, bytes, checksum`, and perhaps `F=0x2` among what follows.
fn parse_packet(line: &str, tracks: &mut [Track]) -> Option<()> {
    let mut fields = line.split(',').map(str::trim);
    let track = tracks.get_mut(fields.next()?.parse::<usize>().ok()?)?;
    let base = track.time_base?;
    let parse_time = |field: &str| {
        let ticks = field.parse().ok().filter(|&ticks| ticks != NO_TIME);
        ticks.map(|ticks| base.seconds(ticks))
    };
    let (decoding_time, time) = (parse_time(fields.next()?), parse_time(fields.next()?));
    let duration: i64 = fields.next()?.parse().ok()?;
    let flags = fields.find_map(|field| u32::from_str_radix(field.strip_prefix("F=0x")?, 16).ok()).unwrap_or(0);
    track.packets.push(Packet {
        decoding_time,
        time,
        duration: base.seconds(duration.max(0)),
        is_corrupt: flags & CORRUPT != 0,
        is_shown: flags & DISCARD == 0,
    });
    Some(())
}

/// Chooses the track of a clip: the first default one of several pictures, else the largest of several pictures, else one
/// of a single picture. `defaults` says of each track whether it is a default one.
pub(super) fn choose_track(tracks: Vec<Track>, defaults: &[bool]) -> Option<Track> {
    let rank = |track: &Track| {
        let is_clip = track.num_pictures() > 1;
        let is_default = is_clip && defaults.get(track.position).copied().unwrap_or_default();
        Reverse((is_clip, is_default, if is_default { 0 } else { track.num_pixels }))
    };
    tracks.into_iter().filter(|track| !track.packets.is_empty()).min_by_key(rank)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIST: &str = "\
#extradata 0:       45, 0xe589f611
#software: Lavf59.27.100
#tb 0: 1/10240
#media_type 0: video
#codec_id 0: h264
#dimensions 0: 64x48
#sar 0: 1/1
#tb 1: 1/12800
#media_type 1: video
#codec_id 1: vp9
#dimensions 1: 240x180
0,      -4096,          0,     2048,      722, 0xe589f611
1,      -1024,      -1536,      512,    23728, 0x8b093d63, F=0x5
0,      -2048,       6144,     2048,       14, 0x1b3405d0, F=0x0
1,       -512, -9223372036854775808,      512,      782, 0x450584ec, F=0x2, S=1,        1, 0x00a700a7
1,          0,          0,        0,      188, 0x2325651d, S=1,        1, 0x00a700a7
";

    #[test]
    fn lists_have_tracks_and_packets_with_times_and_marks() {
        let tracks = parse_tracks(LIST.as_bytes()).unwrap();
        let seen: Vec<_> =
            tracks.iter().map(|track| (track.position, track.codec.as_str(), track.num_pixels)).collect();
        assert_eq!(seen, [(0, "h264", 3072), (1, "vp9", 43200)]);
        let packet = |decoding_time: f64, time: Option<f64>, duration: f64| Packet {
            decoding_time: Some(decoding_time),
            time,
            duration,
            is_corrupt: false,
            is_shown: true,
        };
        assert_eq!(tracks[0].packets, [packet(-0.4, Some(0.0), 0.2), packet(-0.2, Some(0.6), 0.2)]);
        let hidden = Packet { is_shown: false, ..packet(-0.08, Some(-0.12), 0.04) };
        let corrupt = Packet { is_corrupt: true, ..packet(-0.04, None, 0.04) };
        assert_eq!(tracks[1].packets, [hidden, corrupt, packet(0.0, Some(0.0), 0.0)]);
        assert_eq!(tracks[1].num_pictures(), 2);
        assert_eq!(parse_tracks(&b"0, what is this\n#tb 7: 1/5\n#\n9, 1, 1, 1\n"[..]).unwrap(), []);
    }

    #[test]
    fn a_duration_of_all_packets_that_no_picture_has_is_unknown() {
        let durations = |packets: &[(f64, f64)]| -> Vec<f64> {
            let packet = |&(time, duration): &(f64, f64)| Packet {
                decoding_time: None,
                time: Some(time),
                duration,
                is_corrupt: false,
                is_shown: true,
            };
            let track = Track { packets: packets.iter().map(packet).collect(), ..Track::default() };
            track.pictures().iter().map(|picture| picture.duration).collect()
        };
        assert_eq!(durations(&[(0.0, 0.2), (0.3, 0.2), (0.1, 0.2)]), [0.0; 3]);
        assert_eq!(durations(&[(0.0, 0.1), (0.4, 0.2), (0.1, 0.3)]), [0.1, 0.3, 0.2]);
        assert_eq!(durations(&[(0.0, 0.033), (0.033, 0.033), (0.067, 0.033)]), [0.033; 3]);
    }

    #[test]
    fn the_track_is_the_default_one_or_the_largest_of_several_pictures() {
        let picture =
            Packet { decoding_time: None, time: Some(0.0), duration: 0.04, is_corrupt: false, is_shown: true };
        let track = |position: usize, num_pixels: u64, num_pictures: usize| Track {
            position,
            num_pixels,
            packets: vec![picture; num_pictures],
            ..Track::default()
        };
        let choice = |sizes: &[(u64, usize)], defaults: &[bool]| {
            let tracks = sizes.iter().enumerate().map(|(position, &(pixels, count))| track(position, pixels, count));
            choose_track(tracks.collect(), defaults).map(|track| track.position)
        };
        assert_eq!(choice(&[(900, 5), (100, 5)], &[false, true]), Some(1), "the default one");
        assert_eq!(choice(&[(100, 5), (900, 5)], &[true, true]), Some(0), "the first of the default ones");
        assert_eq!(choice(&[(100, 5), (900, 5), (900, 5)], &[]), Some(1), "the first of the largest");
        assert_eq!(choice(&[(900, 1), (100, 5)], &[true, false]), Some(1), "one that is a clip");
        assert_eq!(choice(&[(100, 1), (900, 1)], &[true, false]), Some(1), "a picture");
        assert_eq!(choice(&[(100, 0)], &[true]), None);
    }
}
