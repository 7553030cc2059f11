//! Pieces as words of 32 bits, to be sent to another worker and back.
//!
//! ```text
//! piece: epoch, kind, t, width, height | pixels
//! made:  epoch, kind, t, width, height | planes; or superpixels as runs, borders, edges
//! ```
//!
//! What has no frame has the size 0, and a list of numbers.
//!
//! Both ends are of one version; what cannot be read, since it was cut short or tampered with, is nothing.

use super::pair::PairFlow;
use super::piece::{Made, Piece, PieceId, PieceKind, Work};
use crate::affinity::{AffinityParams, Rows};
use crate::background::{ReferenceFrame, ReprojectionInput, WarpGrid};
use crate::camera::{Egomotion, PointMatches};
use crate::discretize::NormalizedRows;
use crate::flow::FlowField;
use crate::image::{Frame, Plane, Runs};
use crate::saliency::SaliencyQuery;
use crate::superpixel::{Edge, EdgeKind, SuperpixelBorder, Superpixels};
use crate::trajectory::Trajectories;

/// Words before the contents.
const HEAD: usize = 5;

impl PieceId {
    fn head(self, width: usize, height: usize) -> Vec<u32> {
        vec![self.epoch, self.kind as u32, self.t, width as u32, height as u32]
    }

    /// From the words of a piece, or the first of them.
    pub(crate) fn from_words(words: &[u32]) -> Option<Self> {
        let &[epoch, kind, t, ..] = words else { return None };
        let kind = PieceKind::ALL.get(kind as usize).copied()?;
        Some(Self { epoch, kind, t })
    }
}

impl Piece {
    pub(crate) fn to_words(&self) -> Vec<u32> {
        let size = match &self.work {
            Work::Pair(frame, _) | Work::Superpixels(frame) | Work::Mask(frame, _) => (frame.width(), frame.height()),
            Work::Saliency(query) => (query.bins.width(), query.bins.height()),
            Work::Affinities(rows) => rows.tracks.size,
            Work::Ways(matches) => matches.size,
            Work::Rotation(rows) => (rows.k, 0),
            Work::Accounts(input) => (input.picture.width(), input.picture.height()),
            Work::Graph(_) => (0, 0),
        };
        let mut words = self.id.head(size.0, size.1);
        match &self.work {
            Work::Pair(from, to) => {
                put_bytes(&mut words, from.rgb());
                put_bytes(&mut words, to.rgb());
            }
            Work::Superpixels(frame) => put_bytes(&mut words, frame.rgb()),
            Work::Mask(frame, labels) => {
                put_bytes(&mut words, frame.rgb());
                put_bytes(&mut words, labels.data());
            }
            Work::Saliency(query) => {
                put_bytes(&mut words, query.bins.data());
                words.extend(&query.pixels);
            }
            Work::Graph(points) => put_points(&mut words, points),
            Work::Affinities(rows) => {
                let Rows { tracks, first, count, params, radius, seed } = rows.as_ref();
                let AffinityParams { lambda, noise_floor, variation_weight, local_radius, .. } = *params;
                words.extend([tracks.num_frames, tracks.len(), *first, *count].map(|n| n as u32));
                words.extend([*seed, params.horizon, params.far_sampling, params.min_overlap]);
                words.extend([lambda, noise_floor, variation_weight, local_radius, *radius].map(f32::to_bits));
                words.extend(tracks.start_frame.iter().chain(&tracks.offset));
                [&tracks.x, &tracks.y, &tracks.variation].into_iter().for_each(|v| put_floats(&mut words, v));
            }
            Work::Ways(matches) => put_floats(&mut words, matches.points.as_flattened()),
            Work::Rotation(rows) => put_doubles(&mut words, &rows.rows),
            Work::Accounts(input) => {
                put_bytes(&mut words, input.picture.data().as_flattened());
                for ReferenceFrame { picture, scene, object } in &input.references {
                    put_bytes(&mut words, picture.data().as_flattened());
                    put_points(&mut words, &scene.0);
                    words.push(u32::from(object.is_some()));
                    object.iter().for_each(|object| put_points(&mut words, &object.0));
                }
            }
        }
        words
    }

