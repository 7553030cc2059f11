//! The place of damage: which decoded picture is the first that must not be given.

use super::listing::{ListedPicture, Packet, Track};
use super::log::{Message, ShownPicture};
use std::collections::VecDeque;

/// Times that differ by less are the same, in seconds: far below the spacing of pictures, far above rounding.
const SAME_TIME_S: f64 = 1e-6;

/// Steps between pictures that are longer by this factor than the one before may have lost pictures in them.
const LONG_STEP: f64 = 1.5;

/// Names of demuxers that cut packets out of a stream.
const STREAMS: [&str; 2] = ["mpegts", "mpeg"];

/// Compares decoded pictures with the packets of the file. Four things are damage:
///
/// - a decoded picture that the decoder calls faulty;
/// - a packet that is not whole: pictures from its time on;
/// - a packet that could not be decoded: pictures after the first listed time without a picture. Packets before the first
///   picture may fail, as where a recording begins between two key pictures;
/// - a file that could not be read on: pictures of the packets after that place, or what the end lacks. Some pictures
///   before that place are shown later than lost ones, so times must not jump there.
#[derive(Debug)]
pub(super) struct FaultFinder {
    /// In the order of the file.
    packets: Vec<Packet>,
    /// In the order of display.
    listed: Vec<ListedPicture>,
    /// Pictures from one of these times on are damaged.
    damage_times: Vec<f64>,
    is_cut_off: bool,
    /// Pictures later than this may be shown after lost ones, in seconds.
    jump_time: f64,
    num_read: usize,
    num_decoded: usize,
    num_failed: usize,
    /// Numbers of decoded pictures.
    faulty: VecDeque<usize>,
    /// Number of listed times before the first picture.
    num_before_first: usize,
    last_time: Option<f64>,
    last_step: f64,
}

impl FaultFinder {
    /// Looks at a track of a file that `demuxer` reads, as ffmpeg names it.
    pub(super) fn new(track: &Track, demuxer: &str) -> Self {
        let packets = track.packets.clone();
        // Where packets are cut out of a stream, each is complete, and takes over its mark, when the next begins.
        let late = usize::from(STREAMS.contains(&demuxer));
        let torn = packets.iter().enumerate().filter(|(_, packet)| packet.is_corrupt).map(|(index, _)| index + late);
        let damage_times = torn.clone().filter_map(|index| packets.get(index)?.time).collect();
        let is_cut_off = torn.max().is_some_and(|index| index >= packets.len());
        Self {
            packets,
            listed: track.pictures(),
            damage_times,
            is_cut_off,
            jump_time: f64::INFINITY,
            num_read: 0,
            num_decoded: 0,
            num_failed: 0,
            faulty: VecDeque::new(),
            num_before_first: 0,
            last_time: None,
            last_step: f64::INFINITY,
        }
    }

    /// Takes a message in the order of the log.
    pub(super) fn take(&mut self, message: &Message) {
        match message {
            Message::PacketRead => self.num_read += 1,
            Message::PictureDecoded => self.num_decoded += 1,
            Message::PictureIsFaulty => self.faulty.push_back(self.num_decoded),
            Message::DecodingFailed => self.num_failed += 1,
            &Message::ReadingFailed { is_end } => self.take_reading_failure(is_end),
            _ => {}
        }
    }

    fn take_reading_failure(&mut self, is_end: bool) {
        // ffmpeg looks through the first packets before it gives one. A place among them is not known.
        if self.num_read == 0 && !is_end {
            return;
        }
        let place = if self.num_read == 0 { self.packets.len() } else { self.num_read.min(self.packets.len()) };
        let (before, after) = self.packets.split_at(place);
        let later = after.iter().filter(|packet| packet.is_shown).filter_map(|packet| packet.time);
        match later.min_by(f64::total_cmp) {
            Some(time) => self.damage_times.push(time),
            None => self.is_cut_off = true,
        }
        // No lost picture is shown before its decoding time.
        let next_decoding = before.last().and_then(|last| Some(last.decoding_time? + last.duration));
        self.jump_time = self.jump_time.min(next_decoding.unwrap_or(f64::INFINITY));
    }

