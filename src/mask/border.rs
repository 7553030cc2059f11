//! Borders of a mask to the pixel: what superpixels could not part, colours and contrast decide.
//!
//! In: a mask and its frame. Out: a mask with the same labels, changed at most within a band around the borders between
//! labels.
//!
//! 1. The depth of each pixel: its distance to the nearest pixel of another label. The band is what is no deeper than a
//!    few pixels.
//! 2. In a window around each tile of the band: the colours of each label, away from the border itself (`cut::colour`), and
//!    how well they tell the labels apart there.
//! 3. A Potts energy over the pixels of the band. A label costs `−ln p(label | colour)`, as far as colours tell labels
//!    apart; leaving the present label costs more the deeper the pixel lies; to part neighbours costs `exp(−|difference
//!    of colours|² / 2σ²)`, where σ² is the mean square of the band. Pixels beyond the band keep their label.
//! 4. The labelling of least energy by alpha-expansion; with two labels, one cut.
//!
//! After Bai, Wang, Simons and Sapiro ("Video SnapCut", SIGGRAPH 2009) in that colours are local and are believed as
//! far as they separate, and Rother, Kolmogorov and Blake ("GrabCut", SIGGRAPH 2004) in the energy. Not in the paper.

use crate::cut::{Colour, Corners, Expansion, Histogram, Potts, UNSEEN_SHARE, to_steps};
use crate::image::{Frame, Plane};
use std::ops::Range;

crate::params! {
    /// Borders to the pixel.
    pub struct RefineParams {
        /// Furthest that a border may move to either side, in pixels of the processed frames; 0 leaves masks as they
        /// are. Higher is slower.
        pub band: u32 = 8, in 0..=64;
        /// Weight of local colours.
        pub colour_weight: f32 = 2.0, in 0.0..=1000.0, expert;
        /// Cost of moving the border by the whole band; it grows with the square of the distance.
        pub displacement_weight: f32 = 2.0, in 0.0..=1000.0, expert;
        /// Cost of a border between two pixels of the same colour.
        pub smoothness: f32 = 2.0, in 0.0..=1000.0, expert;
    }
}

/// Side of a tile: pixels that share their colour models.
pub(super) const TILE: usize = 24;
/// How far colours are gathered beyond a tile.
const MARGIN: usize = 12;
/// Of the pixels around, one of this many is looked at, in each direction.
const STRIDE: usize = 2;
/// Pixels nearer to a border than this may be on its wrong side, and are no samples.
const LEAST_SAMPLE_DEPTH: u32 = 3;
/// Of the samples, one of this many is asked how well colours tell the labels apart.
const TEST_STRIDE: usize = 4;
/// Fewer samples than this make no model.
const LEAST_SAMPLES: f32 = 8.0;
/// Differences of colours below this, in squared levels, are weighed once for all pixels.
const SMALL: usize = 1024;
/// Cost of a label that is not there.
const FORBIDDEN: f32 = 1000.0;

/// The mask with its borders where colours part. `mask` has the size of `frame`; otherwise it stays as it is.
///
/// # Examples
/// A mask that is three pixels off takes the border of the picture.
///
/// ```
/// use tracecut::image::{Frame, Plane};
/// use tracecut::mask::{RefineParams, refine};
///
/// let (w, h) = (64, 48);
/// let rgb = (0..w * h).flat_map(|p| if p % w < 32 { [60, 90, 50] } else { [150, 120, 100] }).collect();
/// let frame = Frame::from_rgb(rgb, w, h)?;
/// let mask = Plane::from_fn(w, h, |x, _| u8::from(x >= 35));
/// let refined = refine(&mask, &frame, &RefineParams::default());
/// assert_eq!(refined, Plane::from_fn(w, h, |x, _| u8::from(x >= 32)));
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn refine(mask: &Plane<u8>, frame: &Frame, params: &RefineParams) -> Plane<u8> {
    // Nothing was parted in a mask of one label.
    refine_since(mask, &Plane::filled(mask.width(), mask.height(), 0), frame, params)
}

