//! Jobs and results as messages of 32-bit words, to be sent to another worker and back.
//!
//! ```text
//! job:    epoch, kind, index, width, height | pixels
//! result: epoch, kind, index, width, height | planes; or superpixels as runs, features, borders, edges
//! ```
//!
//! Jobs without a frame have the size 0 and a list of numbers. Both ends run the same version. Messages that are
//! truncated or corrupted decode to `None`.

use super::job::PairFlow;
use super::job::{DescribedSuperpixels, Job, JobId, JobInput, JobKind, JobResult};
use crate::affinity::{AffinityBlock, AffinityParams};
use crate::background::{ReferenceFrame, ReprojectionInput, WarpGrid};
use crate::camera::{Egomotion, PointMatches};
use crate::cut::Features;
use crate::discretize::NormalizedRows;
use crate::flow::{CompactFlow, FlowField};
use crate::image::{Frame, Plane, Runs};
use crate::saliency::SaliencyQuery;
use crate::superpixel::{Edge, EdgeKind, SuperpixelBorder, Superpixels};
use crate::trajectory::Trajectories;

/// Words before the payload: epoch, kind, index, width and height.
const HEADER_WORDS: usize = 5;

impl JobId {
    fn header(self, width: usize, height: usize) -> Vec<u32> {
        vec![self.epoch, self.kind as u32, self.index, width as u32, height as u32]
    }

    /// Decodes the id of a message that may end after it.
    pub(crate) fn decode(message: &[u32]) -> Option<Self> {
        let &[epoch, kind, index, ..] = message else { return None };
        let kind = JobKind::ALL.get(kind as usize).copied()?;
        Some(Self { epoch, kind, index })
    }
}

impl Job {
    pub(crate) fn encode(&self) -> Vec<u32> {
        let size = match &self.input {
            JobInput::PairFlow(frame, _) | JobInput::Superpixels(frame) | JobInput::Mask(frame, _) => {
                (frame.width(), frame.height())
            }
            JobInput::Saliency(query) => (query.bins.width(), query.bins.height()),
            JobInput::Affinities(rows) => rows.tracks.size,
            JobInput::CameraMotion(matches) => matches.size,
            JobInput::Rotation(rows) => (rows.k, 0),
            JobInput::Reprojection(input) => (input.picture.width(), input.picture.height()),
            JobInput::Delaunay(_) => (0, 0),
        };
        let mut message = self.id.header(size.0, size.1);
        match &self.input {
            JobInput::PairFlow(from, to) => {
                put_bytes(&mut message, from.rgb());
                put_bytes(&mut message, to.rgb());
            }
            JobInput::Superpixels(frame) => put_bytes(&mut message, frame.rgb()),
            JobInput::Mask(frame, labels) => {
                put_bytes(&mut message, frame.rgb());
                put_bytes(&mut message, labels.data());
            }
            JobInput::Saliency(query) => {
                put_bytes(&mut message, query.bins.data());
                message.extend(&query.pixels);
            }
            JobInput::Delaunay(points) => put_points(&mut message, points),
            JobInput::Affinities(rows) => {
                let AffinityBlock { tracks, first, count, params, radius, seed } = rows.as_ref();
                let AffinityParams { lambda, noise_floor, variation_weight, local_radius, .. } = *params;
                message.extend([tracks.num_frames, tracks.len(), *first, *count].map(|n| n as u32));
                message.extend([*seed, params.horizon, params.far_sampling, params.min_overlap]);
                message.extend([lambda, noise_floor, variation_weight, local_radius, *radius].map(f32::to_bits));
                message.extend(tracks.start_frame.iter().chain(&tracks.offset));
                [&tracks.x, &tracks.y, &tracks.variation].into_iter().for_each(|v| put_floats(&mut message, v));
            }
            JobInput::CameraMotion(matches) => put_floats(&mut message, matches.points.as_flattened()),
            JobInput::Rotation(rows) => put_doubles(&mut message, &rows.rows),
            JobInput::Reprojection(input) => {
                put_bytes(&mut message, input.picture.data().as_flattened());
                for ReferenceFrame { picture, scene, object } in &input.references {
                    put_bytes(&mut message, picture.data().as_flattened());
                    put_points(&mut message, &scene.0);
                    message.push(u32::from(object.is_some()));
                    object.iter().for_each(|object| put_points(&mut message, &object.0));
                }
            }
        }
        message
    }

