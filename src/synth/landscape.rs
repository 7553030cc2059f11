//! The sample scene: a hiker, a camper van and a hot-air balloon before hills and a meadow, seen by a panning camera.
//!
//! It is laid out on a board of 480 × 270 units that is fitted into the frame; wider or higher frames show more of the
//! backdrop. The middle frame of the clip shows the layout as written here. Motions are in units per frame. All sizes, speeds
//! and colours were chosen by eye.

use super::affine::{Affine, sin_turns};
use super::board::Board;
use super::brush::{Colour, Noise, bar, blend, disc, lerp, ramp, rounded_box, shade};
use super::person::{Gait, LEG, Person};
use super::scene::{Scene, Sprite};

/// Width and height of the board, in units.
const BOARD_SIZE: [f64; 2] = [480.0, 270.0];
/// Height at which the meadow meets the hills.
const HORIZON_Y: f32 = 152.0;
/// Scale of the van, which is painted 64 units long.
const VAN_SCALE: f64 = 1.25;
/// Speed of the camera to the right, for a layer at depth factor 1.
const PAN_SPEED: f64 = 1.6;
/// Depth factor of the meadow at the horizon.
const MEADOW_DEPTH: f64 = 0.85;
/// Growth of the meadow's depth factor per unit downwards.
const MEADOW_DEPTH_SLOPE: f64 = 0.0032;

impl Scene {
    /// Creates the sample scene. Objects: 1 a large balloon (affine motion: turns, grows and drifts), 2 a small camper van
    /// (drives by), 3 a walking hiker (articulated). The background pans with parallax: sky, two ranges of hills, trees and a
    /// meadow.
    ///
    /// Motions scale with the frame. At 480 × 270 the background moves by 1 to 2 px per frame, objects by 1.5 to 4 px per
    /// frame against it. The clip can have any number of frames: motions that would leave the frame swing back in 360 frames.
    /// `seed` changes the textures, the hills and the trees, not the motions of objects.
    pub fn sample((width, height): (usize, usize), num_frames: usize, seed: u64) -> Self {
        let mut scene = Self::new(width, height, num_frames);
        let board = new_board(&scene, seed);
        board.add_backdrop(&mut scene);
        board.add_balloon(&mut scene);
        board.add_van(&mut scene);
        let hiker = Person {
            jumper: [[216.0, 78.0, 60.0], [246.0, 226.0, 196.0]],
            trousers: [64.0, 82.0, 120.0],
            hat: [196.0, 152.0, 84.0],
            backpack: [52.0, 128.0, 120.0],
            density: board.density,
            seed: seed ^ 0x71,
        };
        let gait = Gait { period: 34.0, phase: 0.12 - board.middle / 34.0, swing: 0.072 };
        let height = BOARD_SIZE[1] - 16.0 - f64::from(LEG);
        let hip = |t: f64| board.pose(352.0 + board.drift(t, 0.3), height - board.tilt(t));
        hiker.add_to(&mut scene, 3, gait, hip, |_| 0.0);
        scene
    }

    /// Creates a scene of two hikers who touch and walk alike for the first half of the clip; then the second one falls
    /// behind. Objects: 1 the front one, 2 the one behind.
    #[doc(hidden)] // For tests and benchmarks.
    pub fn two_walkers((width, height): (usize, usize), num_frames: usize, seed: u64) -> Self {
        let mut scene = Self::new(width, height, num_frames);
        let board = new_board(&scene, seed);
        board.add_backdrop(&mut scene);
        let clothes = [
            ([[216.0, 78.0, 60.0], [246.0, 226.0, 196.0]], [64.0, 82.0, 120.0]),
            ([[70.0, 110.0, 180.0], [236.0, 200.0, 90.0]], [110.0, 92.0, 70.0]),
        ];
        for (k, (jumper, trousers)) in clothes.into_iter().enumerate() {
            let walker = Person {
                jumper,
                trousers,
                hat: shade(jumper[1], -0.3),
                backpack: shade(jumper[0], -0.3),
                density: board.density,
                seed: seed ^ (0x71 + k as u64),
            };
            let gait = Gait { period: 34.0, phase: 0.05, swing: 0.072 };
            let height = BOARD_SIZE[1] - 16.0 - f64::from(LEG);
            let lag = |t: f64| if k == 0 { 0.0 } else { -36.0 - 1.5 * (t - board.middle).max(0.0) };
            let x = |t: f64| 270.0 + board.drift(t, 0.55) + lag(t);
            let hip = |t: f64| board.pose(x(t), height - board.tilt(t));
            walker.add_to(&mut scene, k as u8 + 1, gait, hip, |_| 0.0);
        }
        scene
    }
}

