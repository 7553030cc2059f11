//! Refinement of mask borders to the pixel, by colour and contrast.
//!
//! In: a mask and its frame. Out: a mask with the same labels, changed at most within a band around the borders.
//!
//! 1. The depth of each pixel: its distance to the nearest pixel of another label. Pixels up to a small depth form the band.
//! 2. In a window around each tile of the band: colour histograms of each label, without pixels at the border (`cut::colour`),
//!    and their separation, 0 to 1.
//! 3. A Potts energy over the band. A label costs `−ln p(label | colour)` times the separation; leaving the present label costs
//!    more for deeper pixels; different labels of neighbours cost `exp(−|difference of colours|² / 2σ²)`, where σ² is the mean
//!    squared difference in the band. Pixels outside the band keep their label.
//! 4. The labelling of least energy by alpha-expansion, border by border: a border between two labels takes a single cut.
//!
//! Local colour models weighted by their separation are from Bai, Wang, Simons and Sapiro ("Video SnapCut", SIGGRAPH 2009), the
//! energy from Rother, Kolmogorov and Blake ("GrabCut", SIGGRAPH 2004). The cost is the cut's, a few times linear in the
//! band. It fails where object and background have the same colours. Not in the paper.

use crate::cut::{Colour, Corners, Histogram, Potts, UNSEEN_SHARE, minimize, to_steps};
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
        /// A part of an object that lies apart and has hardly any of its trajectories goes to what surrounds it, if its area is
        /// less than this share of the object's largest part in the frame. 0 keeps all. Not in the paper; docs/choices.md.
        pub min_part: f32 = 0.1, in 0.0..=1.0, expert;
    }
}

// All chosen by eye.
/// Side of a tile, whose pixels share their colour models.
pub(super) const TILE_PX: usize = 24;
/// Colours are sampled up to this distance from a tile.
const SAMPLE_MARGIN_PX: usize = 12;
/// Distance of samples, in each direction.
const SAMPLE_STRIDE_PX: usize = 2;
/// Least depth of samples: pixels nearer to a border may be on its wrong side.
const MIN_SAMPLE_DEPTH_PX: u32 = 3;
/// One in this many samples measures the separation of the colour models.
const TEST_STRIDE: usize = 4;
/// Least number of samples of a colour model.
const MIN_SAMPLES: f32 = 8.0;
/// Colour differences below this, in squared grey levels, have their weight cached.
const CACHED_DIFFERENCES: usize = 1024;
/// Cost of a label without a colour model.
const FORBIDDEN_COST: f32 = 1000.0;

/// Moves the borders of a mask to colour edges. A mask of another size than `frame` is returned as it is.
///
/// # Examples
/// The border of a mask that is three pixels off moves to the edge in the picture.
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
    // A mask of one label has no border, so all borders are new.
    refine_since(mask, &Plane::filled(mask.width(), mask.height(), 0), frame, params)
}

/// Moves only borders that the mask `before` of equal size does not have: pixels change between labels that replaced one label of
/// `before`.
pub(crate) fn refine_since(mask: &Plane<u8>, before: &Plane<u8>, frame: &Frame, params: &RefineParams) -> Plane<u8> {
    let size = (mask.width(), mask.height());
    if params.band == 0 || size != (frame.width(), frame.height()) || size != (before.width(), before.height()) {
        return mask.clone();
    }
    let mut refined = mask.clone();
    let image = Crop { left: 0, top: 0, width: size.0, height: size.1 };
    let Some(crop) = image.around_borders(mask, params.band as usize) else { return refined };
    // Other borders existed before, and the user may have drawn them.
    let mut is_allowed = vec![false; 1 << 16];
    let pair = |before: u8, label: u8| usize::from(before) << 8 | usize::from(label);
    before.data().iter().zip(mask.data()).for_each(|(&b, &l)| is_allowed[pair(b, l)] = true);
    let (mask, before) = (&crop.plane(mask), &crop.plane(before));
    for (p, label) in label_changes(mask, before, &crop.frame(frame), params, 1.0) {
        if is_allowed[pair(before.data()[p], label)] {
            refined[crop.position(p)] = label;
        }
    }
    refined
}

