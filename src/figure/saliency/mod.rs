//! Context-aware saliency of trajectories (section 3): contrast of their motion to the surroundings.
//!
//! In: the flow of each frame, trajectories, their embedding. Out: a saliency in `0.0..=1.0` for each pixel and each
//! trajectory, and the foreground.
//!
//! 1. The *dominant motion* of each frame, which is the camera's, is subtracted from its flow (`camera::dominant`).
//! 2. The magnitudes of the residual fall into bins, over the range of the whole clip (`maps`).
//! 3. A pixel's saliency is the probability of its bin inside a window, against the ring around it (`centre_surround`).
//! 4. A trajectory's saliency `s` is the greatest of its points'. Its context-aware saliency `s̄` is the mean of `s` over
//!    the trajectories near it in the embedding; above a threshold it is foreground (`context`).
//!
//! **Deviations from the paper**, all of which [`Params::paper`](crate::Params::paper) reverts but the sign of step 4: the paper
//! bins the magnitude of the raw flow over a fixed range. docs/choices.md lists these choices.
//!
//! Cost: O(windows · bins) for each frame, and O(n² K) for n trajectories. It fails where the scene is neither far away nor
//! flat: what is close to a moving camera is as salient as objects, such as trees before a running dog. Static objects are
//! not salient. Steps 1 to 3 give the same bits on every target.

mod centre_surround;
mod context;
mod maps;

pub use context::{Saliency, context_saliency, trajectory_saliency};
pub(crate) use context::{greatest_of_points, point_pixels};
pub use maps::SaliencyMaps;
pub(crate) use maps::SaliencyQuery;

crate::choices! {
    /// Model of the camera's motion that is subtracted from the flow.
    pub enum Compensation {
        /// None: the magnitude of the raw flow, as in the paper.
        Off = "off",
        /// The dominant affine motion of each frame.
        Affine = "affine",
        /// The dominant homography of each frame.
        Homography = "homography",
    }
}

crate::choices! {
    /// Density that the affinity of two trajectories is compared with.
    pub enum Neighborhood {
        /// The greater of both, as in discontinuities.
        Max = "max",
        /// The smaller of both, as the paper prints it.
        Min = "min",
    }
}

crate::params! {
    /// Saliency, and the foreground that follows from it.
    pub struct SaliencyParams {
        /// Model of the camera's motion that is subtracted from the flow (the paper: off).
        pub compensation: Compensation = Compensation::Homography, in 0..=2, expert;
        /// Residual at which a point of the flow counts half in the fit of the dominant motion, in pixels a frame.
        pub tolerance: f64 = 0.5, in 0.01..=100.0, expert;
        /// Bins of the magnitude (Rahtu et al.: 15). Higher is slower.
        pub bins: u32 = 15, in 2..=32, expert;
        /// Magnitude at which the last bin ends, in pixels a frame (Rahtu et al.: 15); 0 takes it from the clip.
        pub range: f64 = 0.0, in 0.0..=250.0, expert;
        /// Prior probability that a pixel of a window is salient (Rahtu et al.: 0.2).
        pub prior: f32 = 0.2, in 0.001..=0.999, expert;
        /// ℓ: trajectories are near in the embedding if their embedding affinity is above this part of their density
        /// (section 3; the value is not given there). Higher averages over fewer.
        pub neighborhood: f64 = 0.4, in 0.0..=1.0, expert;
        /// Density of two trajectories: the greater or the smaller (the paper: min).
        pub form: Neighborhood = Neighborhood::Max, in 0..=1, expert;
        /// Trajectories of a context-aware saliency above this are foreground (section 3: 0.5).
        pub threshold: f64 = 0.5, in 0.0..=1.0;
    }
}

