//! Why a pixel has its label: the terms of the cut, made again from what the session keeps, and what is behind them.

use super::clip::Clip;
use super::dense::place;
use super::found::Segmented;
use super::results::missing_frame;
use super::session::{Phase, Session};
use super::state::State;
use crate::Error;
use crate::cut::{CutInput, Reasons};

/// Of a trajectory's affinities the greatest so many are told.
const MOST_AFFINITIES: usize = 8;

/// What gave a pixel its label.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Its superpixel, by the cut.
    Superpixel,
    /// The step after the cut, which moves borders by the colours on both sides (or, after a correction, leaves them).
    Border,
    /// A stroke of the user's.
    Stroke,
}

/// A trajectory in a superpixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Voter {
    /// Where it is in the frame, in input pixels.
    pub at: (f32, f32),
    /// Its cluster, or [`STRANGER`](crate::cut::STRANGER) or [`UNKNOWN`](crate::cut::UNKNOWN).
    pub cluster: u32,
}

/// The least change of a superpixel's label that changes its object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunnerUp {
    /// The cluster that is cheapest among those of other mask labels.
    pub cluster: u32,
    /// What it costs more, in steps of 1/65536.
    pub margin: i64,
    /// How many more trajectories of that cluster would make it as cheap; `None` where no number would.
    pub votes: Option<u32>,
}

/// The Delaunay edges of a frame between the pixel's object and that of the runner-up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rim {
    /// Their number.
    pub edges: u32,
    /// Their mean discontinuity d.
    pub mean: f64,
    /// The trajectories of the edge with the greatest d, and that d.
    pub strongest: (u32, u32, f64),
}

/// Why a pixel has its label; made by [`Session::explain`].
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The pixel's mask label.
    pub label: u8,
    /// What gave it that. Where it is not [`Source::Superpixel`], the terms are those of the superpixel all the same.
    pub source: Source,
    /// The superpixel that the pixel is in.
    pub superpixel: u32,
    /// Mask label of each cluster.
    pub of_cluster: Vec<u8>,
    /// The terms of the superpixel; labels are clusters.
    pub reasons: Reasons,
    /// What the background says for an object here, and against it where negative, in units of cost.
    pub cues: f32,
    /// The same of what objects and the ground near them look like.
    pub looks: f32,
    /// `None` where there is no other object, nor a background.
    pub runner_up: Option<RunnerUp>,
    /// The trajectories in the superpixel.
    pub voters: Vec<Voter>,
    /// The clustered trajectory nearest to the pixel; `None` where none is alive.
    pub nearest: Option<u32>,
    /// Its greatest affinities, and to whom.
    pub affinities: Vec<(u32, f64)>,
    /// `None` where no edge joins the two.
    pub rim: Option<Rim>,
}

impl Session {
    /// Why the pixel `x`, `y` of frame `t` has its label; in input pixels, computed anew at each call.
    ///
    /// Law: for any two clusters, the difference of [`Reasons::cost`] is that of the cut's energies with the pixel's
    /// superpixel in the one and the other, all else as it is.
    ///
    /// # Errors
    /// [`Error::State`] unless the session is done and has masks, or when there is no such frame; [`Error::Param`] when
    /// the pixel is not in the frame.
    pub fn explain(&self, t: usize, x: usize, y: usize) -> Result<Explanation, Error> {
        let Phase::Begun(clip, State::Segmented(found)) = &self.phase else {
            return Err(missing_frame("explanation", t, 0));
        };
        if t >= found.masks.len() {
            return Err(missing_frame("explanation", t, found.masks.len()));
        }
        for (name, value, side) in [("x", x, clip.scale.input.0), ("y", y, clip.scale.input.1)] {
            if value >= side {
                let expected = format!("a whole number in 0..{side}");
                return Err(Error::Param { name: name.to_owned(), value: value.to_string(), expected });
            }
        }
        Ok(Asked { clip, found, t, pixel: place(clip.scale, x, y) }.explanation((x, y)))
    }
}

/// A pixel that is asked about, at working size.
struct Asked<'a> {
    clip: &'a Clip,
    found: &'a Segmented,
    t: usize,
    pixel: (usize, usize),
}