    pub(crate) fn decode(message: &[u32]) -> Option<Self> {
        let id = JobId::decode(message)?;
        let mut reader = Reader::new(message)?;
        let input = match id.kind {
            JobKind::PairFlow => JobInput::PairFlow(reader.frame()?, reader.frame()?),
            JobKind::Superpixels => JobInput::Superpixels(reader.frame()?),
            JobKind::Mask => JobInput::Mask(reader.frame()?, reader.bytes()?),
            JobKind::Saliency => {
                JobInput::Saliency(SaliencyQuery { bins: reader.bytes()?, pixels: reader.rest.to_vec() })
            }
            JobKind::Delaunay => JobInput::Delaunay(reader.pairs(float)),
            JobKind::Affinities => JobInput::Affinities(Box::new(reader.rows()?)),
            JobKind::CameraMotion => {
                let points = reader.rest.as_chunks().0.iter().map(|point| point.map(float)).collect();
                JobInput::CameraMotion(PointMatches { size: reader.size, points })
            }
            JobKind::Rotation => JobInput::Rotation(NormalizedRows { k: reader.size.0, rows: reader.doubles() }),
            JobKind::Reprojection => JobInput::Reprojection(reader.reprojection_input()?),
        };
        Some(Self { id, input })
    }
}

impl JobResult {
    pub(crate) fn encode(&self, id: JobId) -> Vec<u32> {
        match self {
            Self::PairFlow(pair) => {
                let PairFlow { forward, backward, variation, structure } = pair.as_ref();
                let mut message = id.header(forward.u.width(), forward.u.height());
                for plane in [&forward.u, &forward.v, variation, structure] {
                    put_floats(&mut message, plane.data());
                }
                message.extend(backward.words());
                message
            }
            Self::Superpixels(DescribedSuperpixels { superpixels, features }) => {
                let ((width, height), runs) = (superpixels.runs().size(), superpixels.runs().ends());
                let mut message = id.header(width, height);
                message
                    .extend([runs.len(), superpixels.borders.len(), features.as_flattened().len()].map(|n| n as u32));
                message.extend(runs.iter().flat_map(|&(end, label)| [end, label]));
                put_floats(&mut message, features.as_flattened());
                for SuperpixelBorder { a, b, length, pb } in &superpixels.borders {
                    message.extend([*a, *b, length.to_bits(), pb.to_bits()]);
                }
                for Edge { from, to, kind } in &superpixels.edges {
                    message.extend([from.0, from.1, to.0, to.1].map(f32::to_bits));
                    message.push(*kind as u32);
                }
                message
            }
            Self::Mask(mask) => {
                let mut message = id.header(mask.width(), mask.height());
                put_bytes(&mut message, mask.data());
                message
            }
            Self::Saliency(saliency) => {
                let mut message = id.header(0, 0);
                put_floats(&mut message, saliency);
                message
            }
            Self::Delaunay(edges) => {
                let mut message = id.header(0, 0);
                edges.iter().for_each(|&(a, b)| message.extend_from_slice(&[a, b]));
                message
            }
            Self::Affinities(entries) => {
                let mut message = id.header(0, 0);
                entries.iter().for_each(|&(i, j, w)| message.extend_from_slice(&[i, j, w.to_bits()]));
                message
            }
            Self::CameraMotion(motion) => {
                let mut message = id.header(0, 0);
                if let Some((forward, is_sure)) = motion {
                    put_doubles(&mut message, &forward.to_array());
                    message.push(u32::from(*is_sure));
                }
                message
            }
            Self::Rotation(labels) => [&id.header(0, 0), labels.as_slice()].concat(),
            Self::Reprojection(errors) => {
                let mut message = id.header(errors.width(), errors.height());
                put_bytes(&mut message, errors.data().as_flattened());
                message
            }
        }
    }

