//! Why a pixel has its label: the terms of the cut, made again from what the session keeps, and what is behind them.

use super::results::missing_frame;
use crate::Error;
use crate::cut::{CutInput, Link, OUTLIER, STEPS_PER_UNIT, SuperpixelTerms};
use crate::session::base::{Outputs, Stage};
use crate::session::run::{Clip, Session};
use serde::{Serialize, Serializer};

/// How many of a trajectory's affinities are told, the greatest first.
const MOST_AFFINITIES: usize = 8;

/// What gave a pixel its label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Source {
    /// Its superpixel, by the cut.
    Superpixel,
    /// The step after the cut, which moves borders by the colours on both sides (or, after a correction, leaves them).
    Border,
    /// A stroke of the user's.
    Stroke,
}

/// What speaks for an object, or against one where negative.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Evidence {
    /// What the background says.
    pub background: f32,
    /// What objects and the ground near them look like.
    pub looks: f32,
}

/// What a cluster would cost the superpixel, all else as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LabelCost {
    /// The cluster.
    pub cluster: u32,
    /// Its label in the masks.
    pub label: u8,
    /// Its trajectories in the superpixel.
    pub votes: u32,
    /// The cost by its trajectories.
    pub trajectories: f64,
    /// The cost by colours, where no trajectory has a say.
    pub colours: f64,
    /// The cost by the background and the looks of objects.
    pub evidence: f64,
    /// The cost of links to superpixels of other clusters.
    pub links: f64,
    /// The cost where a stroke forbids it.
    pub forbidden: f64,
    /// The sum of all costs.
    pub total: f64,
}

/// A superpixel that shares a border, or is of the frame before or after.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SuperpixelLink {
    /// Its frame.
    pub t: usize,
    /// Its number in that frame.
    pub superpixel: u32,
    /// Its cluster.
    pub cluster: u32,
    /// Trajectories that both have.
    pub tracks: u32,
    /// The cost of having another cluster than that one.
    pub cost: f64,
}

/// A trajectory in the superpixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Voter {
    /// Column, in input pixels.
    pub x: f32,
    /// Row, in input pixels.
    pub y: f32,
    /// Its cluster; `None` where that is not known.
    #[serde(serialize_with = "or_less")]
    pub cluster: Option<u32>,
    /// Whether it moves like nothing around it, and counts for all objects.
    pub stranger: bool,
}

/// An affinity of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Affinity {
    /// The other trajectory.
    pub to: u32,
    /// How alike both move.
    pub affinity: f64,
}

/// The least change of a superpixel's label that changes its object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Flip {
    /// The cluster that is cheapest among those of other mask labels.
    pub cluster: u32,
    /// What it costs more.
    pub margin: f64,
    /// How many more trajectories of that cluster would make it as cheap; `None` where no number would.
    #[serde(serialize_with = "or_infinity")]
    pub votes: Option<u32>,
}

/// The Delaunay edges of a frame between the pixel's object and that of the [`Flip`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Border {
    /// Their number.
    pub edges: u32,
    /// Their mean discontinuity.
    pub mean: f64,
    /// One trajectory of the edge with the greatest discontinuity.
    pub i: u32,
    /// The other one.
    pub j: u32,
    /// That discontinuity.
    #[serde(serialize_with = "narrowed")]
    pub d: f64,
}

/// Why a pixel has its label; made by [`Session::explain`].
///
/// Costs are in units of the energy, in whole steps of 1/65536: sums and differences are exact.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// The pixel's mask label.
    pub label: u8,
    /// What gave it that. Where it is not [`Source::Superpixel`], costs are those of the superpixel all the same.
    pub source: Source,
    /// The superpixel that the pixel is in.
    pub superpixel: u32,
    /// The cluster that the cut gave the superpixel.
    pub cluster: u32,
    /// How much its trajectories count, 0 where none has a say.
    pub weight: f32,
    /// What speaks for an object.
    pub evidence: Evidence,
    /// What each cluster would cost.
    pub costs: Vec<LabelCost>,
    /// What binds the superpixel to others.
    pub links: Vec<SuperpixelLink>,
    /// The trajectories in it.
    pub voters: Vec<Voter>,
    /// The clustered trajectory nearest to the pixel; `None` where none is alive.
    #[serde(serialize_with = "or_less")]
    pub nearest: Option<u32>,
    /// Its greatest affinities.
    pub affinities: Vec<Affinity>,
    /// `None` where there is no other object, nor a background.
    pub flip: Option<Flip>,
    /// `None` where no edge joins the two.
    pub border: Option<Border>,
}