/// Returns the pixels whose label changes. `contrast` is σ² in units of the mean squared difference in the band.
pub(super) fn label_changes(
    mask: &Plane<u8>,
    before: &Plane<u8>,
    frame: &Frame,
    params: &RefineParams,
    contrast: f32,
) -> Vec<(usize, u8)> {
    let depth = depths(mask, before, params.band.max(MIN_SAMPLE_DEPTH_PX));
    let band = Band::new(mask, &depth, params.band);
    let mut problem = band.problem(mask, frame, &depth, params);
    band.add_contrast(&mut problem, mask, frame, params.smoothness, contrast);
    // The expansion starts with the present labels, so that ties change nothing.
    let present: Vec<u32> =
        band.pixels.iter().map(|&p| band.label_index[usize::from(mask.data()[p as usize])]).collect();
    let label = minimize(&problem, &present).into_iter().map(|l| band.labels[l as usize]);
    let changed = band.pixels.iter().map(|&p| p as usize).zip(label);
    changed.filter(|&(p, label)| mask.data()[p] != label).collect()
}

/// A rectangle of the image, made of whole tiles except at the edges of the image.
pub(super) struct Crop {
    pub(super) left: usize,
    pub(super) top: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Crop {
    /// Returns the part that matters if borders may move by `band` pixels; `None` if there is no border.
    pub(super) fn around_borders(&self, mask: &Plane<u8>, band: usize) -> Option<Self> {
        let (x, y) = (self.left..self.left + self.width, self.top..self.top + self.height);
        let (columns, rows) = border_box(mask, x, y)?;
        let reach = band.max(MIN_SAMPLE_DEPTH_PX as usize);
        // Colours are sampled in one more tile on each side.
        let widened = |border: Range<usize>, start: usize, size: usize| {
            let from = ((border.start - start).saturating_sub(reach) / TILE_PX).saturating_sub(1) * TILE_PX;
            let end = (border.end - start + reach).next_multiple_of(TILE_PX).saturating_add(TILE_PX).min(size);
            (start + from, end - from)
        };
        let ((left, width), (top, height)) =
            (widened(columns, self.left, self.width), widened(rows, self.top, self.height));
        Some(Self { left, top, width, height })
    }

    pub(super) fn plane(&self, plane: &Plane<u8>) -> Plane<u8> {
        let rows = self.top..self.top + self.height;
        let rows: Vec<&[u8]> = rows.map(|y| &plane.row(y)[self.left..self.left + self.width]).collect();
        Plane::from_vec(self.width, self.height, rows.concat()).expect("a crop has as many pixels as its size says")
    }

    pub(super) fn frame(&self, frame: &Frame) -> Frame {
        frame.picture().part(self.left..self.left + self.width, self.top..self.top + self.height)
    }

    /// Returns the position of pixel `p` of the crop in the image.
    pub(super) fn position(&self, p: usize) -> (usize, usize) {
        (self.left + p % self.width, self.top + p / self.width)
    }
}

/// Returns the columns and rows of all pixels in a window with a direct neighbour of another value in it; `None` if there are
/// none.
pub(super) fn border_box<T: Copy + PartialEq>(
    plane: &Plane<T>,
    columns: Range<usize>,
    rows: Range<usize>,
) -> Option<(Range<usize>, Range<usize>)> {
    let (mut across, mut down) = (columns.end..columns.start, rows.end..rows.start);
    for y in rows.clone() {
        let row = &plane.row(y)[columns.clone()];
        let below = &plane.row((y + 1).min(rows.end - 1))[columns.clone()];
        for neighbours in [&row[1.min(row.len())..], below] {
            let row = &row[..neighbours.len()];
            // Nearly all rows are equal, which is tested fastest without a branch per pixel.
            if !row.iter().zip(neighbours).fold(false, |differs, (a, b)| differs | (a != b)) {
                continue;
            }
            let differs = |&k: &usize| row[k] != neighbours[k];
            let Some(first) = (0..row.len()).find(differs) else { continue };
            let last = (0..row.len()).rfind(differs).unwrap_or(first);
            across.start = across.start.min(columns.start + first);
            across.end = across.end.max((columns.start + last + 2).min(columns.end));
            down = down.start.min(y)..down.end.max((y + 2).min(rows.end));
        }
    }
    (!down.is_empty()).then_some((across, down))
}

/// Step 1: computes the chessboard distance of each pixel to the nearest one of another label that had the same label before;
/// `limit + 1` for all that are further away. Labels in between do not matter.
fn depths(mask: &Plane<u8>, before: &Plane<u8>, limit: u32) -> Plane<u32> {
    let (w, h) = (mask.width(), mask.height());
    let mut depth = Plane::filled(w, h, limit + 1);
    let mut frontier = Vec::new();
    for y in 0..h {
        let rows = [y, (y + 1).min(h - 1)];
        let [row, below] = rows.map(|y| mask.row(y));
        for x in 0..w {
            let columns = [x, (x + 1).min(w - 1)];
            let [value, right, down, diagonal] = [row[x], row[columns[1]], below[x], below[columns[1]]];
            if (value == right) & (value == down) & (value == diagonal) {
                continue;
            }
            let corners = [(columns[0], y), (columns[1], y), (columns[0], rows[1]), (columns[1], rows[1])];
            for (k, &a) in corners.iter().enumerate() {
                for &b in &corners[k + 1..] {
                    if mask[a] != mask[b] && before[a] == before[b] {
                        frontier.extend([a, b].into_iter().filter(|&at| std::mem::replace(&mut depth[at], 1) != 1));
                    }
                }
            }
        }
    }
    for distance in 2..=limit {
        let mut next = Vec::new();
        for (x, y) in frontier {
            for v in y.saturating_sub(1)..(y + 2).min(h) {
                for u in x.saturating_sub(1)..(x + 2).min(w) {
                    if depth[(u, v)] > distance {
                        depth[(u, v)] = distance;
                        next.push((u, v));
                    }
                }
            }
        }
        frontier = next;
    }
    depth
}

/// The node of pixels outside the band.
const OUTSIDE: u32 = u32::MAX;

/// The pixels near borders, which may change, and their labels.
struct Band {
    width: usize,
    height: usize,
    /// The pixel of each node, row by row.
    pixels: Vec<u32>,
    /// The node of each pixel.
    node: Vec<u32>,
    /// The labels in the band.
    labels: Vec<u8>,
    /// The index of each label in `labels`.
    label_index: [u32; 256],
}

impl Band {
    fn new(mask: &Plane<u8>, depth: &Plane<u32>, band: u32) -> Self {
        let mut pixels = Vec::new();
        let mut node = vec![OUTSIDE; depth.data().len()];
        let mut is_used = [false; 256];
        for (p, _) in depth.data().iter().enumerate().filter(|&(_, &d)| d <= band) {
            node[p] = pixels.len() as u32;
            pixels.push(p as u32);
            is_used[usize::from(mask.data()[p])] = true;
        }
        let labels: Vec<u8> = (0..=255).filter(|&l| is_used[usize::from(l)]).collect();
        let mut label_index = [0; 256];
        for (k, &l) in (0..).zip(&labels) {
            label_index[usize::from(l)] = k;
        }
        Self { width: mask.width(), height: mask.height(), pixels, node, labels, label_index }
    }