fn new_board(scene: &Scene, seed: u64) -> Board {
    Board::new(scene, BOARD_SIZE, PAN_SPEED, [1.5, 12.0], seed)
}

impl Board {
    /// Returns the tilt of the camera in units: it rises and sinks by 6.
    fn tilt(&self, t: f64) -> f64 {
        6.0 * sin_turns((t - self.middle) / 200.0)
    }

    /// Returns the pose of the board at depth factor `depth`, moved by the camera.
    fn layer_pose(&self, t: f64, depth: f64) -> Affine {
        self.pose(-self.drift(t, PAN_SPEED * depth), -self.tilt(t))
    }

    fn grain(&self, x: f32, y: f32, coarsest: f32) -> f32 {
        self.noise.fractal(x, y, coarsest, self.finest())
    }

    fn add_backdrop(&self, scene: &mut Scene) {
        let sky = scene.add_sprite(self.sky());
        scene.add_layer(sky, 0, |t| self.layer_pose(t, 0.68));
        let mountains = scene.add_sprite(self.mountains());
        scene.add_layer(mountains, 0, |t| self.layer_pose(t, 0.74));
        let woods = scene.add_sprite(self.woods());
        scene.add_layer(woods, 0, |t| self.layer_pose(t, 0.80));
        let meadow = scene.add_sprite(self.meadow());
        scene.add_layer(meadow, 0, |t| {
            let slope = -self.drift(t, PAN_SPEED * MEADOW_DEPTH_SLOPE);
            Affine::shear(slope, f64::from(HORIZON_Y)).then(&self.layer_pose(t, MEADOW_DEPTH))
        });
        self.add_trees(scene);
    }

    fn sky(&self) -> Sprite {
        let [left, top, right, _] = self.visible;
        Sprite::paint([left, top, right, HORIZON_Y], self.density, |x, y| {
            let height = ((HORIZON_Y - y) / HORIZON_Y).clamp(0.0, 1.2);
            let low = blend([252.0, 214.0, 170.0], [150.0, 190.0, 214.0], ramp(0.15, 0.62, height));
            let air = blend(low, [74.0, 128.0, 186.0], ramp(0.5, 1.15, height));
            // Clouds are flattened heaps, lit from above.
            let heap = |y: f32| self.grain(x, 1.9 * y + 400.0, 72.0);
            let cover = ramp(-0.02, 0.5, heap(y));
            let light = (heap(y) - heap(y - 5.0)) * 1.1;
            let cloud = shade([248.0, 236.0, 224.0], (light - 0.06).clamp(-0.34, 0.03));
            (shade(blend(air, cloud, 0.9 * cover), 0.05 * self.grain(x, y, 12.0)), -1e3)
        })
    }

