// What moves in the gallery's clips, and what stands in its way, as sprites.

import { any, blend, both, box, clouds, ellipse, hash, limb, lit, mix, polygon, ramp, spriteOf } from './paint.mjs';

/** A colour that is lighter above and darker below. */
const round = (colour, top, bottom) => (x, y) => lit(colour, mix(1.15, 0.7, ramp(top, bottom, y)));

const wheel = (x, y, r) => [
  [ellipse(x, y, r), [34, 33, 36]],
  [ellipse(x, y, 0.55 * r), [168, 170, 176]],
  [ellipse(x, y, 0.2 * r), [60, 60, 66]],
];

const glass = (x, y) => blend([58, 84, 104], [176, 206, 220], ramp(0, 1, clouds(x / 18, y / 9, 4, 2)));

/** A car from its side, driving right. */
export function car(paint) {
  const stripe = blend(paint, [245, 240, 225], 0.75);
  return spriteOf(120, 60, [
    [box(60, 37, 56, 12, 8), round(paint, 22, 50)],
    [polygon([24, 28], [36, 9], [78, 9], [96, 28]), round(paint, 4, 34)],
    [polygon([32, 26], [40, 12.5], [55, 12.5], [55, 26]), glass],
    [polygon([60, 26], [60, 12.5], [75, 12.5], [87, 26]), glass],
    [box(60, 38, 54, 2.2, 2), stripe],
    [box(57.5, 37, 0.7, 9), lit(paint, 0.5)],
    [box(112, 33, 3, 3, 2), [255, 240, 180]],
    [box(7, 33, 2.5, 4, 2), [190, 40, 36]],
    ...wheel(29, 47, 11),
    ...wheel(91, 47, 11),
  ]);
}

/** A bus from its side. */
export function bus(paint) {
  const windows = [0, 1, 2, 3, 4, 5].map((k) => [box(25 + 26 * k, 29, 10.5, 11, 3), glass]);
  return spriteOf(182, 88, [
    [box(91, 42, 87, 34, 9), round(paint, 4, 80)],
    [
      box(91, 56, 86, 7, 1),
      (x, y) => blend([240, 232, 210], paint, hash(Math.floor(x / 9), Math.floor(y / 7), 1) * 0.6),
    ],
    [box(91, 11, 80, 2, 1), lit(paint, 0.6)],
    ...windows,
    [box(174, 45, 2.5, 24, 1), [40, 44, 52]],
    ...wheel(41, 72, 12.5),
    ...wheel(140, 72, 12.5),
  ]);
}

/** Somebody walking right, at a phase of the step. */
export function walker(phase, coat, trousers) {
  const swing = Math.sin(phase);
  const leg = (by, colour) => {
    const knee = [32 + 9 * by + 2, 78];
    const foot = [32 + 19 * by - (by < 0 ? 3 : 0), 104];
    return [
      [any(limb(32, 58, ...knee, 6.5, 5.2), limb(...knee, ...foot, 5.2, 4)), colour],
      [limb(foot[0] - 1, 105, foot[0] + 7, 106, 3.6), [48, 36, 30]],
    ];
  };
  const arm = (by, colour) => [
    [any(limb(32, 32, 32 - 10 * by, 47, 4.6), limb(32 - 10 * by, 47, 36 - 14 * by, 60, 4)), colour],
  ];
  const check = (x, y) => lit(coat, 0.8 + 0.4 * hash(Math.floor(x / 5), Math.floor(y / 5), 2));
  return spriteOf(
    64,
    112,
    [
      ...arm(-swing, lit(coat, 0.7)),
      ...leg(-swing, lit(trousers, 0.75)),
      ...leg(swing, trousers),
      [box(32, 43, 12, 20, 9), check],
      [ellipse(33, 15, 8.5, 9.5), [224, 178, 148]],
      [both(ellipse(32, 13, 9.5, 10), box(30, 8, 10, 6, 3)), [70, 44, 30]],
      [box(20, 42, 6, 13, 5), (x, y) => lit([58, 110, 92], 0.8 + 0.5 * hash(Math.floor(x / 4), Math.floor(y / 4), 8))],
      ...arm(swing, lit(coat, 0.9)),
    ],
    0.3,
  );
}

/** A sailing boat. */
export function boat(hull, sail) {
  const cloth = (x, y) =>
    lit(Math.floor((y + 0.25 * x) / 13) % 3 === 0 ? hull : sail, 0.8 + 0.35 * clouds(x / 22, y / 30, 6, 2));
  return spriteOf(110, 130, [
    [box(56, 62, 1.6, 48), [92, 66, 44]],
    [polygon([60, 14], [98, 96], [60, 98]), cloth],
    [polygon([53, 22], [53, 96], [18, 96]), (x, y) => lit(cloth(x, y), 0.9)],
    [both(polygon([8, 102], [104, 102], [90, 124], [24, 124])), round(hull, 98, 126)],
    [both(box(56, 107, 46, 1.8), polygon([8, 102], [104, 102], [90, 124], [24, 124])), [244, 238, 220]],
  ]);
}