/// The same only along borders that were none in the mask `before`, of equal size: what had one label before shares out
/// the labels that it has now.
pub(crate) fn refine_since(mask: &Plane<u8>, before: &Plane<u8>, frame: &Frame, params: &RefineParams) -> Plane<u8> {
    let size = (mask.width(), mask.height());
    if params.band == 0 || size != (frame.width(), frame.height()) || size != (before.width(), before.height()) {
        return mask.clone();
    }
    let mut refined = mask.clone();
    let whole = Part { left: 0, top: 0, width: size.0, height: size.1 };
    let Some(part) = whole.around_borders(mask, params.band as usize) else { return refined };
    // Labels are shared out only among pixels that had one label before: elsewhere the border was there already, and
    // the user may have drawn it.
    let mut shared = vec![false; 1 << 16];
    let pair = |before: u8, label: u8| usize::from(before) << 8 | usize::from(label);
    before.data().iter().zip(mask.data()).for_each(|(&b, &l)| shared[pair(b, l)] = true);
    let (mask, before) = (&part.of(mask), &part.of(before));
    for (p, label) in changes(mask, before, &part.of_frame(frame), params, 1.0) {
        if shared[pair(before.data()[p], label)] {
            refined[part.place(p)] = label;
        }
    }
    refined
}

/// Pixels that take another label. `contrast` is σ² in mean squares of the band.
pub(super) fn changes(
    mask: &Plane<u8>,
    before: &Plane<u8>,
    frame: &Frame,
    params: &RefineParams,
    contrast: f32,
) -> Vec<(usize, u8)> {
    let depth = depths(mask, before, params.band.max(LEAST_SAMPLE_DEPTH));
    let band = Band::new(mask, &depth, params.band);
    let mut problem = band.problem(mask, frame, &depth, params);
    band.add_contrast(&mut problem, mask, frame, (params.smoothness, contrast));
    // The expansion begins with the mask as it is, so that a draw changes nothing.
    let own = band.pixels.iter().map(|&p| band.place[usize::from(mask.data()[p as usize])]).collect();
    let label = Expansion::new(problem, own).finish();
    let label = label.into_iter().map(|l| band.labels[l as usize]);
    let changed = band.pixels.iter().map(|&p| p as usize).zip(label);
    changed.filter(|&(p, label)| mask.data()[p] != label).collect()
}