    fn mountains(&self) -> Sprite {
        let [left, _, right, _] = self.visible;
        Sprite::paint([left, 60.0, right, HORIZON_Y + 6.0], self.density, |x, y| {
            let ridge = |x: f32| 112.0 - 34.0 * self.noise.fractal(x, 7.0, 110.0, self.finest().max(4.0));
            let rock = |x: f32, y: f32| self.grain(0.8 * x, 0.8 * y + 900.0, 42.0) + 0.012 * x;
            // The slope towards the sun, upper left, is lit.
            let light = (rock(x + 1.5, y + 1.0) - rock(x - 1.5, y - 1.0)) * 1.5;
            let snow = ramp(-5.0, 9.0, 97.0 - y + 16.0 * self.grain(x, y + 300.0, 30.0));
            let stone = blend([112.0, 116.0, 152.0], [176.0, 168.0, 184.0], ramp(118.0, 158.0, y));
            let colour = shade(blend(stone, [240.0, 238.0, 246.0], 0.85 * snow), light.clamp(-0.32, 0.32));
            (colour, (ridge(x) - y) * 0.8)
        })
    }

    fn woods(&self) -> Sprite {
        let [left, _, right, _] = self.visible;
        Sprite::paint([left, 100.0, right, HORIZON_Y + 8.0], self.density, |x, y| {
            let hill = 133.0 - 14.0 * self.noise.fractal(x, 77.0, 150.0, 20.0);
            let tops = 4.5 * self.noise.fractal(x * 1.3, 33.0, 10.0, self.finest().max(2.0));
            let crowns = self.grain(x * 1.2, y * 1.5 + 50.0, 9.0);
            let wood = blend([58.0, 92.0, 74.0], [104.0, 134.0, 88.0], ramp(-0.6, 0.8, self.grain(x, y * 2.0, 46.0)));
            let haze = blend(wood, [168.0, 172.0, 160.0], 0.25 + 0.2 * ramp(HORIZON_Y - 22.0, HORIZON_Y, y));
            (shade(haze, 0.42 * crowns), (hill + tops - y) * 0.8)
        })
    }

    fn meadow(&self) -> Sprite {
        let [left, _, right, bottom] = self.visible;
        // Sheared rows extend farther to the side.
        let extra = 0.5 * (right - left - BOARD_SIZE[0] as f32).max(0.0);
        Sprite::paint([left - extra, HORIZON_Y - 6.0, right + extra, bottom], self.density, |x, y| {
            let edge = HORIZON_Y - 1.0 + 3.0 * self.noise.fractal(x, 11.0, 60.0, self.finest().max(3.0));
            // A plane in perspective: depth is inverse to the distance from the horizon.
            let closeness = ((y - HORIZON_Y + 26.0) / 144.0).max(0.08);
            let (plane_x, plane_y) = ((x - 240.0) / closeness, 230.0 / closeness);
            let texel = (230.0 / (closeness * closeness * 144.0)).max(1.0 / closeness) * self.finest();
            let ground =
                |coarsest: f32, shift: f32| self.noise.fractal(plane_x + shift, plane_y - shift, coarsest, texel);
            let tufts = self.noise.fractal(x, 1.7 * y, 16.0 * closeness + 3.0, self.finest());
            let fresh = blend([98.0, 136.0, 62.0], [176.0, 176.0, 84.0], ramp(-0.5, 0.6, ground(190.0, 0.0)));
            let grass = blend(fresh, [214.0, 190.0, 110.0], 0.5 * ramp(0.1, 0.7, ground(120.0, 700.0)));
            let grass = shade(grass, 0.30 * tufts + 0.26 * ground(28.0, 90.0));
            let flowers = ramp(0.52, 0.62, self.grain(x, 1.4 * y + 70.0, 7.0)) * ramp(0.45, 0.7, closeness);
            let bloom = blend([246.0, 240.0, 226.0], [232.0, 120.0, 96.0], ramp(0.0, 0.3, ground(60.0, 50.0)));
            let grass = blend(grass, bloom, 0.75 * flowers);
            let middle = 208.0 + 2.5 * self.noise.fractal(x, 21.0, 120.0, 20.0);
            let road = (y - middle).abs() - 10.5 - 1.6 * tufts;
            let dust = shade([206.0, 178.0, 142.0], 0.16 * ground(20.0, 5.0) + 0.16 * tufts);
            let ruts = ramp(1.6, 0.4, ((y - middle).abs() - 5.5).abs());
            let dust = shade(dust, -0.16 * ruts);
            let colour = blend(grass, dust, ramp(1.2, -1.2, road));
            let haze = 0.35 * ramp(HORIZON_Y + 16.0, HORIZON_Y - 2.0, y);
            (blend(colour, [196.0, 190.0, 150.0], haze), edge - y)
        })
    }

