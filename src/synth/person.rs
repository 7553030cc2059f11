//! A walking person: a chain of rotated limbs, all of one object.
//!
//! Lengths are in the person's own units, in which it is about 140 high; the hip is the origin, x points forward. All sizes
//! and colours were chosen by eye.

use super::affine::{Affine, sin_turns};
use super::brush::{Colour, Noise, bar, blend, disc, ramp, rounded_box, shade};
use super::scene::{Scene, Sprite};

// Lengths of limbs.
const THIGH: f32 = 32.0;
const SHIN: f32 = 31.0;
const UPPER_ARM: f32 = 23.0;
const FOREARM: f32 = 21.0;
/// Height of the shoulder above the hip.
const SHOULDER: f32 = 42.0;
/// Distance from the hip to the sole of a straight leg.
pub(super) const LEG: f32 = THIGH + SHIN + 5.0;

/// The appearance of a walking person.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Person {
    /// Main and second colour of the striped jumper.
    pub jumper: [Colour; 2],
    /// Colour of the trousers.
    pub trousers: Colour,
    /// Colour of the hat.
    pub hat: Colour,
    /// Colour of the backpack.
    pub backpack: Colour,
    /// Texels per unit; best equal to the pixels per unit in the frame.
    pub density: f32,
    /// Seed of the cloth's texture.
    pub seed: u64,
}

/// The motion of the limbs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gait {
    /// Frames of two steps.
    pub period: f64,
    /// Phase at frame 0, in turns.
    pub phase: f64,
    /// Swing of a leg to either side of the vertical, in turns.
    pub swing: f64,
}

impl Person {
    /// Adds the person to a scene as object `label`. `hip(t)` is the pose of its hip at frame `t`; `reach(t)` stretches both
    /// arms, from 0, swinging with the gait, to 1, forward at shoulder height.
    pub(crate) fn add_to(
        &self,
        scene: &mut Scene,
        label: u8,
        gait: Gait,
        hip: impl Fn(f64) -> Affine,
        reach: impl Fn(f64) -> f64,
    ) {
        let arm_angle = |t: f64, swinging: f64, stretched: f64| swinging + (stretched - swinging) * reach(t);
        let cycle = |t: f64| t / gait.period + gait.phase;
        // The body is highest when one leg is straight below it, twice a cycle.
        let body = |t: f64| Affine::translation(0.0, 1.6 * sin_turns(2.0 * cycle(t) + 0.25)).then(&hip(t));
        let leg = |t: f64, side: f64| swing_forward(gait.swing * sin_turns(cycle(t) + side)).then(&body(t));
        // The knee bends while its leg swings forward.
        let knee = |t: f64, side: f64| {
            let bend = (0.5 + 0.5 * sin_turns(cycle(t) + side + 0.33)).max(0.0);
            joint(-0.012 - 0.12 * bend * bend, THIGH).then(&leg(t, side))
        };
        let arm = |t: f64, side: f64| {
            let swinging = -0.02 - 0.9 * gait.swing * sin_turns(cycle(t) + side);
            swing_forward(arm_angle(t, swinging, 0.24 - 0.03 * side))
                .then(&Affine::translation(0.5, f64::from(-SHOULDER)))
                .then(&body(t))
        };
        let elbow = |t: f64, side: f64| {
            let swinging = 0.085 - 0.035 * sin_turns(cycle(t) + side);
            joint(arm_angle(t, swinging, 0.01), UPPER_ARM).then(&arm(t, side))
        };
        let [thigh, shin] = [self.thigh(), self.shin()].map(|s| scene.add_sprite(s));
        let [upper, lower] = [self.upper_arm(), self.forearm()].map(|s| scene.add_sprite(s));
        let [backpack, torso, head] = [self.backpack(), self.torso(), self.head()].map(|s| scene.add_sprite(s));
        scene.add_layer(lower, label, |t| elbow(t, 0.5));
        scene.add_layer(upper, label, |t| arm(t, 0.5));
        scene.add_layer(shin, label, |t| knee(t, 0.5));
        scene.add_layer(thigh, label, |t| leg(t, 0.5));
        scene.add_layer(shin, label, |t| knee(t, 0.0));
        scene.add_layer(thigh, label, |t| leg(t, 0.0));
        scene.add_layer(backpack, label, body);
        scene.add_layer(head, label, body);
        scene.add_layer(torso, label, body);
        scene.add_layer(lower, label, |t| elbow(t, 0.0));
        scene.add_layer(upper, label, |t| arm(t, 0.0));
    }