/// A part of the image, whole tiles as far as the image goes.
pub(super) struct Part {
    pub(super) left: usize,
    pub(super) top: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Part {
    /// What of it has to be seen where borders between labels may move by `band`; `None` where there is no border.
    pub(super) fn around_borders(&self, mask: &Plane<u8>, band: usize) -> Option<Self> {
        let (x, y) = (self.left..self.left + self.width, self.top..self.top + self.height);
        let (columns, rows) = border_box(mask, x, y)?;
        let reach = band.max(LEAST_SAMPLE_DEPTH as usize);
        // A tile more than borders can move, from which colours are gathered.
        let widened = |border: Range<usize>, start: usize, size: usize| {
            let from = ((border.start - start).saturating_sub(reach) / TILE).saturating_sub(1) * TILE;
            let end = (border.end - start + reach).next_multiple_of(TILE).saturating_add(TILE).min(size);
            (start + from, end - from)
        };
        let ((left, width), (top, height)) =
            (widened(columns, self.left, self.width), widened(rows, self.top, self.height));
        Some(Self { left, top, width, height })
    }

    pub(super) fn of(&self, plane: &Plane<u8>) -> Plane<u8> {
        Plane::from_fn(self.width, self.height, |x, y| plane[(self.left + x, self.top + y)])
    }

    pub(super) fn of_frame(&self, frame: &Frame) -> Frame {
        let row = |y: usize| &frame.rgb()[3 * ((self.top + y) * frame.width() + self.left)..][..3 * self.width];
        let rows: Vec<&[u8]> = (0..self.height).map(row).collect();
        Frame::from_rgb(rows.concat(), self.width, self.height).expect("a part of a legal frame is one")
    }

    /// Where in the image its pixel `p` is.
    pub(super) fn place(&self, p: usize) -> (usize, usize) {
        (self.left + p % self.width, self.top + p / self.width)
    }
}

/// Columns and rows of the pixels in a window that have a neighbour of another value in it, above, below or beside them;
/// `None` where there are none.
pub(super) fn border_box<T: Copy + PartialEq>(
    plane: &Plane<T>,
    columns: Range<usize>,
    rows: Range<usize>,
) -> Option<(Range<usize>, Range<usize>)> {
    let (mut across, mut down) = (columns.end..columns.start, rows.end..rows.start);
    for y in rows.clone() {
        let row = &plane.row(y)[columns.clone()];
        let below = &plane.row((y + 1).min(rows.end - 1))[columns.clone()];
        for other in [&row[1.min(row.len())..], below] {
            let row = &row[..other.len()];
            // Nearly all rows are alike, which is seen fastest without a look at each pixel.
            if !row.iter().zip(other).fold(false, |found, (a, b)| found | (a != b)) {
                continue;
            }
            let differ = |&k: &usize| row[k] != other[k];
            let Some(first) = (0..row.len()).find(differ) else { continue };
            let last = (0..row.len()).rfind(differ).unwrap_or(first);
            across.start = across.start.min(columns.start + first);
            across.end = across.end.max((columns.start + last + 2).min(columns.end));
            down = down.start.min(y)..down.end.max((y + 2).min(rows.end));
        }
    }
    (!down.is_empty()).then_some((across, down))
}

/// Step 1: the chessboard distance of each pixel to the nearest one of another label that had the same label before;
/// `limit + 1` for all that are further away. Other labels between them are no hindrance.
fn depths(mask: &Plane<u8>, before: &Plane<u8>, limit: u32) -> Plane<u32> {
    let (w, h) = (mask.width(), mask.height());
    let mut depth = Plane::filled(w, h, limit + 1);
    let mut reached = Vec::new();
    for y in 0..h {
        let rows = [y, (y + 1).min(h - 1)];
        let [row, below] = rows.map(|y| mask.row(y));
        for x in 0..w {
            let columns = [x, (x + 1).min(w - 1)];
            let [own, right, down, across] = [row[x], row[columns[1]], below[x], below[columns[1]]];
            if (own == right) & (own == down) & (own == across) {
                continue;
            }
            let corners = [(columns[0], y), (columns[1], y), (columns[0], rows[1]), (columns[1], rows[1])];
            for (k, &a) in corners.iter().enumerate() {
                for &b in &corners[k + 1..] {
                    if mask[a] != mask[b] && before[a] == before[b] {
                        reached.extend([a, b].into_iter().filter(|&at| std::mem::replace(&mut depth[at], 1) != 1));
                    }
                }
            }
        }
    }
    for distance in 2..=limit {
        let mut next = Vec::new();
        for (x, y) in reached {
            for v in y.saturating_sub(1)..(y + 2).min(h) {
                for u in x.saturating_sub(1)..(x + 2).min(w) {
                    if depth[(u, v)] > distance {
                        depth[(u, v)] = distance;
                        next.push((u, v));
                    }
                }
            }
        }
        reached = next;
    }
    depth
}

/// No node: a pixel beyond the band.
const BEYOND: u32 = u32::MAX;

/// The pixels that may change, and the labels among them.
struct Band {
    width: usize,
    height: usize,
    /// Pixel of each node, row by row.
    pixels: Vec<u32>,
    /// Node of each pixel.
    node: Vec<u32>,
    /// The labels in the band.
    labels: Vec<u8>,
    /// Place of each label in `labels`.
    place: [u32; 256],
}

impl Band {
    fn new(mask: &Plane<u8>, depth: &Plane<u32>, band: u32) -> Self {
        let mut pixels = Vec::new();
        let mut node = vec![BEYOND; depth.data().len()];
        let mut seen = [false; 256];
        for (p, _) in depth.data().iter().enumerate().filter(|&(_, &d)| d <= band) {
            node[p] = pixels.len() as u32;
            pixels.push(p as u32);
            seen[usize::from(mask.data()[p])] = true;
        }
        let labels: Vec<u8> = (0..=255).filter(|&l| seen[usize::from(l)]).collect();
        let mut place = [0; 256];
        for (k, &l) in (0..).zip(&labels) {
            place[usize::from(l)] = k;
        }
        Self { width: mask.width(), height: mask.height(), pixels, node, labels, place }
    }