impl SaliencyParams {
    /// The paper's: magnitude of the raw flow, and the printed neighbourhood with its sign reversed.
    pub(crate) fn paper() -> Self {
        Self { compensation: Compensation::Off, neighborhood: 0.7, form: Neighborhood::Min, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affinity::{AffinityParams, AffinityRows};
    use crate::discontinuity::{Discontinuities, DiscontinuityParams, Neighborhoods, discontinuities, neighborhoods};
    use crate::embedding::{Embedding, EmbeddingParams, embed};
    use crate::flow::FlowField;
    use crate::image::Plane;
    use crate::rng::Rng;
    use crate::trajectory::Trajectories;

    const SIZE: (usize, usize) = (96, 72);
    const FRAMES: usize = 12;

    fn flow_of(size: (usize, usize), motion: impl Fn(f64, f64) -> (f64, f64)) -> FlowField {
        let at = |x: usize, y: usize| motion(x as f64, y as f64);
        FlowField {
            u: Plane::from_fn(size.0, size.1, |x, y| at(x, y).0 as f32),
            v: Plane::from_fn(size.0, size.1, |x, y| at(x, y).1 as f32),
        }
    }

    /// A clip of a scene and one square: their motion at frame `t`, in pixels.
    struct SquareClip {
        ground: fn(usize) -> (f64, f64),
        square: fn(usize) -> (f64, f64),
        noise: f64,
        side: f64,
    }

    /// Saliency of each trajectory, and the ones on the square.
    struct Outcome {
        saliency: Saliency,
        on_square: Vec<bool>,
    }

    impl SquareClip {
        /// Corner of the square at frame `t`.
        fn corner(&self, t: usize) -> (f64, f64) {
            (0..t).map(self.square).fold((24.0, 24.0), |(x, y), (u, v)| (x + u, y + v))
        }

        fn covers(&self, t: usize, x: f64, y: f64) -> bool {
            let (left, top) = self.corner(t);
            (left..left + self.side).contains(&x) && (top..top + self.side).contains(&y)
        }

        fn flow(&self, t: usize) -> FlowField {
            let rng = std::cell::RefCell::new(Rng::for_stage(t as u64, "test"));
            flow_of(SIZE, |x, y| {
                let (u, v) = if self.covers(t, x, y) { (self.square)(t) } else { (self.ground)(t) };
                let noise = || rng.borrow_mut().range(-self.noise, self.noise);
                (u + noise(), v + noise())
            })
        }

        /// Trajectories from a grid in the first frame, moved by the true motion until they leave the frame or are covered.
        fn tracks(&self) -> (Trajectories, Vec<bool>) {
            let mut tracks = Trajectories::empty(FRAMES, SIZE);
            let mut on_square = Vec::new();
            for k in 0..(SIZE.0 / 4) * (SIZE.1 / 4) {
                let (mut x, mut y) = ((4 * (k % (SIZE.0 / 4)) + 2) as f64, (4 * (k / (SIZE.0 / 4)) + 2) as f64);
                let on = self.covers(0, x, y);
                let mut points = Vec::new();
                for t in 0..FRAMES {
                    let inside = x >= 0.0 && y >= 0.0 && x < SIZE.0 as f64 && y < SIZE.1 as f64;
                    if !inside || (!on && self.covers(t, x, y)) {
                        break;
                    }
                    points.push((x as f32, y as f32, 0.0));
                    let (u, v) = if on { (self.square)(t) } else { (self.ground)(t) };
                    (x, y) = (x + u, y + v);
                }
                if points.len() > 3 {
                    tracks.push(0, points);
                    on_square.push(on);
                }
            }
            (tracks, on_square)
        }

        fn run(&self, params: &SaliencyParams) -> Outcome {
            let (tracks, on_square) = self.tracks();
            let mut rows = AffinityRows::new(&tracks, 4.0, &AffinityParams::default(), 0);
            while rows.advance(&tracks, 512) {}
            let embedding = embed(&rows.finish().unwrap(), &EmbeddingParams::default(), 0);
            let d = discontinuities(neighborhoods(&tracks), &embedding, &DiscontinuityParams::default());
            let mut maps = SaliencyMaps::new(params);
            (0..FRAMES - 1).for_each(|t| maps.add_flow(&self.flow(t)));
            let of_frames: Vec<_> = (0..FRAMES - 1).map(|t| maps.map(t, &self.flow(t))).collect();
            assert!(of_frames.iter().flat_map(Plane::data).all(|s| (0.0..=1.0).contains(s)));
            let own = trajectory_saliency(&tracks, &of_frames);
            Outcome { saliency: context_saliency(own, &embedding, &d, params), on_square }
        }
    }

    impl Outcome {
        /// Shares of the square's trajectories and of the others that are foreground.
        fn shares(&self) -> (f64, f64) {
            let share = |on: bool| {
                let tracks = self.saliency.foreground.iter().zip(&self.on_square).filter(|p| *p.1 == on);
                let foreground: Vec<bool> = tracks.map(|p| *p.0).collect();
                foreground.iter().filter(|&&f| f).count() as f64 / foreground.len() as f64
            };
            (share(true), share(false))
        }
    }

    fn both() -> [SaliencyParams; 2] {
        [SaliencyParams::default(), SaliencyParams::paper()]
    }

    #[test]
    fn nothing_is_salient_where_nothing_moves_or_only_noise() {
        for noise in [0.0, 0.09] {
            let clip = SquareClip { ground: |_| (0.0, 0.0), square: |_| (0.0, 0.0), noise, side: 26.0 };
            for params in both() {
                let saliency = clip.run(&params).saliency;
                assert!(!saliency.foreground.contains(&true), "noise {noise}: {:?}", saliency.in_context);
            }
        }
    }

    #[test]
    fn a_moving_square_is_foreground_and_still_ground_is_not() {
        for params in both() {
            let clip = SquareClip { ground: |_| (0.0, 0.0), square: |_| (2.5, 0.5), noise: 0.02, side: 26.0 };
            assert_eq!(clip.run(&params).shares(), (1.0, 0.0), "{params:?}");
        }
    }

    #[test]
    fn ground_around_a_large_object_is_no_foreground() {
        let clip = SquareClip { ground: |_| (1.0, 0.5), square: |_| (-2.0, 0.5), noise: 0.02, side: 52.0 };
        assert_eq!(clip.run(&SaliencyParams::default()).shares(), (1.0, 0.0));
    }

    #[test]
    fn an_object_that_stops_half_way_stays_foreground() {
        let clip = SquareClip {
            ground: |_| (0.0, 0.0),
            square: |t| if t < FRAMES / 2 { (3.0, 0.0) } else { (0.0, 0.0) },
            noise: 0.02,
            side: 26.0,
        };
        assert_eq!(clip.run(&SaliencyParams::default()).shares(), (1.0, 0.0));
    }

    #[test]
    fn a_pan_of_the_camera_changes_nothing() {
        let still = SquareClip { ground: |_| (0.0, 0.0), square: |_| (2.0, 1.0), noise: 0.02, side: 26.0 };
        let panned = SquareClip { ground: |_| (-3.0, 1.0), square: |_| (-1.0, 2.0), noise: 0.02, side: 26.0 };
        for compensation in [Compensation::Affine, Compensation::Homography] {
            let params = SaliencyParams { compensation, ..SaliencyParams::default() };
            assert_eq!(still.run(&params).shares(), (1.0, 0.0));
            assert_eq!(panned.run(&params).shares(), (1.0, 0.0));
        }
    }

    #[test]
    fn maps_are_the_same_under_a_pan_where_flow_is_exact() {
        let map = |pan: f64| {
            let flow =
                flow_of((64, 48), |x, y| if x < 20.0 && y > 10.0 && y < 30.0 { (4.0 + pan, 1.0) } else { (pan, 0.0) });
            let mut maps = SaliencyMaps::new(&SaliencyParams::default());
            maps.add_flow(&flow);
            maps.map(0, &flow)
        };
        let (still, panned) = (map(0.0), map(7.0));
        let furthest = still.data().iter().zip(panned.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(furthest < 1e-3, "{furthest}");
    }

    #[test]
    fn every_size_has_a_map_of_its_size_within_0_and_1() {
        for size in [(1, 1), (1, 9), (9, 1), (2, 3), (17, 5), (200, 3)] {
            for value in [0.0, 3.0, f64::NAN, f64::INFINITY] {
                for compensation in [Compensation::Off, Compensation::Affine, Compensation::Homography] {
                    let params = SaliencyParams { compensation, ..SaliencyParams::default() };
                    let flow = flow_of(size, |x, _| if x > 0.0 { (value, 0.0) } else { (0.0, 1.0) });
                    let mut maps = SaliencyMaps::new(&params);
                    maps.add_flow(&flow);
                    let map = maps.map(0, &flow);
                    assert_eq!((map.width(), map.height()), size);
                    assert!(map.data().iter().all(|s| (0.0..=1.0).contains(s)), "{size:?} {value} {:?}", map.data());
                }
            }
        }
    }

    #[test]
    fn maps_of_flows_that_were_not_added_use_the_raw_flow() {
        let flow = flow_of((40, 30), |x, _| if x < 12.0 { (3.0, 0.0) } else { (0.0, 0.0) });
        let maps = SaliencyMaps::new(&SaliencyParams::default());
        assert!(maps.map(5, &flow).data().iter().all(|s| (0.0..=1.0).contains(s)));
    }

    #[test]
    fn the_range_is_a_quantile_of_the_magnitudes_with_a_floor() {
        let off = SaliencyParams { compensation: Compensation::Off, ..SaliencyParams::default() };
        // A few pixels are far faster than all others.
        let range = |slope: f64, params: &SaliencyParams| {
            let mut maps = SaliencyMaps::new(params);
            maps.add_flow(&flow_of((100, 100), |x, y| (if x + y < 197.0 { slope * y } else { 100.0 }, 0.0)));
            maps.range()
        };
        assert!((range(0.1, &off) - 9.8).abs() < 0.15, "{}", range(0.1, &off));
        assert_eq!(range(0.01, &off), 2.0);
        assert_eq!(range(0.1, &SaliencyParams { range: 15.0, ..off }), 15.0);
    }

    /// Two blocks of three rows each, apart in the embedding, and one row that is not embedded.
    fn two_blocks() -> (Embedding, Discontinuities) {
        let block = |i: usize| if i < 3 { [1.0, 0.0] } else { [0.0, 1.0] };
        let mut vectors: Vec<f64> = (0..6).flat_map(block).collect();
        vectors.extend([0.0, 0.0]);
        let mut embedded = vec![true; 7];
        embedded[6] = false;
        let embedding = Embedding {
            num_rows: 7,
            dimensions: 2,
            eigenvalues: vec![1.0, 1.0],
            vectors,
            embedded,
            ..Embedding::default()
        };
        let mut density = vec![1.0; 7];
        density[6] = 0.0;
        let d = Discontinuities {
            neighborhoods: Neighborhoods::default(),
            dimensions: 2,
            density,
            ..Discontinuities::default()
        };
        (embedding, d)
    }

    #[test]
    fn context_is_the_mean_over_a_block_and_not_embedded_rows_keep_their_own() {
        let (embedding, d) = two_blocks();
        let own = vec![0.9, 0.6, 0.3, 0.0, 0.1, 0.8, 0.7];
        for form in [Neighborhood::Max, Neighborhood::Min] {
            let params = SaliencyParams { form, ..SaliencyParams::default() };
            let s = context_saliency(own.clone(), &embedding, &d, &params);
            for (i, &mean) in s.in_context.iter().enumerate() {
                let expected = [0.6, 0.3, 0.7][i / 3];
                assert!((mean - expected).abs() < 1e-6, "{i}: {mean}");
            }
            assert_eq!(s.foreground, [true, true, true, false, false, false, true]);
            assert_eq!(s.of_points, own);
        }
    }

    #[test]
    fn the_fast_context_is_the_mean_over_all_pairs() {
        let mut rng = Rng::for_stage(3, "test");
        let (n, dimensions) = (1500, 5);
        let vectors: Vec<f64> = (0..n * dimensions).map(|_| rng.range(-0.5, 1.0)).collect();
        let eigenvalues: Vec<f64> = (0..dimensions).map(|k| 1.0 - 0.05 * k as f64).collect();
        let embedding = Embedding {
            num_rows: n,
            dimensions,
            eigenvalues,
            vectors,
            embedded: vec![true; n],
            ..Embedding::default()
        };
        let density: Vec<f64> = (0..n).map(|_| rng.range(0.2, 4.0)).collect();
        let own: Vec<f32> = (0..n).map(|_| rng.uniform() as f32).collect();
        let d = Discontinuities { dimensions, density: density.clone(), ..Discontinuities::default() };
        for form in [Neighborhood::Max, Neighborhood::Min] {
            let params = SaliencyParams { form, ..SaliencyParams::default() };
            let fast = context_saliency(own.clone(), &embedding, &d, &params).in_context;
            for i in (0..n).step_by(97) {
                let is_near = |j: &usize| {
                    let (a, b) = (embedding.row(i), embedding.row(*j));
                    let w: f64 = (0..dimensions).map(|k| embedding.eigenvalues[k] * a[k] * b[k]).sum();
                    let (d, e) = (density[i], density[*j]);
                    w > params.neighborhood * if form == Neighborhood::Max { d.max(e) } else { d.min(e) }
                };
                let neighbourhood: Vec<usize> = (0..n).filter(is_near).collect();
                let mean = neighbourhood.iter().map(|&j| f64::from(own[j])).sum::<f64>() / neighbourhood.len() as f64;
                let expected = if neighbourhood.is_empty() { f64::from(own[i]) } else { mean };
                // A pair at the very bound may fall to either side of it.
                assert!((f64::from(fast[i]) - expected).abs() < 0.01, "{i}: {} not {expected}", fast[i]);
            }
        }
    }

    #[test]
    fn a_trajectory_is_as_salient_as_its_most_salient_known_point() {
        let mut tracks = Trajectories::empty(5, (8, 8));
        tracks.push(0, [(1.0, 1.0, 0.0); 5]);
        tracks.push(4, [(1.0, 1.0, 0.0)]);
        assert_eq!(greatest_of_points(&tracks, &[0.5, 0.1, 0.9, 0.3, -1.0, -1.0]), [0.9, 0.0]);
        assert!(trajectory_saliency(&Trajectories::empty(5, (8, 8)), &[]).is_empty());
    }
}