    pub(crate) fn decode(message: &[u32]) -> Option<(JobId, Self)> {
        let id = JobId::decode(message)?;
        let mut reader = Reader::new(message)?;
        let (width, height) = reader.size;
        let result = match id.kind {
            JobKind::PairFlow => {
                let [u, v] = [(); 2].map(|()| reader.floats(width, height));
                let forward = FlowField { u: u?, v: v? };
                let [variation, structure] = [(); 2].map(|()| reader.floats(width.div_ceil(2), height.div_ceil(2)));
                let (variation, structure) = (variation?, structure?);
                let backward = CompactFlow::from_words(width, height, reader.rest)?;
                Self::PairFlow(Box::new(PairFlow { forward, backward, variation, structure }))
            }
            JobKind::Superpixels => {
                let [num_runs, num_borders, num_values] = reader.array()?;
                let runs = reader.read(2 * num_runs as usize)?.as_chunks().0.iter().map(|&[end, label]| (end, label));
                let runs = Runs::from_vec(width, height, runs.collect())?;
                runs.ends().iter().all(|&(_, label)| label < num_runs).then_some(())?;
                let features: Vec<Features> = reader.read_floats(num_values as usize)?.as_chunks().0.to_vec();
                let borders = reader.read(4 * num_borders as usize)?.chunks_exact(4);
                let border = |w: &[u32]| SuperpixelBorder { a: w[0], b: w[1], length: float(w[2]), pb: float(w[3]) };
                let edge = |w: &[u32]| {
                    let kind = [EdgeKind::Constraint, EdgeKind::Frame, EdgeKind::Gabriel, EdgeKind::Deleted]
                        .get(w[4] as usize)?;
                    Some(Edge { from: (float(w[0]), float(w[1])), to: (float(w[2]), float(w[3])), kind: *kind })
                };
                let borders = borders.map(border).collect();
                let edges = reader.rest.chunks_exact(5).map(edge).collect::<Option<_>>()?;
                let superpixels = Superpixels::new(runs, borders, edges);
                (features.len() == superpixels.count).then_some(())?;
                Self::Superpixels(DescribedSuperpixels { superpixels, features })
            }
            JobKind::Mask => Self::Mask(reader.bytes()?),
            JobKind::Saliency => Self::Saliency(reader.read_floats(reader.rest.len())?),
            JobKind::Delaunay => Self::Delaunay(reader.pairs(|w| w)),
            JobKind::Affinities => {
                Self::Affinities(reader.rest.as_chunks().0.iter().map(|&[i, j, w]| (i, j, float(w))).collect())
            }
            JobKind::CameraMotion => Self::CameraMotion(match reader.rest.split_last() {
                Some((&is_sure, _)) => Some((Egomotion::from_array(reader.doubles().try_into().ok()?), is_sure == 1)),
                None => None,
            }),
            JobKind::Rotation => Self::Rotation(reader.rest.to_vec()),
            JobKind::Reprojection => Self::Reprojection(reader.pixels()?),
        };
        Some((id, result))
    }
}

fn float(word: u32) -> f32 {
    f32::from_bits(word)
}

/// Packs four bytes into a word; the last word is padded with zeros.
#[inline(never)]
fn put_bytes(message: &mut Vec<u32>, bytes: &[u8]) {
    let (quads, tail) = bytes.as_chunks::<4>();
    message.extend(quads.iter().map(|&quad| u32::from_le_bytes(quad)));
    if !tail.is_empty() {
        let mut last = [0; 4];
        last[..tail.len()].copy_from_slice(tail);
        message.push(u32::from_le_bytes(last));
    }
}

fn put_floats(message: &mut Vec<u32>, values: &[f32]) {
    message.extend(values.iter().map(|v| v.to_bits()));
}

#[inline(never)]
fn put_points(message: &mut Vec<u32>, points: &[(f32, f32)]) {
    points.iter().for_each(|(x, y)| message.extend_from_slice(&[x.to_bits(), y.to_bits()]));
}

