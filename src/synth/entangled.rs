//! Two players in a hall who move alike and reach for each other: motion alone cannot tell them apart.
//!
//! Laid out on a board of 320 × 240 units that is fitted into the frame; the middle frame of the clip shows the layout
//! as written here. Motions are in units a frame.

use super::affine::{Affine, sin_turns};
use super::brush::{Colour, Noise, blend, ramp, shade};
use super::figure::{Figure, Gait, LEG};
use super::scene::{Scene, Sprite};

/// Width and height of the board.
const BOARD: (f64, f64) = (320.0, 240.0);
/// Where the wall meets the floor.
const SKIRTING: f32 = 128.0;
/// Speed of the camera to the right, and of the players beside it.
const PAN: f64 = 1.5;
const RUN: f64 = 0.5;
/// From hip to hip. With arms down at least 15 units lie between the players; their arms are 49 units long.
const APART: f64 = 84.0;

impl Scene {
    /// Two players who face each other and move sideways at one speed, as one guards the other. In the middle of the
    /// clip, from about
    /// 0.42 to 0.65 of it, they stretch out their arms, which overlap; before and after that a gap lies between them.
    /// Legs step in turn; hips, trunks and heads move alike to less than 0.1 units a frame at all times. Objects: 1 the
    /// left one, 2 the right one.
    ///
    /// This is the case of the paper's Figure 7: what moves alike is two things, and one thing does not move alike.
    pub fn entangled(width: usize, height: usize, num_frames: usize, seed: u64) -> Self {
        let mut scene = Self::new(width, height, num_frames);
        let hall = Hall::new(&scene, seed);
        hall.add_backdrop(&mut scene);
        let clothes = [
            ([[204.0, 60.0, 52.0], [248.0, 220.0, 180.0]], [70.0, 64.0, 92.0]),
            ([[58.0, 104.0, 186.0], [240.0, 214.0, 96.0]], [98.0, 78.0, 60.0]),
        ];
        for (k, (jumper, trousers)) in clothes.into_iter().enumerate() {
            let player = Figure {
                jumper,
                trousers,
                hat: shade(jumper[1], -0.25),
                backpack: shade(jumper[0], -0.3),
                density: hall.density,
                seed: seed ^ (0x91 + k as u64),
            };
            // Half a cycle apart: the legs take turns, the trunks rise and sink together.
            let gait = Gait { period: 30.0, phase: 0.1 + 0.5 * k as f64, swing: 0.045 };
            let side = if k == 0 { 1.0 } else { -1.0 };
            let foot = BOARD.1 - 14.0 - f64::from(LEG);
            let x = |t: f64| 0.5 * BOARD.0 - side * 0.5 * APART + hall.drift(t, RUN);
            let hip = |t: f64| Affine::scaling(side, 1.0).then(&hall.pose(x(t), foot));
            player.add_reaching(&mut scene, k as u8 + 1, gait, hip, |t| hall.reach(t));
        }
        scene
    }
}

struct Hall {
    /// From board units to pixels.
    view: Affine,
    /// Pixels a unit.
    density: f32,
    /// The last frame and half of it.
    last: f64,
    middle: f64,
    /// Part of the board that some frame shows: left, top, right, bottom.
    seen: [f32; 4],
    noise: Noise,
}

impl Hall {
    fn new(scene: &Scene, seed: u64) -> Self {
        let (width, height) = (scene.size().0 as f64, scene.size().1 as f64);
        let scale = (width / BOARD.0).min(height / BOARD.1);
        let view = Affine::translation(-0.5 * BOARD.0, -0.5 * BOARD.1)
            .then(&Affine::scaling(scale, scale))
            .then(&Affine::translation(0.5 * (width - 1.0), 0.5 * (height - 1.0)));
        let last = (scene.num_frames() as f64 - 1.0).max(1.0);
        let noise = Noise(crate::rng::mix(seed ^ 0x4a11));
        let mut hall = Self { view, density: scale as f32, last, middle: 0.5 * last, seen: [0.0; 4], noise };
        let reach = (0..=scene.num_frames()).map(|t| hall.drift(t as f64, PAN).abs()).fold(0.0, f64::max);
        let (across, down) = (0.5 * width / scale + 1.6 * reach + 2.0, 0.5 * height / scale + 2.0);
        let (x, y) = (0.5 * BOARD.0, 0.5 * BOARD.1);
        hall.seen = [x - across, y - down, x + across, y + down].map(|v| v as f32);
        hall
    }

