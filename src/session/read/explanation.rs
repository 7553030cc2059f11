//! Explanations of labels: the terms of the cut for one pixel, computed again from the outputs, and their origin.

use super::results::missing_frame;
use crate::Error;
use crate::cut::{CutInput, Link, STEPS_PER_UNIT, SuperpixelTerms};
use crate::session::base::{Outputs, Stage};
use crate::session::run::{Clip, Session};
use serde::{Serialize, Serializer};

/// Number of a trajectory's affinities in an explanation, the largest ones; chosen by eye.
const MAX_AFFINITIES: usize = 8;

/// The origin of a pixel's label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum LabelSource {
    /// The cut of its superpixel.
    Superpixel,
    /// The refinement of borders by colour after the cut.
    Border,
    /// A stroke of the user.
    Stroke,
}

/// Evidence for an object, or against one if negative.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Evidence {
    /// Evidence of the background model.
    pub background: f32,
    /// Evidence of the appearance models of objects and their surroundings.
    pub looks: f32,
}

/// The cost of giving the superpixel to a cluster, with all other labels fixed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LabelCost {
    /// The cluster.
    pub cluster: u32,
    /// Its label in the masks.
    pub label: u8,
    /// Number of its trajectories in the superpixel.
    pub votes: u32,
    /// Unary cost of trajectories.
    pub trajectories: f64,
    /// Unary cost of background and appearance evidence.
    pub evidence: f64,
    /// Pairwise costs of links to superpixels of other clusters.
    pub links: f64,
    /// Cost of a label that a stroke forbids.
    pub forbidden: f64,
    /// The sum of all costs.
    pub total: f64,
}

/// A link to a superpixel beside it, or in the previous or the next frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SuperpixelLink {
    /// Its frame.
    pub t: usize,
    /// Its number in that frame.
    pub superpixel: u32,
    /// Its cluster.
    pub cluster: u32,
    /// Number of trajectories in both.
    pub tracks: u32,
    /// The cost of differing from its cluster.
    pub cost: f64,
}

/// A trajectory in the superpixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Voter {
    /// Column, in input pixels.
    pub x: f32,
    /// Row, in input pixels.
    pub y: f32,
    /// Its cluster; `None` if it is unknown.
    #[serde(serialize_with = "or_minus_one")]
    pub cluster: Option<u32>,
}

/// An affinity of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Affinity {
    /// The other trajectory.
    pub to: u32,
    /// The affinity of both.
    pub affinity: f64,
}

/// The cheapest change of a superpixel's cluster that changes its mask label.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LabelFlip {
    /// The cheapest cluster of another mask label.
    pub cluster: u32,
    /// Its extra cost.
    pub margin: f64,
    /// Number of additional trajectories of that cluster that would make it as cheap; `None` if no number would.
    #[serde(serialize_with = "or_infinity")]
    pub votes: Option<u32>,
}

/// The Delaunay edges of a frame between the pixel's object and the object of the [`LabelFlip`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ObjectBorder {
    /// Number of edges.
    pub edges: u32,
    /// Mean discontinuity of the edges.
    pub mean: f64,
    /// One trajectory of the edge with the largest discontinuity.
    pub i: u32,
    /// The other trajectory of that edge.
    pub j: u32,
    /// The largest discontinuity.
    #[serde(serialize_with = "narrowed")]
    pub d: f64,
}

/// The explanation of a pixel's label; see [`Session::explain`].
///
/// Costs are in units of the energy, in multiples of 1/65536, so that sums and differences are exact.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Explanation {
    /// The pixel's mask label.
    pub label: u8,
    /// The origin of the label. Costs always belong to the superpixel.
    pub source: LabelSource,
    /// The superpixel of the pixel.
    pub superpixel: u32,
    /// The cluster that the cut gave the superpixel.
    pub cluster: u32,
    /// The weight of its trajectories, 0 if there are none.
    pub weight: f32,
    /// Evidence for an object.
    pub evidence: Evidence,
    /// The cost of each cluster.
    pub costs: Vec<LabelCost>,
    /// The pairwise terms of the superpixel.
    pub links: Vec<SuperpixelLink>,
    /// The trajectories in the superpixel.
    pub voters: Vec<Voter>,
    /// The nearest clustered trajectory; `None` if none is alive.
    #[serde(serialize_with = "or_minus_one")]
    pub nearest: Option<u32>,
    /// The largest affinities of that trajectory.
    pub affinities: Vec<Affinity>,
    /// `None` if there is no other mask label.
    pub flip: Option<LabelFlip>,
    /// `None` if no edge joins the two.
    pub border: Option<ObjectBorder>,
}