    /// Steps 2 and 3 without the edges.
    fn problem(&self, mask: &Plane<u8>, frame: &Frame, depth: &Plane<u32>, params: &RefineParams) -> Potts {
        let num_labels = self.labels.len();
        let mut unary = vec![0; self.pixels.len() * num_labels];
        let mut models = ColourModels::new(num_labels);
        let mut shares = vec![0.0; num_labels];
        for top in (0..self.height).step_by(TILE_PX) {
            for left in (0..self.width).step_by(TILE_PX) {
                let rows = top..(top + TILE_PX).min(self.height);
                let columns = left..(left + TILE_PX).min(self.width);
                let inside = || rows.clone().flat_map(|y| columns.clone().map(move |x| y * self.width + x));
                // Most tiles lie outside the band; their colour models would cost more than all the rest.
                if inside().all(|p| self.node[p] == OUTSIDE) {
                    continue;
                }
                models.fit(self, mask, frame, depth, left, top);
                for p in inside().filter(|&p| self.node[p] != OUTSIDE) {
                    let costs = &mut unary[self.node[p] as usize * num_labels..][..num_labels];
                    let present = self.label_index[usize::from(mask.data()[p])] as usize;
                    let depth = depth.data()[p] as f32 / params.band as f32;
                    let colour = Colour::from_rgb(&frame.rgb()[3 * p..]);
                    models.costs(colour, present, params.colour_weight, &mut *costs, &mut shares);
                    let keep = to_steps(params.displacement_weight * depth * depth);
                    for cost in costs.iter_mut().enumerate().filter(|(l, _)| *l != present).map(|(_, cost)| cost) {
                        *cost += keep;
                    }
                }
            }
        }
        Potts { num_nodes: self.pixels.len(), num_labels, unary, ..Potts::default() }
    }