    /// Steps 2 and 3, but for the edges.
    fn problem(&self, mask: &Plane<u8>, frame: &Frame, depth: &Plane<u32>, params: &RefineParams) -> Potts {
        let num_labels = self.labels.len();
        let mut unary = vec![0; self.pixels.len() * num_labels];
        let mut models = Models::new(num_labels);
        let mut shares = vec![0.0; num_labels];
        for top in (0..self.height).step_by(TILE) {
            for left in (0..self.width).step_by(TILE) {
                let rows = top..(top + TILE).min(self.height);
                let columns = left..(left + TILE).min(self.width);
                let inside = || rows.clone().flat_map(|y| columns.clone().map(move |x| y * self.width + x));
                // Most tiles lie off the band: gathering colours there would cost more than all the rest.
                if inside().all(|p| self.node[p] == BEYOND) {
                    continue;
                }
                models.gather(self, mask, frame, depth, (left, top));
                for p in inside().filter(|&p| self.node[p] != BEYOND) {
                    let costs = &mut unary[self.node[p] as usize * num_labels..][..num_labels];
                    let own = self.place[usize::from(mask.data()[p])] as usize;
                    let depth = depth.data()[p] as f32 / params.band as f32;
                    let colour = Colour::from_rgb(&frame.rgb()[3 * p..]);
                    models.costs(colour, own, params.colour_weight, (&mut *costs, &mut shares));
                    let keep = to_steps(params.displacement_weight * depth * depth);
                    for cost in costs.iter_mut().enumerate().filter(|(l, _)| *l != own).map(|(_, cost)| cost) {
                        *cost += keep;
                    }
                }
            }
        }
        Potts { num_nodes: self.pixels.len(), num_labels, unary, ..Potts::default() }
    }

    /// Step 3: edges to four of the eight neighbours, the other four have them in turn.
    fn add_contrast(&self, problem: &mut Potts, mask: &Plane<u8>, frame: &Frame, (smoothness, contrast): (f32, f32)) {
        let mut pairs: Vec<(u32, u32, u32, bool)> = Vec::with_capacity(4 * self.pixels.len());
        let mut total = 0_u64;
        for y in 0..self.height {
            let row = |y: usize| &self.node[y * self.width..][..self.width];
            let (own, under) = (row(y), row((y + 1).min(self.height - 1)));
            for x in 0..self.width {
                let (before, after) = (x.saturating_sub(1), (x + 1).min(self.width - 1));
                // Nearly all pixels lie off the band: of `BEYOND` all bits are set.
                if own[x] & own[after] & under[before] & under[x] & under[after] == BEYOND {
                    continue;
                }
                let p = y * self.width + x;
                let (right, down, left) = (x + 1 < self.width, y + 1 < self.height, x > 0);
                let below = p + self.width;
                let others =
                    [(right, p + 1), (down, below), (down && left, below.wrapping_sub(1)), (down && right, below + 1)];
                for (k, (_, q)) in others.into_iter().enumerate().filter(|(_, (there, _))| *there) {
                    // Also pairs with one end beyond the band: they hold its rim to the labels outside.
                    if self.node[p] != BEYOND || self.node[q] != BEYOND {
                        let difference = difference_sq(frame.rgb(), p, q);
                        total += u64::from(difference);
                        pairs.push((p as u32, q as u32, difference, k >= 2));
                    }
                }
            }
        }
        // A perfectly flat band has no contrast to go by.
        let variance = (contrast * (total as f32 / pairs.len().max(1) as f32)).max(1.0);
        let likeness = |difference: u32| libm::expf(-(difference as f32) / (2.0 * variance));
        // Most differences are small, and come again and again.
        let mut small = vec![None; SMALL];
        for (p, q, difference, diagonal) in pairs {
            let length = if diagonal { std::f32::consts::FRAC_1_SQRT_2 } else { 1.0 };
            let likeness = match small.get_mut(difference as usize) {
                Some(known) => *known.get_or_insert_with(|| likeness(difference)),
                None => likeness(difference),
            };
            let weight = to_steps(smoothness * length * likeness);
            match (self.node[p as usize], self.node[q as usize]) {
                (BEYOND, node) => self.bind(problem, node, mask.data()[p as usize], weight),
                (node, BEYOND) => self.bind(problem, node, mask.data()[q as usize], weight),
                ends => {
                    problem.edges.push(ends);
                    problem.weights.push(weight);
                }
            }
        }
    }

