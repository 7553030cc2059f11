//! Pieces as words of 32 bits, to be sent to another worker and back.
//!
//! ```text
//! piece: epoch, kind, t, width, height | pixels
//! made:  epoch, kind, t, width, height | planes; or superpixels as runs, borders, edges
//! ```
//!
//! Both ends are of one version; what cannot be read, since it was cut short or tampered with, is nothing.

use super::pair::PairFlow;
use super::piece::{Made, Piece, PieceId, PieceKind, Work};
use crate::flow::FlowField;
use crate::image::{Frame, Plane, Runs};
use crate::superpixel::{Border, Edge, EdgeKind, Superpixels};

/// Words before the contents.
const HEAD: usize = 5;

impl PieceId {
    fn head(self, width: usize, height: usize) -> Vec<u32> {
        vec![self.epoch, self.kind as u32, self.t, width as u32, height as u32]
    }

    /// From the words of a piece, or the first of them.
    pub(crate) fn from_words(words: &[u32]) -> Option<Self> {
        let &[epoch, kind, t, ..] = words else { return None };
        let kind = [PieceKind::Pair, PieceKind::Superpixels, PieceKind::Mask].get(kind as usize).copied()?;
        Some(Self { epoch, kind, t })
    }
}

impl Piece {
    pub(crate) fn to_words(&self) -> Vec<u32> {
        let (Work::Pair(frame, _) | Work::Superpixels(frame) | Work::Mask(frame, _)) = &self.work;
        let mut words = self.id.head(frame.width(), frame.height());
        put_bytes(&mut words, frame.rgb());
        match &self.work {
            Work::Pair(_, to) => put_bytes(&mut words, to.rgb()),
            Work::Mask(_, labels) => put_bytes(&mut words, labels.data()),
            Work::Superpixels(_) => {}
        }
        words
    }

    pub(crate) fn from_words(words: &[u32]) -> Option<Self> {
        let id = PieceId::from_words(words)?;
        let mut reader = Reader::new(words)?;
        let frame = reader.frame()?;
        let work = match id.kind {
            PieceKind::Pair => Work::Pair(frame, reader.frame()?),
            PieceKind::Superpixels => Work::Superpixels(frame),
            PieceKind::Mask => Work::Mask(frame, reader.bytes()?),
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
                    words.extend(plane.data().iter().map(|v| v.to_bits()));
                }
                words
            }
            Self::Superpixels(found) => {
                let ((width, height), runs) = (found.runs().size(), found.runs().ends());
                let mut words = id.head(width, height);
                words.extend([runs.len() as u32, found.borders.len() as u32]);
                words.extend(runs.iter().flat_map(|&(end, label)| [end, label]));
                for Border { a, b, length, pb } in &found.borders {
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
                let border = |w: &[u32]| Border { a: w[0], b: w[1], length: float(w[2]), pb: float(w[3]) };
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
        };
        Some((id, made))
    }
}

fn float(word: u32) -> f32 {
    f32::from_bits(word)
}

/// Four bytes a word, the last filled up.
fn put_bytes(words: &mut Vec<u32>, bytes: &[u8]) {
    let (fours, rest) = bytes.as_chunks::<4>();
    words.extend(fours.iter().map(|&four| u32::from_le_bytes(four)));
    if !rest.is_empty() {
        let mut last = [0; 4];
        last[..rest.len()].copy_from_slice(rest);
        words.push(u32::from_le_bytes(last));
    }
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
        Plane::from_vec(width, height, self.take(width * height)?.iter().map(|&w| float(w)).collect())
    }

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