/// Writes each number as two words, the lower one first.
#[inline(never)]
fn put_doubles(message: &mut Vec<u32>, values: &[f64]) {
    values.iter().map(|v| v.to_bits()).for_each(|v| message.extend_from_slice(&[v as u32, (v >> 32) as u32]));
}

/// A cursor over the payload of a message.
struct Reader<'a> {
    size: (usize, usize),
    rest: &'a [u32],
}

impl<'a> Reader<'a> {
    fn new(message: &'a [u32]) -> Option<Self> {
        let (&[.., width, height], rest) = message.split_first_chunk::<HEADER_WORDS>()?;
        Some(Self { size: (width as usize, height as usize), rest })
    }

    fn read(&mut self, count: usize) -> Option<&'a [u32]> {
        let (head, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(head)
    }

    fn floats(&mut self, width: usize, height: usize) -> Option<Plane<f32>> {
        Plane::from_vec(width, height, self.read_floats(width * height)?)
    }

    /// Returns the remaining words in pairs.
    fn pairs<T>(&self, convert: impl Fn(u32) -> T) -> Vec<(T, T)> {
        self.rest.as_chunks().0.iter().map(|&[a, b]| (convert(a), convert(b))).collect()
    }

    /// Returns the remaining words as doubles.
    fn doubles(&self) -> Vec<f64> {
        let double = |&[low, high]: &[u32; 2]| f64::from_bits(u64::from(low) | u64::from(high) << 32);
        self.rest.as_chunks().0.iter().map(double).collect()
    }

    #[inline(never)]
    fn read_floats(&mut self, count: usize) -> Option<Vec<f32>> {
        Some(self.read(count)?.iter().map(|&w| float(w)).collect())
    }

    fn rows(&mut self) -> Option<AffinityBlock> {
        let [num_frames, len, first, count] = self.array()?.map(|n| n as usize);
        let [seed, horizon, far_sampling, min_overlap] = self.array()?;
        let [lambda, noise_floor, variation_weight, local_radius, radius] = self.array()?.map(float);
        let (start_frame, offset) = (self.read(len)?.to_vec(), self.read(len.checked_add(1)?)?.to_vec());
        let points = *offset.last()? as usize;
        let [x, y, variation] = [(); 3].map(|()| self.read_floats(points));
        let (x, y, variation) = (x?, y?, variation?);
        let tracks = Trajectories { num_frames, size: self.size, start_frame, offset, x, y, variation };
        let params =
            AffinityParams { lambda, horizon, noise_floor, variation_weight, local_radius, far_sampling, min_overlap };
        Some(AffinityBlock { tracks, first, count, params, radius, seed })
    }

    fn reprojection_input(&mut self) -> Option<ReprojectionInput> {
        let picture = self.pixels()?;
        let mut references = Vec::new();
        while !self.rest.is_empty() {
            let (picture, scene, [has_object]) = (self.pixels()?, self.warp_grid()?, self.array()?);
            let object = if has_object == 1 { Some(self.warp_grid()?) } else { None };
            references.push(ReferenceFrame { picture, scene, object });
        }
        Some(ReprojectionInput { picture, references })
    }

    fn warp_grid(&mut self) -> Option<WarpGrid> {
        let (columns, rows) = WarpGrid::dimensions(self.size);
        let rest = self.read(2 * columns * rows)?;
        Some(WarpGrid(Reader { size: self.size, rest }.pairs(float)))
    }

    /// Reads a plane of pixels of `N` bytes each.
    fn pixels<const N: usize>(&mut self) -> Option<Plane<[u8; N]>> {
        let (width, height) = self.size;
        Plane::from_vec(width, height, self.raw(N * width * height)?.as_chunks().0.to_vec())
    }

    fn array<const N: usize>(&mut self) -> Option<[u32; N]> {
        self.read(N)?.try_into().ok()
    }

    #[inline(never)]
    fn raw(&mut self, count: usize) -> Option<Vec<u8>> {
        let mut bytes: Vec<u8> = self.read(count.div_ceil(4))?.iter().flat_map(|w| w.to_le_bytes()).collect();
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