/// JavaScript has -1 for what is not there,
fn or_less<S: Serializer>(number: &Option<u32>, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_i64(number.map_or(-1, i64::from))
}

/// Infinity for what no number reaches,
fn or_infinity<S: Serializer>(number: &Option<u32>, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f64(number.map_or(f64::INFINITY, f64::from))
}

/// and discontinuities in single precision.
fn narrowed<S: Serializer>(d: &f64, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f32(*d as f32)
}

/// Steps of the solver in units of cost.
fn units(steps: i64) -> f64 {
    steps as f64 / f64::from(STEPS_PER_UNIT)
}

impl Session {
    /// Why the pixel `x`, `y` of frame `t` has its label; in input pixels, computed anew at each call.
    ///
    /// Law: for any two clusters, the difference of [`LabelCost::total`] is that of the cut's energies with the pixel's
    /// superpixel in the one and the other, all else as it is.
    ///
    /// # Errors
    /// [`Error::State`] unless the session is done and has masks, or when there is no such frame; [`Error::Param`] when
    /// the pixel is not in the frame.
    pub fn explain(&self, t: usize, x: usize, y: usize) -> Result<Explanation, Error> {
        let (Some(clip), Some(outputs)) = (self.clip(), self.after(Stage::Masks)) else {
            return Err(missing_frame("explanation", t, 0));
        };
        if t >= outputs.masks.len() {
            return Err(missing_frame("explanation", t, outputs.masks.len()));
        }
        for (name, value, side) in [("x", x, clip.scale.input.0), ("y", y, clip.scale.input.1)] {
            if value >= side {
                let expected = format!("a whole number in 0..{side}");
                return Err(Error::Param { name: name.to_owned(), value: value.to_string(), expected });
            }
        }
        Ok(Asked { clip, outputs, t, pixel: clip.scale.working_pixel(x, y) }.explanation((x, y)))
    }
}

/// A pixel that is asked about, at working size.
struct Asked<'a> {
    clip: &'a Clip,
    outputs: &'a Outputs,
    t: usize,
    pixel: (usize, usize),
}