    /// Returns whether the next picture is whole, and so are all that should have come before it.
    pub(super) fn is_whole(&mut self, shown: &ShownPicture) -> bool {
        while self.faulty.front().is_some_and(|&index| index < shown.index) {
            self.faulty.pop_front();
        }
        if self.faulty.front() == Some(&shown.index) {
            return false;
        }
        let Some(time) = shown.time else { return true };
        let is_damaged = match self.last_time {
            None => self.damage_times.iter().any(|damage| (damage - time).abs() < SAME_TIME_S),
            Some(last) => {
                self.is_damaged_between(last + SAME_TIME_S, time + SAME_TIME_S)
                    || self.is_missing_between(last + SAME_TIME_S, time - SAME_TIME_S)
                    || (time > self.jump_time + SAME_TIME_S && time - last > LONG_STEP * self.last_step)
            }
        };
        !is_damaged
    }

    /// Notes that a picture is given.
    pub(super) fn give(&mut self, shown: &ShownPicture) {
        let Some(time) = shown.time else { return };
        if self.last_time.is_none() {
            self.num_before_first = self.num_before(time - SAME_TIME_S);
        }
        if let Some(last) = self.last_time {
            self.last_step = time - last;
        }
        self.last_time = Some(time);
    }

    /// Seconds that the picture at a time is shown, where the file says so.
    pub(super) fn duration_at(&self, time: f64) -> Option<f64> {
        let picture = self.listed.get(self.num_before(time - SAME_TIME_S))?;
        ((picture.time - time).abs() < SAME_TIME_S && picture.duration > 0.0).then_some(picture.duration)
    }

    /// Returns whether nothing is missing after the last picture.
    pub(super) fn is_whole_at_end(&self) -> bool {
        let Some(last) = self.last_time else { return !self.is_cut_off };
        let rest = last + SAME_TIME_S;
        !self.is_cut_off
            && !self.is_damaged_between(rest, f64::INFINITY)
            && !self.is_missing_between(rest, f64::INFINITY)
    }

    fn is_damaged_between(&self, from: f64, to: f64) -> bool {
        self.damage_times.iter().any(|&damage| damage >= from && damage <= to)
    }

    /// Returns whether a listed time has no picture because its packet could not be decoded.
    fn is_missing_between(&self, from: f64, to: f64) -> bool {
        let next = self.listed.get(self.num_before(from));
        self.num_failed > self.num_before_first && next.is_some_and(|next| next.time <= to)
    }

