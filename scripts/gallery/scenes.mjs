// The scenes of the gallery: each says how large it is, how long, and paints any of its frames.

import { Canvas, blend, clamp, clouds, hash, lit, mix, noise, pictureOf, ramp } from './paint.mjs';
import { ball, balloon, boat, bus, car, hedge, ladybird, tree, walker } from './things.mjs';

/**
 * @typedef {object} Scene
 * @property {string} id
 * @property {number} frames
 * @property {number} objects that are to be found in it, at least
 * @property {number} poster the frame that is shown of it
 * @property {() => (t: number) => Canvas} open what paints a frame
 */

export const SIZE = { width: 480, height: 270 };
export const FRAME_RATE = 16;

const canvas = () => new Canvas(SIZE.width, SIZE.height);

/** Sky with clouds. */
const sky = (x, y, low, seed, size = 1) => {
  const cloud = ramp(0.4 * size ** 0.5, 0.75, clouds(x / (70 * size), y / (34 * size), seed, 5));
  return blend(blend([92, 148, 204], [216, 226, 224], ramp(0, low, y)), [250, 247, 240], 0.9 * cloud);
};

const grass = (x, y, seed, size = 1) =>
  lit(
    blend([70, 104, 44], [150, 156, 76], clouds(x / 60, y / 36, seed, 3)),
    0.62 + 0.75 * clouds(x / (9 * size), y / (5 * size), seed + 3, 4),
  );

/** The camera pans along a coast; two boats sail against each other, a balloon rises. */
function coast() {
  const hill = (x) => 84 - 46 * clouds(x / 150, 0, 21, 4);
  const place = (x, y) => {
    if (y < hill(x)) return sky(x, y, 110, 11);
    if (y < 96) return lit(grass(x, 2 * y, 12), mix(0.75, 1.1, clouds(x / 24, y / 12, 13, 4)));
    const wave = clouds(x / 15, 26 * Math.log(y - 78), 14, 4);
    if (y < 222 + 12 * noise(x / 60, 1, 15)) return lit([44, 112, 138], mix(0.55, 1.55, wave));
    return lit([214, 190, 142], 0.6 + 0.7 * clouds(x / 12, y / 7, 16, 5) - (hash(x, y, 17) > 0.985 ? 0.3 : 0));
  };
  const scene = pictureOf(760, SIZE.height, place);
  const [red, blue, air] = [
    boat([178, 54, 46], [246, 236, 214]),
    boat([36, 62, 122], [244, 196, 84]),
    balloon([214, 84, 50], [248, 186, 70]),
  ];
  return (t) => {
    const frame = canvas();
    const pan = 3 * t;
    frame.lay(scene, { x: 379.5 - pan, y: 134.5 });
    frame.lay(air, { x: 250 - 0.8 * t, y: 66 - 0.4 * t, size: 0.52 });
    frame.lay(blue, {
      x: 424 - 4.7 * t,
      y: 146 + 1.2 * Math.sin(t / 5),
      size: 0.72,
      flip: true,
      turn: 0.03 * Math.sin(t / 6),
    });
    frame.lay(red, { x: 90 + 1.4 * t, y: 172 + 1.6 * Math.sin(t / 6 + 1), size: 1, turn: 0.04 * Math.sin(t / 7) });
    return frame;
  };
}

/** The fronts of houses, a pavement, a road. */
function houses(x, y) {
  const house = Math.floor(x / 96);
  const wall = [
    [196, 150, 118],
    [176, 178, 158],
    [206, 184, 132],
    [150, 122, 112],
    [188, 168, 158],
  ][((house % 5) + 5) % 5];
  const [u, v] = [x - 96 * house, y];
  const isWindow = Math.abs(((u + 4) % 32) - 18) < 8 && Math.abs(((v + 8) % 54) - 34) < 15 && v < 140;
  const isDoor = v > 112 && Math.abs(u - 48) < 11;
  if (isDoor && v < 160) return lit([86, 62, 46], 0.7 + 0.6 * clouds(x / 4, y / 20, house, 3));
  if (isWindow) return blend([44, 58, 72], [150, 178, 190], clouds(x / 16, y / 20, 31, 3));
  const brick = hash(Math.floor((x + 5 * (Math.floor(y / 5) % 2)) / 10), Math.floor(y / 5), house + 40);
  return lit(wall, 0.66 + 0.25 * brick + 0.3 * clouds(x / 20, y / 20, 32, 4));
}

function streetPlace(x, y) {
  if (y < 160) return houses(x, y);
  if (y < 182)
    return lit(
      [172, 166, 156],
      0.62 + 0.28 * hash(Math.floor(x / 22), Math.floor(y / 8), 33) + 0.35 * clouds(x / 8, y / 4, 34, 4),
    );
  if (y < 187) return [126, 122, 116];
  if (Math.abs(y - 220) < 2 && ((x % 60) + 60) % 60 < 34) return [226, 220, 200];
  return lit([98, 98, 102], 0.62 + 0.75 * clouds(x / 9, y / 4, 35, 5));
}