    /// An edge to a pixel whose label is fixed: all other labels cost its weight.
    fn bind(&self, problem: &mut Potts, node: u32, label: u8, weight: i32) {
        let num_labels = self.labels.len();
        let costs = &mut problem.unary[node as usize * num_labels..][..num_labels];
        for (cost, _) in costs.iter_mut().zip(&self.labels).filter(|(_, l)| **l != label) {
            *cost += weight;
        }
    }
}

fn difference_sq(rgb: &[u8], p: usize, q: usize) -> u32 {
    (0..3).map(|c| u32::from(rgb[3 * p + c].abs_diff(rgb[3 * q + c])).pow(2)).sum()
}

/// Step 2: the colours of each label around a tile.
struct Models {
    histograms: Vec<Histogram>,
    /// Some of them, to be asked how well colours tell the labels apart.
    samples: Vec<(u32, Corners)>,
    /// How well colours tell the labels apart, 0 to 1.
    confidence: f32,
}

impl Models {
    fn new(num_labels: usize) -> Self {
        Self { histograms: vec![Histogram::new(); num_labels], samples: Vec::new(), confidence: 0.0 }
    }

    /// Gathers the samples around the tile at `(left, top)`.
    fn gather(
        &mut self,
        band: &Band,
        mask: &Plane<u8>,
        frame: &Frame,
        depth: &Plane<u32>,
        (left, top): (usize, usize),
    ) {
        self.samples.clear();
        self.histograms.iter_mut().for_each(Histogram::clear);
        let mut count = 0;
        for y in (top.saturating_sub(MARGIN)..(top + TILE + MARGIN).min(band.height)).step_by(STRIDE) {
            for x in (left.saturating_sub(MARGIN)..(left + TILE + MARGIN).min(band.width)).step_by(STRIDE) {
                let p = y * band.width + x;
                let label = mask.data()[p];
                if depth.data()[p] >= LEAST_SAMPLE_DEPTH && band.labels.contains(&label) {
                    let place = band.place[usize::from(label)];
                    let colour = Colour::from_rgb(&frame.rgb()[3 * p..]).corners();
                    self.histograms[place as usize].add(&colour, 1.0);
                    if count % TEST_STRIDE == 0 {
                        self.samples.push((place, colour));
                    }
                    count += 1;
                }
            }
        }
        self.confidence = self.separation();
    }

    /// What is left of the probability of a sample's own label, on average, if chance is taken out: 0 if colours tell
    /// nothing, 1 if they tell everything. Each label counts the same.
    fn separation(&self) -> f32 {
        let mut right = vec![(0.0, 0_u32); self.histograms.len()];
        let mut shares = vec![0.0; self.histograms.len()];
        for (label, colour) in &self.samples {
            let label = *label as usize;
            // A sample is no witness for itself.
            let own = self.histograms[label].leave_one_out_share(colour) + UNSEEN_SHARE;
            let others = self.shares(colour, &mut shares) - shares[label];
            let (sum, count) = &mut right[label];
            *sum += own / (own + others);
            *count += 1;
        }
        let known = |l: &usize| self.histograms[*l].total() >= LEAST_SAMPLES && right[*l].1 > 0;
        let known: Vec<usize> = (0..right.len()).filter(known).collect();
        if known.len() < 2 {
            return 0.0;
        }
        let mean = known.iter().map(|&l| right[l].0 / right[l].1 as f32).sum::<f32>() / known.len() as f32;
        let chance = 1.0 / known.len() as f32;
        ((mean - chance) / (1.0 - chance)).clamp(0.0, 1.0)
    }

    /// How often each label has a colour, 0 where it has no model; and the sum of that.
    fn shares(&self, colour: &Corners, shares: &mut [f32]) -> f32 {
        for (share, histogram) in shares.iter_mut().zip(&self.histograms) {
            *share = if histogram.total() >= LEAST_SAMPLES { histogram.share(colour) + UNSEEN_SHARE } else { 0.0 };
        }
        shares.iter().sum()
    }