/// Serializes a missing number as -1, for JavaScript.
fn or_minus_one<S: Serializer>(number: &Option<u32>, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_i64(number.map_or(-1, i64::from))
}

/// Serializes a missing number of votes as infinity, for JavaScript.
fn or_infinity<S: Serializer>(number: &Option<u32>, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f64(number.map_or(f64::INFINITY, f64::from))
}

/// Serializes a discontinuity in single precision, for JavaScript.
fn narrowed<S: Serializer>(d: &f64, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f32(*d as f32)
}

/// Converts the solver's integer costs to units of cost.
fn units(steps: i64) -> f64 {
    steps as f64 / f64::from(STEPS_PER_UNIT)
}

impl Session {
    /// Explains the label of the input pixel `x`, `y` of frame `t`.
    ///
    /// Invariant: for any two clusters, the difference of [`LabelCost::total`] is the difference of the cut's energies with the
    /// pixel's superpixel in either, with all other labels fixed.
    ///
    /// # Errors
    /// [`Error::State`] unless the session is done and has masks, or if there is no such frame; [`Error::Param`] if the pixel
    /// is not in the frame.
    pub fn explain(&self, t: usize, (x, y): (usize, usize)) -> Result<Explanation, Error> {
        let (Some(clip), Some(outputs)) = (self.clip(), self.outputs_after(Stage::Masks)) else {
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
        Ok(PixelQuery { clip, outputs, t, pixel: clip.scale.working_pixel(x, y) }.explanation(x, y))
    }
}

/// A pixel to be explained, at working size.
struct PixelQuery<'a> {
    clip: &'a Clip,
    outputs: &'a Outputs,
    t: usize,
    pixel: (usize, usize),
}