    /// How far something of `speed` units a frame has come, from the middle of the clip; it swings back in 360 frames.
    fn drift(&self, t: f64, speed: f64) -> f64 {
        speed * 360.0 / std::f64::consts::TAU * sin_turns((t - self.middle) / 360.0)
    }

    /// How far the arms are stretched out at frame `t`.
    fn reach(&self, t: f64) -> f64 {
        let f = (t / self.last) as f32;
        f64::from(ramp(0.30, 0.45, f) * ramp(0.72, 0.57, f))
    }

    fn pose(&self, x: f64, y: f64) -> Affine {
        Affine::translation(x, y).then(&self.view)
    }

    /// The finest grain that survives resampling, in units.
    fn finest(&self) -> f32 {
        2.4 / self.density
    }

    fn add_backdrop(&self, scene: &mut Scene) {
        let wall = scene.add_sprite(self.wall());
        scene.add_layer(wall, 0, |t| self.pose(-self.drift(t, PAN), 0.0));
        let floor = scene.add_sprite(self.floor());
        scene.add_layer(floor, 0, |t| {
            // What is nearer to the camera passes faster.
            Affine::shear(-self.drift(t, 0.003 * PAN), f64::from(SKIRTING)).then(&self.pose(-self.drift(t, PAN), 0.0))
        });
    }

    /// Painted bricks.
    fn wall(&self) -> Sprite {
        let [left, top, right, bottom] = self.seen;
        Sprite::paint([left, top, right, bottom], self.density, |x, y| {
            let row = (y / 11.0).floor();
            let shifted = x + 13.0 * (row - 2.0 * (row * 0.5).floor());
            let column = (shifted / 26.0).floor();
            let from_edge = |v: f32, period: f32| (v / period - (v / period).floor() - 0.5).abs() * period;
            let joint = ramp(1.4, 0.2, 13.0 - from_edge(shifted, 26.0)).max(ramp(1.4, 0.2, 5.5 - from_edge(y, 11.0)));
            let fired = self.noise.fractal(column * 7.3, row * 5.1, 4.0, 3.0);
            let brick = blend([150.0, 112.0, 92.0], [186.0, 158.0, 122.0], ramp(-0.5, 0.5, fired));
            let worn = self.noise.fractal(x, y + 500.0, 18.0, self.finest());
            (shade(blend(brick, MORTAR, 0.8 * joint), 0.4 * worn), -1e3)
        })
    }

    /// Planks across the view.
    fn floor(&self) -> Sprite {
        let [left, _, right, bottom] = self.seen;
        Sprite::paint([left, SKIRTING, right, bottom], self.density, |x, y| {
            let near = (y - SKIRTING + 40.0) / 80.0;
            let plank = (60.0 / near).floor();
            let grain = self.noise.fractal(0.5 * x + 91.0 * plank, y + 37.0 * plank, 20.0, self.finest());
            let knots = self.noise.fractal(x, 1.6 * y + 800.0, 13.0, self.finest());
            let wood = blend([176.0, 128.0, 78.0], [222.0, 178.0, 118.0], ramp(-0.6, 0.6, grain));
            (shade(wood, 0.42 * knots - 0.2 * ramp(SKIRTING + 4.0, SKIRTING, y)), SKIRTING + 1.0 - y)
        })
    }
}

const MORTAR: Colour = [214.0, 206.0, 194.0];