    /// Step 3: adds the edges to four of the eight neighbours; the others add theirs in turn.
    fn add_contrast(&self, problem: &mut Potts, mask: &Plane<u8>, frame: &Frame, smoothness: f32, contrast: f32) {
        // The weights depend on the mean of all differences, so these are kept in their place first.
        let mut ties = Vec::new();
        let mut total = 0_u64;
        problem.edges.reserve(4 * self.pixels.len());
        problem.weights.reserve(4 * self.pixels.len());
        for y in 0..self.height {
            let row = |y: usize| &self.node[y * self.width..][..self.width];
            let (nodes, next) = (row(y), row((y + 1).min(self.height - 1)));
            for x in 0..self.width {
                let (before, after) = (x.saturating_sub(1), (x + 1).min(self.width - 1));
                // Skips nearly all pixels, which lie outside the band: `OUTSIDE` has all bits set.
                if nodes[x] & nodes[after] & next[before] & next[x] & next[after] == OUTSIDE {
                    continue;
                }
                let p = y * self.width + x;
                let (right, down, left) = (x + 1 < self.width, y + 1 < self.height, x > 0);
                let below = p + self.width;
                let neighbours =
                    [(right, p + 1), (down, below), (down && left, below.wrapping_sub(1)), (down && right, below + 1)];
                for (k, (_, q)) in neighbours.into_iter().enumerate().filter(|(_, (is_inside, _))| *is_inside) {
                    let (node, neighbour) = (self.node[p], self.node[q]);
                    // Also pairs with one end outside the band, which tie its edge to the labels outside.
                    if node == OUTSIDE && neighbour == OUTSIDE {
                        continue;
                    }
                    let difference = difference_sq(frame.rgb(), p, q);
                    total += u64::from(difference);
                    let difference = Difference::new(difference, k >= 2);
                    match (node, neighbour) {
                        (OUTSIDE, node) => ties.push((node, mask.data()[p], difference)),
                        (node, OUTSIDE) => ties.push((node, mask.data()[q], difference)),
                        ends => {
                            problem.edges.push(ends);
                            problem.weights.push(difference.0);
                        }
                    }
                }
            }
        }
        // A flat band has no contrast.
        let count = problem.edges.len() + ties.len();
        let variance = (contrast * (total as f32 / count.max(1) as f32)).max(1.0);
        let likeness = |difference: u32| libm::expf(-(difference as f32) / (2.0 * variance));
        let mut cache = vec![None; CACHED_DIFFERENCES];
        let mut weight = |difference: Difference| {
            let (difference, diagonal) = difference.parts();
            let length = if diagonal { std::f32::consts::FRAC_1_SQRT_2 } else { 1.0 };
            let likeness = match cache.get_mut(difference as usize) {
                Some(entry) => *entry.get_or_insert_with(|| likeness(difference)),
                None => likeness(difference),
            };
            to_steps(smoothness * length * likeness)
        };
        problem.weights.iter_mut().for_each(|value| *value = weight(Difference(*value)));
        for (node, label, difference) in ties {
            self.tie(problem, node, label, weight(difference));
        }
    }

    /// Adds an edge to a pixel whose label is fixed: all other labels cost its weight.
    fn tie(&self, problem: &mut Potts, node: u32, label: u8, weight: i32) {
        let num_labels = self.labels.len();
        let costs = &mut problem.unary[node as usize * num_labels..][..num_labels];
        for (cost, _) in costs.iter_mut().zip(&self.labels).filter(|(_, l)| **l != label) {
            *cost += weight;
        }
    }
}

/// The squared difference of two colours, and whether their pixels are diagonal neighbours.
#[derive(Debug, Clone, Copy)]
struct Difference(i32);

impl Difference {
    fn new(difference: u32, diagonal: bool) -> Self {
        Self((difference << 1 | u32::from(diagonal)).cast_signed())
    }