    pub(crate) fn from_words(words: &[u32]) -> Option<Self> {
        let id = PieceId::from_words(words)?;
        let mut reader = Reader::new(words)?;
        let work = match id.kind {
            PieceKind::Pair => Work::Pair(reader.frame()?, reader.frame()?),
            PieceKind::Superpixels => Work::Superpixels(reader.frame()?),
            PieceKind::Mask => Work::Mask(reader.frame()?, reader.bytes()?),
            PieceKind::Saliency => {
                Work::Saliency(SaliencyQuery { bins: reader.bytes()?, pixels: reader.left.to_vec() })
            }
            PieceKind::Graph => Work::Graph(reader.pairs(float)),
            PieceKind::Affinities => Work::Affinities(Box::new(reader.rows()?)),
            PieceKind::Ways => {
                let points = reader.left.as_chunks().0.iter().map(|point| point.map(float)).collect();
                Work::Ways(PointMatches { size: reader.size, points })
            }
            PieceKind::Rotation => Work::Rotation(NormalizedRows { k: reader.size.0, rows: reader.doubles() }),
            PieceKind::Accounts => Work::Accounts(reader.reprojection_input()?),
        };
        Some(Self { id, work })
    }
}

impl Made {
    pub(crate) fn to_words(&self, id: PieceId) -> Vec<u32> {
        match self {
            Self::Pair(pair) => {
                let PairFlow { forward, backward, variation, structure } = pair.as_ref();
                let mut words = id.head(forward.u.width(), forward.u.height());
                for plane in [&forward.u, &forward.v, &backward.u, &backward.v, variation, structure] {
                    put_floats(&mut words, plane.data());
                }
                words
            }
            Self::Superpixels(found) => {
                let ((width, height), runs) = (found.runs().size(), found.runs().ends());
                let mut words = id.head(width, height);
                words.extend([runs.len() as u32, found.borders.len() as u32]);
                words.extend(runs.iter().flat_map(|&(end, label)| [end, label]));
                for SuperpixelBorder { a, b, length, pb } in &found.borders {
                    words.extend([*a, *b, length.to_bits(), pb.to_bits()]);
                }
                for Edge { from, to, kind } in &found.edges {
                    words.extend([from.0, from.1, to.0, to.1].map(f32::to_bits));
                    words.push(*kind as u32);
                }
                words
            }
            Self::Mask(mask) => {
                let mut words = id.head(mask.width(), mask.height());
                put_bytes(&mut words, mask.data());
                words
            }
            Self::Saliency(found) => {
                let mut words = id.head(0, 0);
                put_floats(&mut words, found);
                words
            }
            Self::Graph(edges) => {
                let mut words = id.head(0, 0);
                edges.iter().for_each(|&(a, b)| words.extend_from_slice(&[a, b]));
                words
            }
            Self::Affinities(entries) => {
                let mut words = id.head(0, 0);
                entries.iter().for_each(|&(i, j, w)| words.extend_from_slice(&[i, j, w.to_bits()]));
                words
            }
            Self::Ways(found) => {
                let mut words = id.head(0, 0);
                if let Some((egomotion, is_sure)) = found {
                    put_doubles(&mut words, &egomotion.to_array());
                    words.push(u32::from(*is_sure));
                }
                words
            }
            Self::Rotation(labels) => [&id.head(0, 0), labels.as_slice()].concat(),
            Self::Accounts(made) => {
                let mut words = id.head(made.width(), made.height());
                put_bytes(&mut words, made.data().as_flattened());
                words
            }
        }
    }