impl PixelQuery<'_> {
    fn explanation(&self, x: usize, y: usize) -> Explanation {
        let Outputs { superpixels, cut, masks, .. } = self.outputs;
        let (context, params) = (&*cut.context, &self.clip.params.cut);
        let input = self.outputs.cut_input();
        let superpixel = superpixels[self.t].label()[self.pixel];
        let mut terms = SuperpixelTerms::new(&input, params, &cut.labels, self.t, superpixel);
        let allowed = context.region.iter().flat_map(|region| &region.allowed);
        allowed.filter(|entry| (entry.0, entry.1) == (self.t, superpixel)).for_each(|entry| terms.restrict(&entry.2));
        let node = superpixels[..self.t].iter().map(|s| s.count).sum::<usize>() + superpixel as usize;
        let at_node = |values: &[f32]| values.get(node).copied().unwrap_or(0.0);
        let runner_up =
            terms.runner_up(|cluster| self.outputs.mask_label(cluster) != self.outputs.mask_label(terms.label));
        let (label, nearest) = (masks[self.t][self.pixel], self.nearest(x, y));
        let cost = |cluster| self.cost(&terms, cluster);
        let link = |link: &Link| {
            let &Link { t, superpixel, label, cost, tracks } = link;
            SuperpixelLink { t, superpixel, cluster: label, tracks, cost: units(cost.into()) }
        };
        Explanation {
            label,
            source: self.source(label, terms.label),
            superpixel,
            cluster: terms.label,
            weight: terms.lambda,
            evidence: Evidence {
                background: at_node(&context.evidence),
                looks: params.appearance_weight * at_node(&context.appearance),
            },
            costs: (0..terms.unary.len() as u32).map(cost).collect(),
            links: terms.links.iter().map(link).collect(),
            voters: self.voters(&input, &terms),
            nearest,
            affinities: nearest.map_or_else(Vec::new, |i| self.affinities(i)),
            flip: runner_up.map(|(cluster, margin)| {
                let votes = terms.votes_to_flip(cluster);
                LabelFlip { cluster, margin: units(margin), votes }
            }),
            border: runner_up.and_then(|(cluster, _)| self.border(terms.label, cluster)),
        }
    }

    fn cost(&self, terms: &SuperpixelTerms, cluster: u32) -> LabelCost {
        let unary = terms.unary[cluster as usize];
        let [trajectories, evidence, forbidden] =
            [unary.trajectories, unary.evidence, unary.forbidden].map(|steps| units(steps.into()));
        let total = units(terms.cost(cluster));
        LabelCost {
            cluster,
            label: self.outputs.mask_label(cluster),
            votes: terms.votes[cluster as usize],
            trajectories,
            evidence,
            links: total - trajectories - evidence - forbidden,
            forbidden,
            total,
        }
    }

    fn source(&self, label: u8, cluster: u32) -> LabelSource {
        let pixel = (self.pixel.1 * self.clip.scale.working.0 + self.pixel.0) as u32;
        let constraints = &self.outputs.corrections.constraints;
        if constraints.iter().any(|stroke| stroke.t == self.t && stroke.pixels.binary_search(&pixel).is_ok()) {
            return LabelSource::Stroke;
        }
        if label == self.outputs.mask_label(cluster) { LabelSource::Superpixel } else { LabelSource::Border }
    }

    fn voters(&self, input: &CutInput, terms: &SuperpixelTerms) -> Vec<Voter> {
        let (sx, sy) = (self.clip.scale.x(), self.clip.scale.y());
        let to_input = |v: f32, s: f64| ((f64::from(v) + 0.5) * s - 0.5) as f32;
        let voter = |&i: &u32| {
            let ((x, y), cluster) = (input.tracks.at(i as usize, self.t).unwrap_or_default(), input.label[i as usize]);
            let is_clustered = (cluster as usize) < terms.unary.len();
            Voter { x: to_input(x, sx), y: to_input(y, sy), cluster: is_clustered.then_some(cluster) }
        };
        terms.voters.iter().map(voter).collect()
    }

    /// Returns the clustered trajectory nearest to an input pixel, the first of equally near ones.
    fn nearest(&self, x: usize, y: usize) -> Option<u32> {
        let distance_sq = |track_x: f32, track_y: f32| {
            let (dx, dy) = (f64::from(track_x) - x as f64, f64::from(track_y) - y as f64);
            dx * dx + dy * dy
        };
        let tracks = &self.outputs.track_set.input;
        let distances = tracks.alive(self.t).map(|(i, track_x, track_y)| (i as u32, distance_sq(track_x, track_y)));
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// Returns the largest affinities of trajectory `i`, the first of equal ones first.
    fn affinities(&self, i: u32) -> Vec<Affinity> {
        let row = self.outputs.affinities.row(i as usize);
        let mut largest: Vec<Affinity> = Vec::new();
        for (j, affinity) in row.filter(|&(j, _)| j != i as usize) {
            let rank = largest.partition_point(|entry| entry.affinity >= affinity);
            largest.insert(rank, Affinity { to: j as u32, affinity });
            largest.truncate(MAX_AFFINITIES);
        }
        largest
    }

    /// Summarizes the edges of this frame between the objects of two clusters.
    fn border(&self, cluster: u32, neighbour: u32) -> Option<ObjectBorder> {
        let Outputs { clusters, discontinuities: edges, .. } = self.outputs;
        let [inner, outer] = [cluster, neighbour].map(|cluster| self.outputs.mask_label(cluster));
        let label = |i: u32| self.outputs.mask_label(clusters.label[i as usize]);
        let mut border = ObjectBorder { edges: 0, mean: 0.0, i: 0, j: 0, d: -1.0 };
        for &edge in edges.neighborhoods.frame(self.t) {
            let ((i, j), d) = (edges.neighborhoods.pairs[edge as usize], edges.d[edge as usize]);
            if [(inner, outer), (outer, inner)].contains(&(label(i), label(j))) {
                border.edges += 1;
                border.mean += d;
                border = if d > border.d { ObjectBorder { i, j, d, ..border } } else { border };
            }
        }
        border.mean /= f64::from(border.edges);
        (border.edges > 0).then_some(border)
    }
}

