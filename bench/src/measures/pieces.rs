//! Connected pieces of a clip's true masks, and how much of each has which label.

use std::collections::BTreeMap;
use tracecut::image::Plane;
use tracecut::sets::DisjointSets;

/// A piece counts when it fills this share of the frame at some time; smaller ones are specks of the annotation.
const LEAST_SHARE: f64 = 1.0 / 2000.0;

/// One piece in one frame.
#[derive(Debug, Default)]
struct Piece {
    /// Pixels by label.
    labels: BTreeMap<u8, u64>,
    pixels: u64,
}

/// The pieces of all frames so far; those of neighbouring frames that overlap are one object.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    all: Vec<Piece>,
    /// Pieces that overlap, as indices.
    links: Vec<(usize, usize)>,
    /// The last frame: which piece each pixel is on.
    last: Vec<Option<usize>>,
}

impl Pieces {
    /// Counts a frame: its labels, and the pixels on objects. All frames have one size.
    pub(super) fn add(&mut self, labels: &Plane<u8>, objects: &Plane<bool>) {
        let mut sets = connected(objects);
        let mut piece_of_root: BTreeMap<usize, usize> = BTreeMap::new();
        let mut here = vec![None; objects.data().len()];
        for i in (0..here.len()).filter(|&i| objects.data()[i]) {
            let piece = *piece_of_root.entry(sets.root(i)).or_insert_with(|| {
                self.all.push(Piece::default());
                self.all.len() - 1
            });
            self.all[piece].pixels += 1;
            *self.all[piece].labels.entry(labels.data()[i]).or_default() += 1;
            here[i] = Some(piece);
        }
        let overlaps = self.last.iter().zip(&here).filter_map(|(before, now)| Some(((*before)?, (*now)?)));
        self.links.extend(overlaps);
        self.links.sort_unstable();
        self.links.dedup();
        self.last = here;
    }

    /// How many objects there are, and of how many at least half of the pixels have a label that `counts`.
    pub(super) fn found(&self, counts: impl Fn(u8) -> bool) -> (usize, usize) {
        let mut sets = DisjointSets::new(self.all.len());
        self.links.iter().for_each(|&(a, b)| sets.join(a, b));
        let least = (LEAST_SHARE * self.last.len() as f64).ceil() as u64;
        // Object by object: largest piece, pixels, those with a label that counts.
        let mut objects: BTreeMap<usize, (u64, u64, u64)> = BTreeMap::new();
        for (i, piece) in self.all.iter().enumerate() {
            let covered: u64 = piece.labels.iter().filter(|(label, _)| counts(**label)).map(|(_, n)| n).sum();
            let object = objects.entry(sets.root(i)).or_default();
            *object = (object.0.max(piece.pixels), object.1 + piece.pixels, object.2 + covered);
        }
        objects.retain(|_, (largest, ..)| *largest >= least);
        (objects.len(), objects.values().filter(|(_, pixels, covered)| 2 * covered >= *pixels).count())
    }
}

/// The true pixels, joined with those of their eight neighbours that are true.
fn connected(plane: &Plane<bool>) -> DisjointSets {
    let (width, height) = (plane.width(), plane.height());
    let mut sets = DisjointSets::new(width * height);
    for y in 0..height {
        for x in (0..width).filter(|&x| plane[(x, y)]) {
            let here = y * width + x;
            if x > 0 && plane[(x - 1, y)] {
                sets.join(here - 1, here);
            }
            for above in (x.saturating_sub(1)..(x + 2).min(width)).filter(|&a| y > 0 && plane[(a, y - 1)]) {
                sets.join((y - 1) * width + above, here);
            }
        }
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(rows: &[&str]) -> Plane<bool> {
        let data = rows.iter().flat_map(|r| r.bytes()).map(|b| b == b'#').collect();
        Plane::from_vec(rows[0].len(), rows.len(), data).unwrap()
    }

    /// How many objects the frames hold.
    fn count(frames: &[&[&str]]) -> usize {
        let mut pieces = Pieces::default();
        for rows in frames {
            let objects = plane(rows);
            pieces.add(&objects.map(|_| 0), &objects);
        }
        pieces.found(|_| true).0
    }

    #[test]
    fn pieces_touch_at_corners_and_go_on_where_they_overlap() {
        assert_eq!(count(&[&["#...", ".#.#"]]), 2);
        assert_eq!(count(&[&[".#..", "#..."]]), 1);
        assert_eq!(count(&[&["##..", "...."], &[".##.", "...."], &["..##", "...."]]), 1);
        // Gone for a frame, or too fast to overlap: another object.
        assert_eq!(count(&[&["##.."], &["...."], &["##.."]]), 2);
        assert_eq!(count(&[&["#..."], &["..#."]]), 2);
        // Two that meet once are one.
        assert_eq!(count(&[&["#..#"], &["####"], &["#..#"]]), 1);
        assert_eq!(count(&[&["...."]]), 0);
    }

    #[test]
    fn specks_are_no_objects_and_half_of_one_is_enough() {
        let mut pieces = Pieces::default();
        // 80 x 100 pixels: an object has 4 at least.
        let objects = Plane::from_fn(80, 100, |x, y| y == 0 && (x < 3 || (10..14).contains(&x)));
        pieces.add(&Plane::from_fn(80, 100, |x, _| u8::from(x >= 12) + u8::from(x < 3)), &objects);
        assert_eq!(pieces.found(|label| label == 1), (1, 1));
        assert_eq!(pieces.found(|label| label == 2), (1, 0));
        let fewer = Plane::from_fn(80, 100, |x, y| u8::from(y == 0 && x == 13));
        let mut pieces = Pieces::default();
        pieces.add(&fewer, &objects);
        assert_eq!(pieces.found(|label| label == 1), (1, 0));
    }
}
