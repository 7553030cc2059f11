//! Two players in a hall who move alike and reach for each other: motion alone cannot separate them.
//!
//! The scene is laid out on a board of 320 × 240 units that is fitted into the frame; the middle frame of the clip shows the
//! layout as written here. Motions are in units per frame. All sizes, speeds and colours were chosen by eye.

use super::affine::Affine;
use super::board::Board;
use super::brush::{Colour, blend, ramp, shade};
use super::person::{Gait, LEG, Person};
use super::scene::{Scene, Sprite};

/// Width and height of the board, in units.
const BOARD_SIZE: [f64; 2] = [320.0, 240.0];
/// Height at which the wall meets the floor.
const SKIRTING_Y: f32 = 128.0;
/// Speed of the camera to the right.
const PAN_SPEED: f64 = 1.5;
/// Speed of the players to the right.
const RUN_SPEED: f64 = 0.5;
/// Distance between the hips. With arms down the players are at least 15 units apart; their arms are 49 units long.
const HIP_DISTANCE: f64 = 84.0;

impl Scene {
    /// Creates a scene of two players who face each other and move sideways at one speed.
    ///
    /// In the middle of the clip, from about 0.42 to 0.65 of it, they stretch out their arms, which overlap; before and after
    /// that there is a gap between them. Their legs step alternately; hips, trunks and heads differ by less than 0.1 units per
    /// frame at all times. Objects: 1 the left player, 2 the right one.
    ///
    /// This is the case of the paper's Figure 7: two objects with the same motion, each of which moves unevenly.
    #[doc(hidden)] // For tests and benchmarks.
    pub fn entangled((width, height): (usize, usize), num_frames: usize, seed: u64) -> Self {
        let mut scene = Self::new(width, height, num_frames);
        let hall = Board::new(&scene, BOARD_SIZE, PAN_SPEED, [1.6, 2.0], seed ^ 0x4a11);
        hall.add_hall(&mut scene);
        let clothes = [
            ([[204.0, 60.0, 52.0], [248.0, 220.0, 180.0]], [70.0, 64.0, 92.0]),
            ([[58.0, 104.0, 186.0], [240.0, 214.0, 96.0]], [98.0, 78.0, 60.0]),
        ];
        for (k, (jumper, trousers)) in clothes.into_iter().enumerate() {
            let player = Person {
                jumper,
                trousers,
                hat: shade(jumper[1], -0.25),
                backpack: shade(jumper[0], -0.3),
                density: hall.density,
                seed: seed ^ (0x91 + k as u64),
            };
            // Half a cycle apart: the legs alternate, the trunks rise and sink together.
            let gait = Gait { period: 30.0, phase: 0.1 + 0.5 * k as f64, swing: 0.045 };
            let side = if k == 0 { 1.0 } else { -1.0 };
            let height = BOARD_SIZE[1] - 14.0 - f64::from(LEG);
            let x = |t: f64| 0.5 * BOARD_SIZE[0] - side * 0.5 * HIP_DISTANCE + hall.drift(t, RUN_SPEED);
            let hip = |t: f64| Affine::scaling(side, 1.0).then(&hall.pose(x(t), height));
            player.add_to(&mut scene, k as u8 + 1, gait, hip, |t| hall.reach(t));
        }
        scene
    }
}

impl Board {
    /// Returns the extension of the arms at frame `t`, 0 to 1.
    fn reach(&self, t: f64) -> f64 {
        let f = (t / (2.0 * self.middle).max(1.0)) as f32;
        f64::from(ramp(0.30, 0.45, f) * ramp(0.72, 0.57, f))
    }

    fn add_hall(&self, scene: &mut Scene) {
        let wall = scene.add_sprite(self.wall());
        scene.add_layer(wall, 0, |t| self.pose(-self.drift(t, PAN_SPEED), 0.0));
        let floor = scene.add_sprite(self.floor());
        scene.add_layer(floor, 0, |t| {
            // Points closer to the camera move faster.
            let shear = Affine::shear(-self.drift(t, 0.003 * PAN_SPEED), f64::from(SKIRTING_Y));
            shear.then(&self.pose(-self.drift(t, PAN_SPEED), 0.0))
        });
    }

    /// Paints bricks.
    fn wall(&self) -> Sprite {
        Sprite::paint(self.visible, self.density, |x, y| {
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

    /// Paints planks across the view.
    fn floor(&self) -> Sprite {
        let [left, _, right, bottom] = self.visible;
        Sprite::paint([left, SKIRTING_Y, right, bottom], self.density, |x, y| {
            let closeness = (y - SKIRTING_Y + 40.0) / 80.0;
            let plank = (60.0 / closeness).floor();
            let grain = self.noise.fractal(0.5 * x + 91.0 * plank, y + 37.0 * plank, 20.0, self.finest());
            let knots = self.noise.fractal(x, 1.6 * y + 800.0, 13.0, self.finest());
            let wood = blend([176.0, 128.0, 78.0], [222.0, 178.0, 118.0], ramp(-0.6, 0.6, grain));
            (shade(wood, 0.42 * knots - 0.2 * ramp(SKIRTING_Y + 4.0, SKIRTING_Y, y)), SKIRTING_Y + 1.0 - y)
        })
    }
}

const MORTAR: Colour = [214.0, 206.0, 194.0];