#[cfg(test)]
mod tests {
    use super::LabelSource;
    use crate::correction::{Correction, Stroke};
    use crate::cut::{GabrielCut, STEPS_PER_UNIT};
    use crate::rng::Rng;
    use crate::session::run::{Phase, Session, State};
    use crate::synth::Scene;
    use crate::{Error, Params, Step};

    const SIZE: (usize, usize) = (200, 112);
    const FRAMES: usize = 8;

    fn pushed(seed: u64) -> Session {
        let scene = Scene::sample((SIZE.0, SIZE.1), FRAMES, seed);
        let mut session = Session::new(Params::default()).unwrap();
        for t in 0..FRAMES {
            session.push_frame(scene.frame(t)).unwrap();
        }
        session
    }

    /// Runs the session to its end; the solver of the last cut as it ended.
    fn run_and_watch(session: &mut Session) -> GabrielCut {
        let mut solver = None;
        loop {
            if let Phase::Running(run) = &session.phase
                && let State::Cut(work) = &run.state
                && let Some(moves) = work.moves()
            {
                solver = Some(moves.clone());
            }
            if session.step().unwrap() == Step::Done {
                break;
            }
        }
        // The last move is made in the same step as what follows it.
        let mut solver = solver.unwrap();
        while solver.step() {}
        solver
    }

    /// Number of a superpixel among all.
    fn node(session: &Session, t: usize, superpixel: u32) -> u32 {
        (0..t).map(|t| session.superpixels(t).unwrap().count as u32).sum::<u32>() + superpixel
    }

    /// Asks about random pixels and compares with the solver. Returns how many superpixels it could compare.
    fn agrees(session: &Session, solver: &GabrielCut, pixels: usize, seed: u64) -> usize {
        let mut rng = Rng::for_stage(seed, "why");
        let mut compared = 0;
        for _ in 0..pixels {
            let (t, x, y) = (rng.below(FRAMES), rng.below(SIZE.0), rng.below(SIZE.1));
            let why = session.explain(t, (x, y)).unwrap();
            let own = why.cluster;
            let node = node(session, t, why.superpixel);
            let Some(present) = solver.energy_if(node, own) else { continue };
            for (label, cost) in (0..).zip(&why.costs) {
                if let Some(energy) = solver.energy_if(node, label) {
                    let shown = cost.total - why.costs[own as usize].total;
                    let steps = (energy - present) as f64 / f64::from(STEPS_PER_UNIT);
                    assert_eq!(shown, steps, "frame {t}, pixel {x}, {y}, label {label}");
                    assert!(shown >= 0.0, "a single superpixel would gain by another label");
                    compared += usize::from(label != own);
                }
            }
        }
        compared
    }

    #[test]
    fn the_terms_shown_are_the_energies_that_the_solver_sees() {
        for seed in [2, 5] {
            let mut session = pushed(seed);
            let solver = run_and_watch(&mut session);
            assert!(agrees(&session, &solver, 500, seed) >= 500);
        }
    }

    #[test]
    fn after_strokes_the_terms_are_those_of_the_cut_made_anew() {
        let mut session = pushed(2);
        session.run().unwrap();
        let mask = session.labels(3).unwrap();
        let of_object: Vec<_> =
            (0..SIZE.0 * SIZE.1).map(|p| (p % SIZE.0, p / SIZE.0)).filter(|&at| mask[at] == 1).collect();
        let [(x0, y0), (x1, y1)] = [of_object[0], of_object[of_object.len() - 1]];
        let stroke = |x: usize, y: usize| {
            let (x, y) = (x as f32, y as f32);
            Stroke { t: 3, points: vec![(x, y), (x + 1.0, y + 1.0)], radius: 4.0 }
        };
        // Three things, since two would be parted in a single move, before anybody could look.
        let strokes = vec![stroke(x0, y0 + 4), stroke(x1, y1 - 4), stroke(2, 2)];
        session.correct(&Correction::SplitStrokes(strokes)).unwrap();
        let solver = run_and_watch(&mut session);
        assert!(agrees(&session, &solver, 150, 7) > 50);
        let why = session.explain(3, (2, 2)).unwrap();
        assert_eq!(why.source, LabelSource::Stroke);
        assert!(why.costs.iter().any(|cost| cost.forbidden > 0.0), "{:?}", why.costs);
        session.undo_correction().unwrap();
        let before = session.explain(3, (2, 2)).unwrap();
        assert!(before.source != LabelSource::Stroke && before.costs.iter().all(|cost| cost.forbidden == 0.0));
    }