/** A hot-air balloon. */
export function balloon(first, second) {
  const cloth = (x, y) => {
    const across = Math.asin(
      Math.max(-1, Math.min(1, (x - 60) / (4 + Math.sqrt(Math.max(1, 54 ** 2 - (y - 58) ** 2))))),
    );
    const colour = Math.floor(across * 2.6 + 100) % 2 === 0 ? first : second;
    const band = Math.abs(y - 60 - 4 * Math.sin(x / 4)) < 5 ? [250, 240, 214] : colour;
    return lit(band, 1.1 - 0.35 * ramp(-0.4, 1.5, across));
  };
  return spriteOf(120, 160, [
    [any(ellipse(60, 58, 54), polygon([14, 84], [106, 84], [70, 128], [50, 128])), cloth],
    [any(limb(52, 126, 53, 140, 0.9), limb(68, 126, 67, 140, 0.9)), [80, 60, 44]],
    [box(60, 146, 10, 8, 3), (x, y) => lit([150, 98, 54], 0.75 + 0.5 * hash(Math.floor(x / 3), Math.floor(y / 3), 4))],
  ]);
}

/** A ladybird from above, heading right. */
export function ladybird(shell) {
  const dots = [
    [38, 18],
    [38, 46],
    [56, 13],
    [56, 51],
    [27, 27],
    [27, 37],
    [48, 28],
    [48, 36],
  ];
  const legs = [34, 50, 62].flatMap((x) => [limb(x, 32, x + 5, 4, 2.2, 1.4), limb(x, 32, x + 5, 60, 2.2, 1.4)]);
  const back = (x, y) => lit(shell, 1.15 - 0.5 * ramp(6, 34, Math.hypot(x - 40, y - 27)));
  return spriteOf(84, 64, [
    [any(...legs), [30, 26, 26]],
    [ellipse(70, 32, 10, 12), [36, 32, 34]],
    [any(ellipse(75, 25, 3), ellipse(75, 39, 3)), [236, 230, 214]],
    [ellipse(44, 32, 28, 25), back],
    [any(...dots.map(([x, y]) => ellipse(x, y, 4.6))), [28, 22, 24]],
    [box(42, 32, 27, 0.7), [60, 20, 20]],
  ]);
}

/** A ball of patches. */
export function ball() {
  const seen = (x, y) => {
    const [u, v] = [(x - 24) / 22, (y - 24) / 22];
    const bulge = 1 / Math.sqrt(Math.max(0.15, 1.05 - u * u - v * v));
    const dark = Math.sin(3.1 * u * bulge) * Math.cos(3.4 * v * bulge) > 0.12;
    return lit(dark ? [208, 74, 46] : [246, 240, 226], 1.08 - 0.45 * ramp(0, 1.6, u + v + 0.7));
  };
  return spriteOf(48, 48, [[ellipse(23.5, 23.5, 22), seen]], 0.15);
}

/** A tree with a round crown. */
export function tree(seed, green) {
  const crown = [];
  for (let k = 0; k < 11; k += 1)
    crown.push(
      ellipse(
        60 + 34 * (hash(k, 1, seed) - 0.5) * 2,
        50 + 26 * (hash(k, 2, seed) - 0.5) * 2,
        17 + 9 * hash(k, 3, seed),
      ),
    );
  const leaves = (x, y) => lit(green, mix(0.5, 1.35, clouds(x / 9, y / 9, seed, 4)) * mix(1.15, 0.75, ramp(10, 90, y)));
  return spriteOf(120, 150, [
    [limb(60, 70, 60, 146, 5, 8), (x, y) => lit([104, 78, 56], 0.7 + 0.6 * clouds(x / 3, y / 14, seed, 2))],
    [any(...crown), leaves],
  ]);
}

/** A hedge as wide as the frame, its top cut by nobody for a while. */
export function hedge(width, height, seed) {
  const top = (x, y) => 8 + 18 * clouds(x / 34, 1, seed, 3) - y;
  const leaves = (x, y) =>
    lit([72, 104, 44], mix(0.35, 1.6, clouds(x / 6, y / 6, seed + 1, 4)) * mix(1.2, 0.7, ramp(8, 60, y)));
  return spriteOf(width, height, [[top, leaves]]);
}