impl Asked<'_> {
    fn explanation(&self, at: (usize, usize)) -> Explanation {
        let Segmented { parts, cut, masks } = self.found;
        let (ground, params) = (&*cut.ground, &self.clip.params.cut);
        let input = found_input(self.found, self.clip);
        let superpixel = parts.superpixels[self.t].label[self.pixel];
        let mut reasons = Reasons::of(&input, params, &cut.labels, self.t, superpixel);
        let held = ground.region.iter().flat_map(|region| &region.held);
        held.filter(|held| (held.0, held.1) == (self.t, superpixel)).for_each(|held| reasons.hold(&held.2));
        let node = parts.superpixels[..self.t].iter().map(|s| s.count).sum::<usize>() + superpixel as usize;
        let said = |by: &[f32]| by.get(node).copied().unwrap_or(0.0);
        let runner_up = reasons.runner_up(|cluster| self.found.label_of(cluster) != self.found.label_of(reasons.label));
        let (label, nearest) = (masks[self.t][self.pixel], self.nearest(at));
        Explanation {
            label,
            source: self.source(label, reasons.label),
            superpixel,
            of_cluster: cut.objects.of_cluster.clone(),
            cues: said(&ground.cues),
            looks: said(&ground.evidence) - said(&ground.cues),
            runner_up: runner_up.map(|(cluster, margin)| {
                let votes = reasons.votes_to_flip(cluster, params);
                RunnerUp { cluster, margin, votes }
            }),
            voters: self.voters(&input, &reasons),
            nearest,
            affinities: nearest.map_or_else(Vec::new, |i| self.affinities(i)),
            rim: runner_up.and_then(|(cluster, _)| self.rim(reasons.label, cluster)),
            reasons,
        }
    }

    fn source(&self, label: u8, cluster: u32) -> Source {
        let pixel = (self.pixel.1 * self.clip.scale.working.0 + self.pixel.0) as u32;
        let held = &self.found.parts.corrections.held;
        if held.iter().any(|held| held.t == self.t && held.pixels.binary_search(&pixel).is_ok()) {
            return Source::Stroke;
        }
        if label == self.found.label_of(cluster) { Source::Superpixel } else { Source::Border }
    }

    fn voters(&self, input: &CutInput, reasons: &Reasons) -> Vec<Voter> {
        let (sx, sy) = (self.clip.scale.x(), self.clip.scale.y());
        let to_input = |v: f32, s: f64| ((f64::from(v) + 0.5) * s - 0.5) as f32;
        let voter = |&i: &u32| {
            let (x, y) = input.tracks.at(i as usize, self.t).unwrap_or_default();
            Voter { at: (to_input(x, sx), to_input(y, sy)), cluster: input.label[i as usize] }
        };
        reasons.voters.iter().map(voter).collect()
    }

    /// The clustered trajectory nearest to the pixel in input pixels, the first of equals.
    fn nearest(&self, at: (usize, usize)) -> Option<u32> {
        let away = |x: f32, y: f32| {
            let (dx, dy) = (f64::from(x) - at.0 as f64, f64::from(y) - at.1 as f64);
            dx * dx + dy * dy
        };
        let tracks = &self.found.parts.clustered.embedded.tracked.input;
        let near = tracks.alive(self.t).map(|(i, x, y)| (i as u32, away(x, y)));
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// The greatest affinities of trajectory `i`, the first of equals first.
    fn affinities(&self, i: u32) -> Vec<(u32, f64)> {
        let row = self.found.parts.clustered.embedded.affinities.row(i as usize);
        let mut greatest: Vec<(u32, f64)> = Vec::new();
        for (j, affinity) in row.filter(|&(j, _)| j != i as usize) {
            let place = greatest.partition_point(|&(_, known)| known >= affinity);
            greatest.insert(place, (j as u32, affinity));
            greatest.truncate(MOST_AFFINITIES);
        }
        greatest
    }

    /// The edges of this frame between the objects of two clusters.
    fn rim(&self, own: u32, other: u32) -> Option<Rim> {
        let clustered = &self.found.parts.clustered;
        let edges = &clustered.embedded.discontinuities;
        let [own, other] = [own, other].map(|cluster| self.found.label_of(cluster));
        let label = |i: u32| self.found.label_of(clustered.clusters.label[i as usize]);
        let mut rim = Rim { edges: 0, mean: 0.0, strongest: (0, 0, -1.0) };
        for &edge in edges.neighborhoods.frame(self.t) {
            let ((i, j), d) = (edges.neighborhoods.pairs[edge as usize], edges.d[edge as usize]);
            if [(own, other), (other, own)].contains(&(label(i), label(j))) {
                rim.edges += 1;
                rim.mean += d;
                rim.strongest = if d > rim.strongest.2 { (i, j, d) } else { rim.strongest };
            }
        }
        rim.mean /= f64::from(rim.edges);
        (rim.edges > 0).then_some(rim)
    }
}

/// What the cut in force was made from.
pub(super) fn found_input<'a>(found: &'a Segmented, clip: &'a Clip) -> CutInput<'a> {
    let ground = &*found.cut.ground;
    found.parts.input(ground.voted.as_deref(), &ground.is_object, &ground.evidence, clip)
}