    fn add_trees(&self, scene: &mut Scene) {
        let sprites: Vec<usize> = (0..3).map(|k| scene.add_sprite(self.tree(k))).collect();
        let mut rng = crate::rng::Rng::for_stage(self.noise.0, "trees");
        let (begin, end) = (f64::from(self.visible[0]), f64::from(self.visible[2]));
        let num_trees = ((end - begin) / 58.0) as usize;
        // Far ones first. Sorted by insertion: a sort would be the largest function of this module.
        let mut trees: Vec<(f64, f64)> = Vec::new();
        for k in 0..num_trees {
            let (x, foot) = (begin + (k as f64 + rng.uniform()) * 58.0, f64::from(HORIZON_Y) + rng.range(4.0, 22.0));
            trees.insert(trees.partition_point(|tree| tree.1 <= foot), (x, foot));
        }
        for (k, (x, foot)) in trees.into_iter().enumerate() {
            let size = 0.45 + (foot - f64::from(HORIZON_Y)) / 40.0;
            let depth = MEADOW_DEPTH + MEADOW_DEPTH_SLOPE * (foot - f64::from(HORIZON_Y));
            let stand = Affine::scaling(size, size).then(&Affine::translation(x, foot));
            scene.add_layer(sprites[k % 3], 0, |t| stand.then(&self.layer_pose(t, depth)));
        }
    }

    /// Paints a round tree, 56 units high, with its foot at the origin.
    fn tree(&self, kind: usize) -> Sprite {
        let noise = Noise(self.noise.0 + 17 * kind as u64);
        let lobes =
            [(0.0, -38.0, 15.0), (-9.0, -30.0, 11.0), (10.0, -29.0, 11.5), (2.0 - 3.0 * kind as f32, -24.0, 11.0)];
        Sprite::paint([-26.0, -58.0, 27.0, 2.0], self.density, |x, y| {
            let ragged = 2.6 * noise.fractal(x, y, 9.0, self.finest());
            let crown = lobes.iter().map(|&(cx, cy, r)| disc(x, y, (cx, cy), r)).fold(f32::MAX, f32::min) + ragged;
            let trunk = bar(x, y, (0.5, -22.0), (0.0, -1.0), 2.0, 3.0);
            let light = 0.30 - (y + 38.0 + 0.5 * x) / 46.0;
            let clumps = noise.fractal(x + 60.0, y, 10.0, self.finest());
            let hue = [[92.0, 128.0, 58.0], [112.0, 132.0, 56.0], [74.0, 116.0, 66.0]][kind % 3];
            let leaves = shade(hue, (0.45 * light + 0.55 * clumps).clamp(-0.55, 0.5));
            let bark = shade([104.0, 78.0, 58.0], 0.3 * clumps);
            (blend(bark, leaves, ramp(0.5, -0.5, crown)), crown.min(trunk))
        })
    }

    fn add_balloon(&self, scene: &mut Scene) {
        let balloon = scene.add_sprite(self.balloon());
        scene.add_layer(balloon, 1, |t| {
            let time = t - self.middle;
            // Grows by a third in a hundred frames and shrinks again, and leans into the wind.
            let size = 1.0 + 0.33 * sin_turns(time / 400.0) * 400.0 / 628.0;
            let lean = 0.035 * sin_turns(time / 220.0) + 0.008;
            Affine::scaling(0.80 * size, 0.80 * size)
                .then(&Affine::rotation(lean))
                .then(&self.pose(140.0 + self.drift(t, 2.2), 66.0 - self.drift(t, 0.1)))
        });
    }