    /// Returns the colour of cloth at a point: a weave, and a soft outline towards the edge at signed distance `distance`.
    fn cloth(&self, colour: Colour, x: f32, y: f32, distance: f32) -> Colour {
        let weave = Noise(self.seed).fractal(x, y, 14.0, 2.4 / self.density);
        shade(colour, 0.34 * weave - 0.30 * ramp(-3.5, 0.5, distance) + 0.06)
    }

    /// Paints a limb that hangs from the origin, with radius `top` there and `bottom` at its end.
    fn limb(&self, length: f32, top: f32, bottom: f32, colour: impl Fn(f32, f32, f32) -> Colour) -> Sprite {
        let width = top.max(bottom);
        Sprite::paint([-width, -width, width, length + width], self.density, |x, y| {
            let distance = bar(x, y, (0.0, 0.0), (0.0, length), top, bottom);
            (colour(x, y, distance), distance)
        })
    }

    fn thigh(&self) -> Sprite {
        self.limb(THIGH, 9.0, 6.8, |x, y, d| self.cloth(self.trousers, x, y, d))
    }

    fn shin(&self) -> Sprite {
        const BOOT: Colour = [112.0, 62.0, 34.0];
        Sprite::paint([-8.0, -7.0, 15.0, SHIN + 6.0], self.density, |x, y| {
            let leg = bar(x, y, (0.0, 0.0), (0.0, SHIN - 3.0), 6.6, 4.6);
            let boot = rounded_box(x, y, (0.3, SHIN - 5.0), (5.4, 7.0), 3.0);
            let foot = rounded_box(x, y, (4.0, SHIN + 1.2), (9.2, 3.8), 3.2);
            let shoe = boot.min(foot);
            let distance = leg.min(shoe);
            let trouser = self.cloth(self.trousers, x + 40.0, y, leg);
            let sole = ramp(0.2, -0.2, (SHIN + 3.4 - y) * self.density.min(1.5));
            let leather = blend(self.cloth(BOOT, x, y + 30.0, shoe), [58.0, 40.0, 32.0], sole);
            (blend(trouser, leather, ramp(0.5, -0.5, shoe)), distance)
        })
    }

    fn upper_arm(&self) -> Sprite {
        self.limb(UPPER_ARM, 7.0, 5.8, |x, y, d| self.cloth(self.stripes(y + 3.0), x, y - 20.0, d))
    }

    fn forearm(&self) -> Sprite {
        self.limb(FOREARM, 5.8, 4.6, |x, y, d| {
            let sleeve = self.cloth(self.stripes(y + 5.0), x, y - 50.0, d);
            let skin = self.cloth(SKIN, x, y, d);
            blend(sleeve, skin, ramp(-0.5, 0.5, y - FOREARM + 3.5))
        })
    }

    /// Returns the jumper's colour at height `y`: stripes of 5 units.
    fn stripes(&self, y: f32) -> Colour {
        let phase = (y / 10.0) - (y / 10.0).floor();
        let edge = (0.25 - (phase - 0.5).abs()) * 10.0 * self.density.min(1.5);
        blend(self.jumper[0], self.jumper[1], ramp(-0.6, 0.6, edge))
    }