impl Asked<'_> {
    fn explanation(&self, at: (usize, usize)) -> Explanation {
        let Outputs { superpixels, cut, masks, .. } = self.outputs;
        let (ground, params) = (&*cut.ground, &self.clip.params.cut);
        let input = self.outputs.cut_input();
        let superpixel = superpixels[self.t].label()[self.pixel];
        let mut reasons = SuperpixelTerms::new(&input, params, &cut.labels, self.t, superpixel);
        let held = ground.region.iter().flat_map(|region| &region.held);
        held.filter(|held| (held.0, held.1) == (self.t, superpixel)).for_each(|held| reasons.restrict(&held.2));
        let node = superpixels[..self.t].iter().map(|s| s.count).sum::<usize>() + superpixel as usize;
        let said = |by: &[f32]| by.get(node).copied().unwrap_or(0.0);
        let runner_up =
            reasons.runner_up(|cluster| self.outputs.label_of(cluster) != self.outputs.label_of(reasons.label));
        let (label, nearest) = (masks[self.t][self.pixel], self.nearest(at));
        let cost = |cluster| self.cost(&reasons, cluster);
        let link = |link: &Link| {
            let &Link { t, superpixel, label, cost, tracks } = link;
            SuperpixelLink { t, superpixel, cluster: label, tracks, cost: units(cost.into()) }
        };
        Explanation {
            label,
            source: self.source(label, reasons.label),
            superpixel,
            cluster: reasons.label,
            weight: reasons.lambda,
            evidence: Evidence { background: said(&ground.cues), looks: said(&ground.evidence) - said(&ground.cues) },
            costs: (0..reasons.unary.len() as u32).map(cost).collect(),
            links: reasons.links.iter().map(link).collect(),
            voters: self.voters(&input, &reasons),
            nearest,
            affinities: nearest.map_or_else(Vec::new, |i| self.affinities(i)),
            flip: runner_up.map(|(cluster, margin)| {
                let votes = reasons.votes_to_flip(cluster, params);
                Flip { cluster, margin: units(margin), votes }
            }),
            border: runner_up.and_then(|(cluster, _)| self.border(reasons.label, cluster)),
        }
    }

    fn cost(&self, reasons: &SuperpixelTerms, cluster: u32) -> LabelCost {
        let own = reasons.unary[cluster as usize];
        let [trajectories, colours, evidence, forbidden] =
            [own.trajectories, own.colours, own.evidence, own.forbidden].map(|steps| units(steps.into()));
        let total = units(reasons.cost(cluster));
        LabelCost {
            cluster,
            label: self.outputs.label_of(cluster),
            votes: reasons.votes[cluster as usize],
            trajectories,
            colours,
            evidence,
            links: total - trajectories - colours - evidence - forbidden,
            forbidden,
            total,
        }
    }

    fn source(&self, label: u8, cluster: u32) -> Source {
        let pixel = (self.pixel.1 * self.clip.scale.working.0 + self.pixel.0) as u32;
        let held = &self.outputs.corrections.held;
        if held.iter().any(|held| held.t == self.t && held.pixels.binary_search(&pixel).is_ok()) {
            return Source::Stroke;
        }
        if label == self.outputs.label_of(cluster) { Source::Superpixel } else { Source::Border }
    }

    fn voters(&self, input: &CutInput, reasons: &SuperpixelTerms) -> Vec<Voter> {
        let (sx, sy) = (self.clip.scale.x(), self.clip.scale.y());
        let to_input = |v: f32, s: f64| ((f64::from(v) + 0.5) * s - 0.5) as f32;
        let voter = |&i: &u32| {
            let ((x, y), cluster) = (input.tracks.at(i as usize, self.t).unwrap_or_default(), input.label[i as usize]);
            let known = (cluster as usize) < reasons.unary.len();
            Voter {
                x: to_input(x, sx),
                y: to_input(y, sy),
                cluster: known.then_some(cluster),
                stranger: cluster == OUTLIER,
            }
        };
        reasons.voters.iter().map(voter).collect()
    }

    /// The clustered trajectory nearest to the pixel in input pixels, the first of equals.
    fn nearest(&self, at: (usize, usize)) -> Option<u32> {
        let away = |x: f32, y: f32| {
            let (dx, dy) = (f64::from(x) - at.0 as f64, f64::from(y) - at.1 as f64);
            dx * dx + dy * dy
        };
        let tracks = &self.outputs.tracked.input;
        let near = tracks.alive(self.t).map(|(i, x, y)| (i as u32, away(x, y)));
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// The greatest affinities of trajectory `i`, the first of equals first.
    fn affinities(&self, i: u32) -> Vec<Affinity> {
        let row = self.outputs.affinities.row(i as usize);
        let mut greatest: Vec<Affinity> = Vec::new();
        for (j, affinity) in row.filter(|&(j, _)| j != i as usize) {
            let place = greatest.partition_point(|known| known.affinity >= affinity);
            greatest.insert(place, Affinity { to: j as u32, affinity });
            greatest.truncate(MOST_AFFINITIES);
        }
        greatest
    }

    /// The edges of this frame between the objects of two clusters.
    fn border(&self, own: u32, other: u32) -> Option<Border> {
        let Outputs { clusters, discontinuities: edges, .. } = self.outputs;
        let [own, other] = [own, other].map(|cluster| self.outputs.label_of(cluster));
        let label = |i: u32| self.outputs.label_of(clusters.label[i as usize]);
        let mut border = Border { edges: 0, mean: 0.0, i: 0, j: 0, d: -1.0 };
        for &edge in edges.neighborhoods.frame(self.t) {
            let ((i, j), d) = (edges.neighborhoods.pairs[edge as usize], edges.d[edge as usize]);
            if [(own, other), (other, own)].contains(&(label(i), label(j))) {
                border.edges += 1;
                border.mean += d;
                border = if d > border.d { Border { i, j, d, ..border } } else { border };
            }
        }
        border.mean /= f64::from(border.edges);
        (border.edges > 0).then_some(border)
    }
}