    fn num_before(&self, time: f64) -> usize {
        self.listed.partition_point(|picture| picture.time < time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.04;

    /// A track whose packets have these numbers of pictures as times, in the order of the file.
    fn track(order: &[usize]) -> Track {
        let packet = |(place, &k): (usize, &usize)| Packet {
            decoding_time: Some((place as f64 - 2.0) * STEP_S),
            time: Some(k as f64 * STEP_S),
            duration: STEP_S,
            is_corrupt: false,
            is_shown: true,
        };
        Track { packets: order.iter().enumerate().map(packet).collect(), ..Track::default() }
    }

    fn shown(index: usize, k: usize) -> ShownPicture {
        ShownPicture { index, time: Some(k as f64 * STEP_S), width: 1, height: 1, is_key: false }
    }

    /// Gives pictures of these numbers as long as they are whole; returns how many, and whether the end is.
    fn count_whole(finder: &mut FaultFinder, pictures: &[usize]) -> (usize, bool) {
        for (index, &k) in pictures.iter().enumerate() {
            let shown = shown(index, k);
            if !finder.is_whole(&shown) {
                return (index, false);
            }
            finder.give(&shown);
        }
        (pictures.len(), finder.is_whole_at_end())
    }

    fn finder(order: &[usize], messages: &[Message]) -> FaultFinder {
        let mut finder = FaultFinder::new(&track(order), "mov");
        messages.iter().for_each(|message| finder.take(message));
        finder
    }

    #[test]
    fn pictures_that_are_missing_are_damage_only_where_packets_failed() {
        let order = [0, 3, 1, 2, 4];
        assert_eq!(count_whole(&mut finder(&order, &[]), &[0, 1, 2, 3, 4]), (5, true));
        assert_eq!(count_whole(&mut finder(&order, &[]), &[0, 1, 3, 4]), (4, true), "a packet without a picture");
        let failed = [Message::DecodingFailed];
        assert_eq!(count_whole(&mut finder(&order, &failed), &[0, 1, 3, 4]), (2, false));
        assert_eq!(count_whole(&mut finder(&order, &failed), &[0, 1, 2, 3]), (4, false));
        assert_eq!(count_whole(&mut finder(&order, &failed), &[0, 1, 2, 3, 4]), (5, true));
    }

    #[test]
    fn packets_that_fail_before_the_first_picture_are_no_damage() {
        let failed = [Message::DecodingFailed, Message::DecodingFailed];
        assert_eq!(count_whole(&mut finder(&[0, 1, 2, 3, 4, 5], &failed), &[2, 4, 5]), (3, true));
        assert_eq!(count_whole(&mut finder(&[0, 1, 2, 3, 4, 5], &failed), &[1, 2, 4, 5]), (2, false));
    }

    #[test]
    fn faulty_pictures_and_packets_that_are_not_whole_are_damage() {
        let decoded = Message::PictureDecoded;
        let faulty = [decoded.clone(), decoded.clone(), Message::PictureIsFaulty, decoded];
        assert_eq!(count_whole(&mut finder(&[0, 1, 2, 3], &faulty), &[0, 1, 2, 3]), (2, false));
        let mut torn = track(&[0, 2, 1, 3]);
        torn.packets[2].is_corrupt = true;
        assert_eq!(count_whole(&mut FaultFinder::new(&torn, "mov"), &[0, 1, 2, 3]), (1, false));
        assert_eq!(count_whole(&mut FaultFinder::new(&torn, "mov"), &[0]), (1, false));
        assert_eq!(
            count_whole(&mut FaultFinder::new(&torn, "mov"), &[2, 3]),
            (2, true),
            "it is before the first picture"
        );
        assert_eq!(
            count_whole(&mut FaultFinder::new(&torn, "mpegts"), &[0, 1, 2, 3]),
            (3, false),
            "the next packet is"
        );
    }

    #[test]
    fn where_reading_failed_the_packets_after_it_are_damage() {
        let failed = Message::ReadingFailed { is_end: false };
        let after_three = [Message::PacketRead, Message::PacketRead, Message::PacketRead, failed.clone()];
        assert_eq!(count_whole(&mut finder(&[0, 2, 1, 9, 8], &after_three), &[0, 1, 2, 8, 9]), (3, false));
        assert_eq!(count_whole(&mut finder(&[0, 2, 1], &after_three), &[0, 1, 2]), (3, false));
        assert_eq!(count_whole(&mut finder(&[0, 1], &[failed]), &[0, 1]), (2, true), "while the file was opened");
        let end = [Message::ReadingFailed { is_end: true }];
        assert_eq!(count_whole(&mut finder(&[0, 1], &end), &[0, 1]), (2, false));
        // Picture 5 was decoded before 3 and 4, which are lost.
        assert_eq!(count_whole(&mut finder(&[0, 2, 1, 5], &end), &[0, 1, 2, 5]), (3, false));
        assert_eq!(count_whole(&mut finder(&[0, 2, 1, 3], &end), &[0, 1, 2, 3]), (4, false));
    }
}