/** The camera stands still in a street: a bus, a car and somebody on foot. */
function street() {
  const scene = pictureOf(SIZE.width, SIZE.height, streetPlace);
  const steps = Array.from({ length: 20 }, (_, k) => walker((k / 20) * 2 * Math.PI, [206, 168, 60], [52, 66, 98]));
  const [red, coach] = [car([186, 46, 40]), bus([48, 122, 128])];
  return (t) => {
    const frame = canvas();
    frame.lay(scene, { x: 239.5, y: 134.5 });
    const [bx, cx, wx] = [440 - 4.4 * t, 30 + 5.2 * t, 130 + 2.2 * t];
    frame.shade(wx, 180, 24, 5);
    frame.lay(steps[(2 * t) % 20], { x: wx, y: 138, size: 0.8 });
    frame.shade(bx, 204, 96, 9);
    frame.lay(coach, { x: bx, y: 166, size: 1, flip: true });
    frame.shade(cx, 255, 74, 9);
    frame.lay(red, { x: cx, y: 226, size: 1.15 });
    return frame;
  };
}

/** Flagstones with moss between them. */
function stones(x, y) {
  const row = Math.floor((y + 30 + 3 * noise(x / 30, 1, 50)) / 62);
  const along = x + 40 * (row % 2) + 4 * noise(y / 20, row, 51);
  const column = Math.floor(along / 84);
  const gap = Math.min((along / 84 - column) * 84, y + 30 + 3 * noise(x / 30, 1, 50) - 62 * row);
  const rough = clouds(x / 9, y / 9, 52, 5);
  if (gap < 4) return lit([92, 112, 66], 0.5 + 0.9 * rough);
  const stone = blend([172, 160, 142], [196, 176, 148], hash(column, row, 53));
  const lichen = ramp(0.56, 0.68, clouds(x / 26, y / 26, 54, 4));
  return lit(blend(stone, [150, 158, 116], 0.7 * lichen), 0.5 + 0.85 * rough - (hash(x, y, 55) > 0.98 ? 0.25 : 0));
}

/** Two ladybirds walk side by side, then go different ways. */
function parting() {
  const scene = pictureOf(SIZE.width, SIZE.height, stones);
  const [one, two] = [ladybird([206, 48, 32]), ladybird([232, 158, 40])];
  const way = (t, side) => {
    const bend = 0.75 * ramp(20, 42, t);
    let [x, y] = [60, 134 + 34 * side];
    for (let k = 0; k < t; k += 1) {
      const turn = side * 0.75 * ramp(20, 42, k);
      x += 5.2 * Math.cos(turn);
      y += 5.2 * Math.sin(turn);
    }
    return { x, y, turn: side * bend + 0.05 * Math.sin(1.3 * t + side) };
  };
  return (t) => {
    const frame = canvas();
    frame.lay(scene, { x: 239.5, y: 134.5 });
    for (const [sprite, side] of [
      [one, -1],
      [two, 1],
    ]) {
      const place = way(t, side);
      frame.shade(place.x + 2, place.y + 3, 32, 27, 0.4);
      frame.lay(sprite, { ...place, size: 0.85 });
    }
    return frame;
  };
}

/** Where the ground ends, and how many pixels a unit of the ground has at the distance of one. */
const [HORIZON, FOCUS] = [112, 150];

/** A road through meadows, to the left and right of the middle, `gone` units further than at first. */
function road(x, y, gone) {
  const far = FOCUS / (y - HORIZON + 0.5);
  const [gx, gz] = [((x - 240) * far) / FOCUS, far + gone];
  const fine = mix(clouds(gx * 7, gz * 4, 62, 4), 0.5, ramp(4, 14, far));
  const wide = clouds(gx * 1.1, gz * 0.7, 63, 3);
  if (Math.abs(gx) < 0.85) return lit([186, 168, 136], 0.55 + 0.45 * fine + 0.4 * wide);
  return lit(blend([74, 108, 46], [160, 158, 78], wide), 0.5 + 0.95 * fine);
}

/** What is above the ground, a little larger with time. */
function distance(x, y, zoom) {
  const [sx, sy] = [240 + (x - 240) / zoom, HORIZON + (y - HORIZON) / zoom];
  const hill = HORIZON - 26 * clouds(sx / 120, 3, 64, 4);
  if (sy < hill) return sky(sx, sy, 110, 65, 0.45);
  return lit([108, 124, 108], 0.55 + 0.85 * clouds(sx / 9, sy / 6, 66, 4));
}

/** Trees on both sides of the road, the farthest first. */
function avenue() {
  const greens = [
    [86, 118, 54],
    [110, 126, 52],
    [66, 104, 60],
    [128, 120, 56],
  ];
  const one = (k) => ({
    side: (k % 2 ? 1 : -1) * (3.4 + 3 * hash(k, 1, 61)),
    far: 5 + 1.7 * k,
    sprite: tree(70 + (k % 4), greens[k % 4]),
  });
  return Array.from({ length: 14 }, (_, k) => one(13 - k));
}