    fn torso(&self) -> Sprite {
        Sprite::paint([-15.0, -57.0, 15.0, 9.0], self.density, |x, y| {
            let chest = bar(x, y, (0.5, -38.0), (0.0, -2.0), 13.0, 10.5);
            let neck = bar(x, y, (0.0, -44.0), (1.5, -52.0), 5.0, 4.5);
            let jumper = self.cloth(self.stripes(y), x, y, chest);
            let belt = self.cloth(shade(self.trousers, -0.1), x, y, chest);
            let dressed = blend(jumper, belt, ramp(-0.6, 0.6, y + 1.0));
            let strap = ((x + 3.0) * 0.9 + (y + 38.0) * 0.15).abs() - 2.0;
            let dressed = blend(dressed, shade(self.backpack, -0.25), ramp(0.5, -0.5, strap.max(y + 14.0)));
            (blend(self.cloth(SKIN, x, y, neck), dressed, ramp(0.6, -0.4, chest)), chest.min(neck))
        })
    }

    fn backpack(&self) -> Sprite {
        Sprite::paint([-29.0, -52.0, 1.0, 1.0], self.density, |x, y| {
            let bag = rounded_box(x, y, (-14.0, -24.0), (12.0, 19.0), 7.0);
            let pocket = rounded_box(x, y, (-20.0, -16.0), (6.5, 8.0), 3.0);
            let roll = disc(x, y, (-16.0, -45.0), 6.0);
            let canvas = self.cloth(self.backpack, x, y + 90.0, bag);
            let canvas = blend(canvas, self.cloth(shade(self.backpack, 0.3), x, y, pocket), ramp(0.4, -0.4, pocket));
            let buckle = ramp(0.5, -0.5, (y + 33.0).abs() - 1.6);
            let canvas = blend(canvas, [70.0, 48.0, 40.0], 0.8 * buckle);
            let mat = self.cloth(shade(self.jumper[1], -0.1), x, y, roll + 2.0 * ramp(2.0, 3.0, roll + 5.0));
            (blend(canvas, mat, ramp(0.4, -0.4, roll)), bag.min(roll))
        })
    }

    fn head(&self) -> Sprite {
        Sprite::paint([-17.0, -82.0, 19.0, -48.0], self.density, |x, y| {
            let skull = bar(x, y, (1.5, -60.0), (1.5, -64.0), 9.6, 10.2);
            let nose = disc(x, y, (11.2, -60.0), 2.2);
            let hair = bar(x, y, (-3.5, -58.0), (-2.5, -64.0), 8.0, 9.0).max(x - 2.0);
            let crown = rounded_box(x, y, (0.8, -73.5), (9.8, 7.0), 5.0);
            let brim = rounded_box(x, y, (1.2, -68.4), (16.0, 1.9), 1.9);
            let hat = crown.min(brim);
            let face = self.cloth(SKIN, x, y, skull.min(nose));
            let eye = disc(x, y, (7.2, -62.0), 1.3);
            let face = blend(face, [50.0, 36.0, 34.0], ramp(0.5, -0.5, eye));
            let face = blend(face, self.cloth([92.0, 56.0, 34.0], x * 2.0, y, hair), ramp(0.5, -0.5, hair));
            let band = ramp(0.5, -0.5, (y + 71.6).abs() - 1.5);
            let felt = blend(self.cloth(self.hat, x, y, hat), shade(self.hat, -0.5), band * ramp(0.3, -0.3, crown));
            (blend(face, felt, ramp(0.5, -0.5, hat)), skull.min(nose).min(hat))
        })
    }
}

const SKIN: Colour = [226.0, 172.0, 138.0];

/// Swings a limb that hangs from the origin forward by `turns`.
fn swing_forward(turns: f64) -> Affine {
    Affine::rotation(-turns)
}

/// Attaches a limb to the end of another of length `length`, bent forward by `turns`.
fn joint(turns: f64, length: f32) -> Affine {
    swing_forward(turns).then(&Affine::translation(0.0, f64::from(length)))
}