    /// Paints the balloon, with the middle of its envelope at the origin.
    fn balloon(&self) -> Sprite {
        const RADIUS: f32 = 62.0;
        // Painted a little finer, as it grows.
        let density = 1.1 * self.density;
        Sprite::paint([-RADIUS - 1.0, -RADIUS - 1.0, RADIUS + 1.0, 112.0], density, |x, y| {
            let crown = disc(x, y, (0.0, 0.0), RADIUS);
            let (tip, half) = (82.0, lerp(57.0, 11.0, ((y - 24.0) / 58.0).clamp(0.0, 1.0)));
            let skirt = ((x.abs() - half) * 0.8).max(y - tip).max(24.0 - y);
            let envelope = crown.min(skirt);
            let half_width = if y > 24.0 { half } else { (RADIUS * RADIUS - y * y).max(1.0).sqrt() };
            let colour = self.silk((x / half_width).clamp(-1.0, 1.0), y, half_width, envelope);
            let wicker = rounded_box(x, y, (0.0, 103.0), (8.5, 6.5), 2.0);
            let weave = Noise(self.noise.0 ^ 0x33).fractal(x * 0.8, y * 1.6, 5.0, self.finest());
            let rim = ramp(0.6, -0.6, (y - 97.6).abs() - 1.4);
            let basket = shade(blend([150.0, 98.0, 54.0], [96.0, 58.0, 34.0], rim), 0.5 * weave);
            let ropes = [-1.0, 1.0].map(|s| bar(x, y, (s * 10.0, tip - 1.0), (s * 7.5, 97.0), 0.9, 0.9));
            let gear = ropes[0].min(ropes[1]);
            let colour = blend(colour, [84.0, 60.0, 48.0], ramp(0.4, -0.4, gear));
            let colour = blend(colour, basket, ramp(0.5, -0.5, wicker));
            (colour, envelope.min(wicker).min(gear))
        })
    }

    /// Returns the envelope's colour at `side` (-1 left edge, 1 right edge) and height `y`, where its half width is
    /// `half_width` units.
    fn silk(&self, side: f32, y: f32, half_width: f32, distance: f32) -> Colour {
        const GORES: [Colour; 4] =
            [[222.0, 74.0, 58.0], [248.0, 206.0, 92.0], [240.0, 236.0, 222.0], [36.0, 122.0, 142.0]];
        // The seams of sixteen gores, eight of them visible, are at the sines of equal angles.
        let seam = |k: i32| sin_turns(f64::from(k - 4) / 16.0) as f32;
        let soften = (0.7 / (half_width * self.density)).max(0.004);
        let mut colour = GORES[0];
        let mut stitch = 0.0_f32;
        for k in 1..8 {
            colour = blend(colour, GORES[(k as usize * 3) % 4], ramp(seam(k) - soften, seam(k) + soften, side));
            stitch = stitch.max(ramp(2.2 * soften, 0.6 * soften, (side - seam(k)).abs()));
        }
        let band = |middle: f32, half: f32| ramp(0.7, -0.7, (y - middle + 9.0 * side * side).abs() - half);
        let zigzag = (side * 8.0 - (side * 8.0).floor() - 0.5).abs() * 9.0;
        let colour = blend(colour, [52.0, 60.0, 104.0], band(4.0 + zigzag, 4.5));
        let colour = blend(colour, [246.0, 240.0, 226.0], band(15.0 + zigzag, 2.2));
        let colour = blend(colour, [52.0, 60.0, 104.0], band(-44.0, 3.0).max(ramp(66.0, 67.5, y)));
        let cloth = Noise(self.noise.0 ^ 0x55).fractal(side * half_width, y, 24.0, self.finest());
        let light = 0.13 - 0.30 * side - 0.30 * side * side - 0.0022 * y - 0.16 * ramp(-2.5, 0.0, distance);
        shade(colour, light + 0.17 * cloth - 0.24 * stitch)
    }