    pub(crate) fn from_words(words: &[u32]) -> Option<(PieceId, Self)> {
        let id = PieceId::from_words(words)?;
        let mut reader = Reader::new(words)?;
        let (width, height) = reader.size;
        let made = match id.kind {
            PieceKind::Pair => {
                let [fu, fv, bu, bv] = [(); 4].map(|()| reader.floats((width, height)));
                let (forward, backward) = (FlowField { u: fu?, v: fv? }, FlowField { u: bu?, v: bv? });
                let [variation, structure] = [(); 2].map(|()| reader.floats((width.div_ceil(2), height.div_ceil(2))));
                Self::Pair(Box::new(PairFlow { forward, backward, variation: variation?, structure: structure? }))
            }
            PieceKind::Superpixels => {
                let &[num_runs, num_borders] = reader.take(2)? else { return None };
                let runs = reader.take(2 * num_runs as usize)?.as_chunks().0.iter().map(|&[end, label]| (end, label));
                let runs = Runs::from_vec(width, height, runs.collect())?;
                runs.ends().iter().all(|&(_, label)| label < num_runs).then_some(())?;
                let borders = reader.take(4 * num_borders as usize)?.chunks_exact(4);
                let border = |w: &[u32]| SuperpixelBorder { a: w[0], b: w[1], length: float(w[2]), pb: float(w[3]) };
                let edge = |w: &[u32]| {
                    let kind = [EdgeKind::Constraint, EdgeKind::Frame, EdgeKind::Gabriel, EdgeKind::Deleted]
                        .get(w[4] as usize)?;
                    Some(Edge { from: (float(w[0]), float(w[1])), to: (float(w[2]), float(w[3])), kind: *kind })
                };
                let borders = borders.map(border).collect();
                let edges = reader.left.chunks_exact(5).map(edge).collect::<Option<_>>()?;
                Self::Superpixels(Superpixels::new(runs, borders, edges))
            }
            PieceKind::Mask => Self::Mask(reader.bytes()?),
            PieceKind::Saliency => Self::Saliency(reader.singles(reader.left.len())?),
            PieceKind::Graph => Self::Graph(reader.pairs(|w| w)),
            PieceKind::Affinities => {
                Self::Affinities(reader.left.as_chunks().0.iter().map(|&[i, j, w]| (i, j, float(w))).collect())
            }
            PieceKind::Ways => Self::Ways(match reader.left.split_last() {
                Some((&is_sure, _)) => Some((Egomotion::from_array(reader.doubles().try_into().ok()?), is_sure == 1)),
                None => None,
            }),
            PieceKind::Rotation => Self::Rotation(reader.left.to_vec()),
            PieceKind::Accounts => Self::Accounts(reader.pixels()?),
        };
        Some((id, made))
    }
}

fn float(word: u32) -> f32 {
    f32::from_bits(word)
}

/// Four bytes a word, the last filled up.
#[inline(never)]
fn put_bytes(words: &mut Vec<u32>, bytes: &[u8]) {
    let (fours, rest) = bytes.as_chunks::<4>();
    words.extend(fours.iter().map(|&four| u32::from_le_bytes(four)));
    if !rest.is_empty() {
        let mut last = [0; 4];
        last[..rest.len()].copy_from_slice(rest);
        words.push(u32::from_le_bytes(last));
    }
}

fn put_floats(words: &mut Vec<u32>, values: &[f32]) {
    words.extend(values.iter().map(|v| v.to_bits()));
}

#[inline(never)]
fn put_points(words: &mut Vec<u32>, points: &[(f32, f32)]) {
    points.iter().for_each(|(x, y)| words.extend_from_slice(&[x.to_bits(), y.to_bits()]));
}

/// Each in two words, the lower one first.
#[inline(never)]
fn put_doubles(words: &mut Vec<u32>, values: &[f64]) {
    values.iter().map(|v| v.to_bits()).for_each(|v| words.extend_from_slice(&[v as u32, (v >> 32) as u32]));
}

/// What is left to read.
struct Reader<'a> {
    size: (usize, usize),
    left: &'a [u32],
}