    #[test]
    fn what_is_behind_the_terms_agrees_with_the_other_results() {
        let mut session = pushed(2);
        session.run().unwrap();
        let (clusters, mut borders) = (session.clusters().unwrap(), 0);
        let mut rng = Rng::for_stage(3, "why");
        for _ in 0..60 {
            let (t, x, y) = (rng.below(FRAMES), rng.below(SIZE.0), rng.below(SIZE.1));
            let why = session.explain(t, (x, y)).unwrap();
            assert_eq!(why.label, session.labels(t).unwrap()[(x, y)]);
            assert_eq!(why.superpixel, session.superpixels(t).unwrap().label()[(x, y)]);
            let of_cluster = &session.objects().unwrap().of_cluster;
            assert_eq!(why.costs.iter().map(|cost| cost.label).collect::<Vec<_>>(), *of_cluster);
            let by_cut = of_cluster[why.cluster as usize];
            assert_eq!(why.source == LabelSource::Superpixel, why.label == by_cut);
            borders += usize::from(why.source == LabelSource::Border);
            let of_own = why.voters.iter().filter(|v| v.cluster == Some(why.cluster)).count();
            assert_eq!(of_own, why.costs[why.cluster as usize].votes as usize);
            assert_ne!(of_cluster[why.flip.unwrap().cluster as usize], by_cut);
            let nearest = why.nearest.unwrap() as usize;
            let a = session.affinities().unwrap();
            let most = a.row(nearest).filter(|&(j, _)| j != nearest).map(|(_, v)| v).fold(0.0, f64::max);
            assert_eq!(why.affinities[0].affinity, most);
            if let Some(border) = why.border {
                let ends = [border.i, border.j].map(|i| of_cluster[clusters.label[i as usize] as usize]);
                assert!(ends[0] != ends[1] && ends.contains(&by_cut), "{ends:?}");
                assert!(border.mean <= border.d && border.d <= 1.0);
            }
        }
        assert!(borders > 0, "no pixel was moved by the border's step: choose other ones");
    }

    #[test]
    fn the_votes_that_flip_do_flip_and_one_less_does_not() {
        use crate::cut::{SuperpixelTerms, UnaryCost};
        let unit = STEPS_PER_UNIT;
        // Six trajectories of label 0 and two of label 1, and half a unit of evidence against label 1.
        let own = |trajectories, evidence| UnaryCost { trajectories, evidence, ..UnaryCost::default() };
        let reasons = SuperpixelTerms {
            label: 0,
            lambda: 1.0,
            unary_weight: 1.0,
            votes: vec![6, 2],
            voters: Vec::new(),
            unary: vec![own(unit / 4, 0), own(unit / 4 * 3, unit / 2)],
            links: Vec::new(),
        };
        let needed = reasons.votes_to_flip(1).unwrap();
        // (6 − 2 − n) / (8 + n) + 1/2 is 0 at n = 16.
        assert_eq!(needed, 16);
        let strong = SuperpixelTerms { unary: vec![own(unit / 4, 0), own(unit / 4 * 3, 2 * unit)], ..reasons };
        assert_eq!(strong.votes_to_flip(1), None);
    }

    #[test]
    fn what_is_not_there_is_refused_by_name() {
        let mut session = pushed(2);
        assert!(matches!(session.explain(0, (0, 0)), Err(Error::State { .. })));
        session.run().unwrap();
        for (t, x, y, named) in [(FRAMES, 0, 0, "0..8"), (0, SIZE.0, 0, "0..200"), (0, 0, 4000, "4000")] {
            let message = session.explain(t, (x, y)).unwrap_err().to_string();
            assert!(message.contains(named), "{message}");
        }
    }
}