/** The camera goes forward along a road through meadows: a car crosses ahead, a balloon drifts by. */
function forward() {
  const trees = avenue();
  const [van, air] = [car([198, 60, 44]), balloon([66, 96, 176], [236, 206, 96])];
  /** Lays something on the ground: how far to the side and ahead, how large, and how high its middle is. */
  const stand = (frame, sprite, side, depth, size, middle) =>
    frame.lay(sprite, { x: 240 + (FOCUS * side) / depth, y: HORIZON + FOCUS / depth - middle * size, size });
  return (t) => {
    const frame = canvas();
    const gone = 0.05 * t;
    frame.fill((x, y) => (y > HORIZON ? road(x, y, gone) : distance(x, y, 1 + 0.0012 * t)));
    for (const { side, far, sprite } of trees) stand(frame, sprite, side, far - gone, 2.6 / (far - gone), 74);
    frame.lay(air, { x: 384 - 2 * t, y: 62 - 0.3 * t, size: 0.55 });
    const depth = 6.5 - gone;
    const [side, size] = [-1.1 * depth + 0.13 * t, 5.2 / depth];
    frame.shade(240 + (FOCUS * side) / depth, HORIZON + FOCUS / depth, 62 * size, 7 * size);
    stand(frame, van, side, depth, size, 26);
    return frame;
  };
}

/** The camera follows a ball across a lawn, not quite as fast. */
function kicked() {
  const lawn = (x, y) => {
    const fence = y < 70;
    if (y < 26) return sky(x, y, 60, 81);
    if (fence)
      return lit(
        [132, 98, 66],
        (((x % 22) + 22) % 22 < 2 ? 0.4 : 1) * (0.55 + 0.8 * clouds(x / 6, y / 26, 82 + Math.floor(x / 22), 3)),
      );
    const daisy = hash(Math.floor(x / 5), Math.floor(y / 4), 83) > 0.985;
    return daisy ? [244, 240, 220] : grass(x, 190 * Math.log(1 + y / 150), 84);
  };
  const scene = pictureOf(760, SIZE.height, lawn);
  const sprite = ball();
  return (t) => {
    const frame = canvas();
    const pan = 2.6 * t;
    const x = 40 + 6.2 * t;
    const high = 62 * Math.abs(Math.sin((Math.PI * (t + 8)) / 22)) * 0.93 ** (t / 4);
    frame.lay(scene, { x: 379.5 - pan, y: 134.5 });
    frame.shade(x, 226, 20 - high / 12, 6, 0.5);
    frame.lay(sprite, { x, y: 208 - high, size: 0.8, turn: 0.09 * t });
    return frame;
  };
}

/** A car passes behind a hedge, somebody on foot before it. */
function behind() {
  const wood = (x, y) => {
    if (y > 214) return grass(x, y, 91, 0.8);
    if (y > 176) return lit([168, 150, 120], 0.6 + 0.6 * clouds(x / 10, y / 5, 92, 4));
    const trunks = clouds(x / 9, y / 160, 93, 3);
    return blend(
      lit([96, 122, 70], 0.45 + 0.95 * clouds(x / 14, y / 12, 94, 5)),
      [76, 62, 50],
      0.75 * ramp(0.58, 0.66, trunks),
    );
  };
  const scene = pictureOf(SIZE.width, SIZE.height, wood);
  const green = hedge(SIZE.width, 60, 95);
  const [blue] = [car([52, 96, 176])];
  const steps = Array.from({ length: 20 }, (_, k) => walker((k / 20) * 2 * Math.PI, [190, 70, 58], [64, 58, 84]));
  return (t) => {
    const frame = canvas();
    frame.lay(scene, { x: 239.5, y: 134.5 });
    const [cx, wx] = [80 + 4.2 * t, 450 - 2.6 * t];
    frame.shade(cx, 200, 80, 8);
    frame.lay(blue, { x: cx, y: 164, size: 1.3 });
    frame.lay(green, { x: 239.5, y: 198 });
    frame.shade(wx, 253, 34, 6);
    frame.lay(steps[(2 * t) % 20], { x: wx, y: 185, size: 1.25, flip: true });
    return frame;
  };
}

/** @type {Scene[]} */
export const SCENES = [
  { id: 'coast', frames: 50, objects: 3, poster: 30, open: coast },
  { id: 'street', frames: 50, objects: 3, poster: 34, open: street },
  { id: 'parting', frames: 50, objects: 2, poster: 44, open: parting },
  { id: 'forward', frames: 50, objects: 2, poster: 30, open: forward },
  { id: 'ball', frames: 50, objects: 1, poster: 20, open: kicked },
  { id: 'hedge', frames: 50, objects: 2, poster: 18, open: behind },
];