    /// The cost of each label at a pixel of this colour and of label `own`. Without a model of both, a label is out of
    /// the question. `shares` is memory for a number a label.
    fn costs(&self, colour: Colour, own: usize, weight: f32, (costs, shares): (&mut [i32], &mut [f32])) {
        let known = |l: usize| self.histograms[l].total() >= LEAST_SAMPLES;
        let sum = self.shares(&colour.corners(), shares);
        for (l, (cost, share)) in costs.iter_mut().zip(shares).enumerate() {
            *cost = to_steps(match known(l) && known(own) {
                true => -weight * self.confidence * libm::logf(*share / sum),
                false if l == own => 0.0,
                false => FORBIDDEN,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const W: usize = 64;
    const H: usize = 48;

    /// A frame whose pixels are of the colour of their label, with noise.
    fn painted(truth: &Plane<u8>, colours: &[[i32; 3]], noise: usize) -> Frame {
        let mut rng = Rng::for_stage(3, "refine");
        let mut rgb = Vec::new();
        for &l in truth.data() {
            for c in colours[usize::from(l)] {
                rgb.push((c + rng.below(2 * noise + 1) as i32 - noise as i32).clamp(0, 255) as u8);
            }
        }
        Frame::from_rgb(rgb, truth.width(), truth.height()).unwrap()
    }

    fn wrong(mask: &Plane<u8>, truth: &Plane<u8>) -> usize {
        mask.data().iter().zip(truth.data()).filter(|(a, b)| a != b).count()
    }

    const COLOURS: [[i32; 3]; 3] = [[60, 90, 50], [150, 120, 100], [60, 60, 140]];

    #[test]
    fn a_border_a_few_pixels_off_moves_to_the_contour() {
        let truth = Plane::from_fn(W, H, |x, y| u8::from((x as i32 - 32).pow(2) + (y as i32 - 24).pow(2) < 225));
        let mask = Plane::from_fn(W, H, |x, y| u8::from((18..44).contains(&x) && (13..41).contains(&y)));
        let frame = painted(&truth, &COLOURS, 12);
        let refined = refine(&mask, &frame, &RefineParams::default());
        assert!(wrong(&mask, &truth) > 150, "{}", wrong(&mask, &truth));
        assert!(wrong(&refined, &truth) < 15, "{} wrong", wrong(&refined, &truth));
    }

    #[test]
    fn three_labels_meet_where_their_colours_do() {
        let part = |x: usize, y: usize, cx: usize, cy: usize| if y < cy { 0 } else { 1 + u8::from(x > cx) };
        let truth = Plane::from_fn(W, H, |x, y| part(x, y, 30, 20));
        let mask = Plane::from_fn(W, H, |x, y| part(x, y, 33, 17));
        let refined = refine(&mask, &painted(&truth, &COLOURS, 12), &RefineParams::default());
        assert!(wrong(&refined, &truth) * 10 < wrong(&mask, &truth), "{} wrong", wrong(&refined, &truth));
    }

    #[test]
    fn pixels_beyond_the_band_keep_their_label_and_no_label_is_new() {
        let mut rng = Rng::for_stage(4, "refine");
        let blocks: Vec<u8> = (0..12).map(|_| [0, 1, 2, 7][rng.below(4)]).collect();
        let mask = Plane::from_fn(W, H, |x, y| blocks[x / 16 + 4 * (y / 16)]);
        let noise = Plane::filled(W, H, 0);
        let frame = painted(&noise, &[[128; 3]], 127);
        let params = RefineParams { band: 3, displacement_weight: 0.0, ..RefineParams::default() };
        let refined = refine(&mask, &frame, &params);
        let depth = depths(&mask, &Plane::filled(W, H, 0), 3);
        let mut changed = 0;
        for (p, (new, old)) in refined.data().iter().zip(mask.data()).enumerate() {
            assert!(blocks.contains(new));
            assert!(new == old || depth.data()[p] <= 3);
            changed += usize::from(new != old);
        }
        assert!(changed > 0);
        assert_eq!(refine(&mask, &frame, &RefineParams { band: 0, ..params }), mask);
    }

    #[test]
    fn where_colours_tell_nothing_a_straight_border_hardly_moves() {
        let mask = Plane::from_fn(W, H, |x, _| u8::from(x >= 30));
        for (noise, limit) in [(0, 0), (20, 2 * H)] {
            let frame = painted(&Plane::filled(W, H, 0), &[[128; 3]], noise);
            let moved = wrong(&refine(&mask, &frame, &RefineParams::default()), &mask);
            assert!(moved <= limit, "{moved} moved");
        }
    }

    #[test]
    fn depth_is_the_distance_to_the_nearest_pixel_of_another_label() {
        let mut rng = Rng::for_stage(5, "refine");
        let spots: Vec<(usize, usize)> = (0..4).map(|_| (rng.below(30), rng.below(20))).collect();
        let mask = Plane::from_fn(30, 20, |x, y| u8::from(spots.contains(&(x, y))) + 2 * u8::from(x > 22));
        let depth = depths(&mask, &Plane::filled(30, 20, 0), 6);
        for y in 0..20_usize {
            for x in 0..30_usize {
                let others = (0..20_usize).flat_map(|v| (0..30_usize).map(move |u| (u, v)));
                let least = others
                    .filter(|&p| mask[p] != mask[(x, y)])
                    .map(|(u, v)| u.abs_diff(x).max(v.abs_diff(y)) as u32)
                    .min();
                assert_eq!(depth[(x, y)], least.unwrap_or(7).min(7), "at {x}, {y}");
            }
        }
    }

    #[test]
    fn borders_that_were_there_before_stay() {
        let truth = Plane::from_fn(W, H, |x, y| if x < 20 { 0 } else { 1 + u8::from(y >= 24) });
        let frame = painted(&truth, &[[40; 3], [140; 3], [240; 3]], 20);
        // Both borders are three pixels off; that on the left is old.
        let before = Plane::from_fn(W, H, |x, _| u8::from(x >= 23));
        let mask = Plane::from_fn(W, H, |x, y| if x < 23 { 0 } else { 1 + u8::from(y >= 27) });
        let refined = refine_since(&mask, &before, &frame, &RefineParams::default());
        let expected = Plane::from_fn(W, H, |x, y| if x < 23 { 0 } else { 1 + u8::from(y >= 24) });
        assert!(wrong(&refined, &expected) <= 20, "{} pixels", wrong(&refined, &expected));
        assert_eq!(refine_since(&mask, &mask, &frame, &RefineParams::default()), mask);
    }

    #[test]
    fn the_part_around_borders_gives_what_the_whole_image_gives() {
        let (w, h) = (200, 170);
        let params = RefineParams::default();
        for (left, top) in [(0, 0), (90, 75), (170, 140), (61, 2)] {
            let truth = Plane::from_fn(w, h, |x, y| u8::from(x >= left && y >= top && x < left + 25 && y < top + 20));
            let mask = Plane::from_fn(w, h, |x, y| truth[((x + 2).min(w - 1), (y + 3).min(h - 1))]);
            let frame = painted(&truth, &COLOURS, 15);
            let none = Plane::filled(w, h, 0);
            let mut whole = mask.clone();
            for (p, label) in changes(&mask, &none, &frame, &params, 1.0) {
                whole.data_mut()[p] = label;
            }
            let refined = refine(&mask, &frame, &params);
            assert_eq!(refined, whole, "at {left}, {top}");
            assert_ne!(refined, mask);
        }
    }

    #[test]
    fn masks_of_one_label_tiny_ones_and_those_of_another_size_stay() {
        for (w, h) in [(1, 1), (1, 9), (9, 1), (5, 4)] {
            let mask = Plane::filled(w, h, 3);
            let frame = Frame::from_rgb(vec![9; 3 * w * h], w, h).unwrap();
            assert_eq!(refine(&mask, &frame, &RefineParams::default()), mask);
        }
        let frame = Frame::from_rgb(vec![9; 12], 2, 2).unwrap();
        let other = Plane::from_fn(5, 4, |x, _| x as u8);
        assert_eq!(refine(&other, &frame, &RefineParams::default()), other);
        // Too narrow for any model of colours: nothing is known, nothing changes.
        let narrow = Plane::from_fn(2, 2, |x, _| x as u8);
        assert_eq!(refine(&narrow, &frame, &RefineParams::default()), narrow);
    }
}