    fn parts(self) -> (u32, bool) {
        (self.0.cast_unsigned() >> 1, self.0 & 1 == 1)
    }
}

fn difference_sq(rgb: &[u8], p: usize, q: usize) -> u32 {
    (0..3).map(|c| u32::from(rgb[3 * p + c].abs_diff(rgb[3 * q + c])).pow(2)).sum()
}

/// Step 2: the colour models of the labels around a tile.
struct ColourModels {
    histograms: Vec<Histogram>,
    /// Samples that measure the separation.
    samples: Vec<(u32, Corners)>,
    /// Separation of the models, 0 to 1.
    separation: f32,
}

impl ColourModels {
    fn new(num_labels: usize) -> Self {
        Self { histograms: vec![Histogram::new(); num_labels], samples: Vec::new(), separation: 0.0 }
    }

    /// Fits the models to samples around the tile at `(left, top)`.
    fn fit(&mut self, band: &Band, mask: &Plane<u8>, frame: &Frame, depth: &Plane<u32>, left: usize, top: usize) {
        self.samples.clear();
        self.histograms.iter_mut().for_each(Histogram::clear);
        let mut count = 0;
        for y in (top.saturating_sub(SAMPLE_MARGIN_PX)..(top + TILE_PX + SAMPLE_MARGIN_PX).min(band.height))
            .step_by(SAMPLE_STRIDE_PX)
        {
            for x in (left.saturating_sub(SAMPLE_MARGIN_PX)..(left + TILE_PX + SAMPLE_MARGIN_PX).min(band.width))
                .step_by(SAMPLE_STRIDE_PX)
            {
                let p = y * band.width + x;
                let label = mask.data()[p];
                if depth.data()[p] >= MIN_SAMPLE_DEPTH_PX && band.labels.contains(&label) {
                    let index = band.label_index[usize::from(label)];
                    let colour = Colour::from_rgb(&frame.rgb()[3 * p..]).corners();
                    self.histograms[index as usize].add(&colour, 1.0);
                    if count % TEST_STRIDE == 0 {
                        self.samples.push((index, colour));
                    }
                    count += 1;
                }
            }
        }
        self.separation = self.measure_separation();
    }

    /// Returns the mean probability of the right label of a sample, scaled to 0 for chance and 1 for certainty. All labels count
    /// equally.
    fn measure_separation(&self) -> f32 {
        let mut sums = vec![(0.0, 0_u32); self.histograms.len()];
        let mut shares = vec![0.0; self.histograms.len()];
        for (label, colour) in &self.samples {
            let label = *label as usize;
            // The histogram without the sample itself.
            let share = self.histograms[label].leave_one_out_share(colour) + UNSEEN_SHARE;
            let other_shares = self.shares(colour, &mut shares) - shares[label];
            let (sum, count) = &mut sums[label];
            *sum += share / (share + other_shares);
            *count += 1;
        }
        let has_samples = |l: &usize| self.has_model(*l) && sums[*l].1 > 0;
        let labels: Vec<usize> = (0..sums.len()).filter(has_samples).collect();
        if labels.len() < 2 {
            return 0.0;
        }
        let mean = labels.iter().map(|&l| sums[l].0 / sums[l].1 as f32).sum::<f32>() / labels.len() as f32;
        let chance = 1.0 / labels.len() as f32;
        ((mean - chance) / (1.0 - chance)).clamp(0.0, 1.0)
    }

    fn has_model(&self, label: usize) -> bool {
        self.histograms[label].total() >= MIN_SAMPLES
    }

    /// Computes the likelihood of a colour for each label, 0 without a model, and returns the sum.
    fn shares(&self, colour: &Corners, shares: &mut [f32]) -> f32 {
        for (share, histogram) in shares.iter_mut().zip(&self.histograms) {
            *share = if histogram.total() >= MIN_SAMPLES { histogram.share(colour) + UNSEEN_SHARE } else { 0.0 };
        }
        shares.iter().sum()
    }

    /// Computes the cost of each label at a pixel of this colour and of label `present`. Labels are forbidden unless both have a
    /// model. `shares` is working memory, one number per label.
    fn costs(&self, colour: Colour, present: usize, weight: f32, costs: &mut [i32], shares: &mut [f32]) {
        let sum = self.shares(&colour.corners(), shares);
        for (l, (cost, share)) in costs.iter_mut().zip(shares).enumerate() {
            *cost = to_steps(match self.has_model(l) && self.has_model(present) {
                true => -weight * self.separation * libm::logf(*share / sum),
                false if l == present => 0.0,
                false => FORBIDDEN_COST,
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
            for (p, label) in label_changes(&mask, &none, &frame, &params, 1.0) {
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