impl<'a> Reader<'a> {
    fn new(words: &'a [u32]) -> Option<Self> {
        let (&[.., width, height], left) = words.split_first_chunk::<HEAD>()?;
        Some(Self { size: (width as usize, height as usize), left })
    }

    fn take(&mut self, count: usize) -> Option<&'a [u32]> {
        let (taken, left) = self.left.split_at_checked(count)?;
        self.left = left;
        Some(taken)
    }

    fn floats(&mut self, (width, height): (usize, usize)) -> Option<Plane<f32>> {
        Plane::from_vec(width, height, self.singles(width * height)?)
    }

    /// All that is left, two by two.
    fn pairs<T>(&self, of: impl Fn(u32) -> T) -> Vec<(T, T)> {
        self.left.as_chunks().0.iter().map(|&[a, b]| (of(a), of(b))).collect()
    }

    /// All that is left.
    fn doubles(&self) -> Vec<f64> {
        let double = |&[low, high]: &[u32; 2]| f64::from_bits(u64::from(low) | u64::from(high) << 32);
        self.left.as_chunks().0.iter().map(double).collect()
    }

    #[inline(never)]
    fn singles(&mut self, count: usize) -> Option<Vec<f32>> {
        Some(self.take(count)?.iter().map(|&w| float(w)).collect())
    }

    fn rows(&mut self) -> Option<Rows> {
        let [num_frames, len, first, count] = self.array()?.map(|n| n as usize);
        let [seed, horizon, far_sampling, min_overlap] = self.array()?;
        let [lambda, noise_floor, variation_weight, local_radius, radius] = self.array()?.map(float);
        let (start_frame, offset) = (self.take(len)?.to_vec(), self.take(len.checked_add(1)?)?.to_vec());
        let points = *offset.last()? as usize;
        let [x, y, variation] = [(); 3].map(|()| self.singles(points));
        let (x, y, variation) = (x?, y?, variation?);
        let tracks = Trajectories { num_frames, size: self.size, start_frame, offset, x, y, variation };
        let params =
            AffinityParams { lambda, horizon, noise_floor, variation_weight, local_radius, far_sampling, min_overlap };
        Some(Rows { tracks, first, count, params, radius, seed })
    }

    fn reprojection_input(&mut self) -> Option<ReprojectionInput> {
        let picture = self.pixels()?;
        let mut references = Vec::new();
        while !self.left.is_empty() {
            let (picture, scene, [has_object]) = (self.pixels()?, self.warp_grid()?, self.array()?);
            let object = if has_object == 1 { Some(self.warp_grid()?) } else { None };
            references.push(ReferenceFrame { picture, scene, object });
        }
        Some(ReprojectionInput { picture, references })
    }

    fn warp_grid(&mut self) -> Option<WarpGrid> {
        let (columns, rows) = WarpGrid::dimensions(self.size);
        let left = self.take(2 * columns * rows)?;
        Some(WarpGrid(Reader { size: self.size, left }.pairs(float)))
    }

    /// A plane of pixels of some bytes each.
    fn pixels<const N: usize>(&mut self) -> Option<Plane<[u8; N]>> {
        let (width, height) = self.size;
        Plane::from_vec(width, height, self.raw(N * width * height)?.as_chunks().0.to_vec())
    }

    fn array<const N: usize>(&mut self) -> Option<[u32; N]> {
        self.take(N)?.try_into().ok()
    }

    #[inline(never)]
    fn raw(&mut self, count: usize) -> Option<Vec<u8>> {
        let mut bytes: Vec<u8> = self.take(count.div_ceil(4))?.iter().flat_map(|w| w.to_le_bytes()).collect();
        bytes.truncate(count);
        Some(bytes)
    }

    fn frame(&mut self) -> Option<Frame> {
        let (width, height) = self.size;
        Frame::from_rgb(self.raw(3 * width * height)?, width, height).ok()
    }

    fn bytes(&mut self) -> Option<Plane<u8>> {
        let (width, height) = self.size;
        Plane::from_vec(width, height, self.raw(width * height)?)
    }
}