    fn add_van(&self, scene: &mut Scene) {
        let van = scene.add_sprite(self.van());
        let size = Affine::scaling(VAN_SCALE, VAN_SCALE);
        scene.add_layer(van, 2, |t| size.then(&self.pose(212.0 - self.drift(t, 3.7), 212.0 - self.tilt(t))));
    }

    /// Paints a camper van that drives to the left; the origin is on the road below its middle.
    fn van(&self) -> Sprite {
        let noise = Noise(self.noise.0 ^ 0x99);
        let density = VAN_SCALE as f32 * self.density;
        Sprite::paint([-33.0, -42.0, 33.0, 1.0], density, |x, y| {
            let crisp = |d: f32| ramp(0.55, -0.55, d * density.min(1.6));
            let body = rounded_box(x, y, (0.0, -18.5), (31.0, 13.5), 6.0);
            let luggage = rounded_box(x, y, (4.0, -34.5), (15.0, 3.4), 1.5);
            let trunk = rounded_box(x, y, (-3.0, -37.0), (6.0, 3.0), 1.5);
            let wheels = [-18.0, 18.0].map(|cx| disc(x, y, (cx, -6.0), 6.0));
            let tyre = wheels[0].min(wheels[1]);
            let worn = noise.fractal(x, y, 11.0, self.finest());
            // Cream above and orange below a white belt that dips to a V at the front.
            let belt = y + 16.0 - 7.0 * ramp(-14.0, -31.0, x);
            let paint = blend([240.0, 226.0, 196.0], [226.0, 98.0, 44.0], crisp(-belt));
            let paint = blend(paint, [252.0, 250.0, 244.0], crisp(belt.abs() - 1.1));
            let paint = shade(paint, 0.16 * worn + 0.12 - 0.012 * (y + 32.0) - 0.2 * ramp(-2.0, 0.0, body));
            let panes = [-23.0, -9.5, 4.5, 19.0].map(|cx| rounded_box(x, y, (cx, -23.5), (5.6, 4.3), 1.4));
            let glass = panes.iter().copied().fold(f32::MAX, f32::min);
            let glare = 0.8 * ramp(0.35, 0.6, ((x + y) / 14.0 - ((x + y) / 14.0).floor() - 0.5).abs() * 2.0);
            let paint = blend(paint, shade([54.0, 78.0, 98.0], glare + 0.3 * worn), crisp(glass));
            let lamp = disc(x, y, (-28.4, -12.0), 2.6);
            let paint = blend(paint, [255.0, 244.0, 190.0], crisp(lamp));
            let bumper = rounded_box(x, y, (0.0, -6.4), (32.0, 1.5), 1.5);
            let paint = blend(paint, [206.0, 208.0, 206.0], crisp(bumper));
            let door = ((x - 11.7).abs() - 0.5).max(y + 9.0).max(-28.0 - y);
            let paint = shade(paint, -0.35 * crisp(door));
            let bags = blend([98.0, 66.0, 46.0], [64.0, 112.0, 96.0], crisp(trunk.min(x - 10.0)));
            let bags = shade(bags, 0.5 * worn - 0.3 * crisp((x - 2.0).abs() - 0.8));
            let colour = blend(bags, paint, crisp(body.min(bumper)));
            let hub = (tyre + 3.2).max(-6.0);
            let rubber = blend([40.0, 40.0, 44.0], [214.0, 210.0, 200.0], crisp(hub));
            let colour = blend(colour, rubber, crisp(tyre));
            (colour, body.min(luggage).min(trunk).min(tyre).min(bumper))
        })
    }
}
