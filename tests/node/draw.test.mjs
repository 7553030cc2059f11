// Drawing functions refuse wrong input before they draw. Pixels are tested in a browser (tests/browser/draw.spec.mjs).

import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as draw from '../../dist/draw.js';
import { drawLabels } from '../../dist/node/index.js';

const RESULT = {
  width: 40,
  height: 30,
  numFrames: 3,
  labels: () => new Uint8Array(40 * 30),
  trajectories: {
    count: 1,
    startFrame: Uint32Array.of(0),
    offset: Uint32Array.of(0, 3),
    x: Float32Array.of(5, 10, 15),
    y: Float32Array.of(12, 12, 12),
  },
  clusters: { count: 1, label: Uint32Array.of(1), object: Uint8Array.of(1) },
  edges: () => ({ i: new Uint32Array(), j: new Uint32Array(), d: new Float32Array() }),
};

/** A context that counts saved states; whatever is painted would be an error. */
function createContext() {
  const context = { numSaved: 0, canvas: { width: 40, height: 30 } };
  context.save = () => (context.numSaved += 1);
  context.restore = () => (context.numSaved -= 1);
  context.translate = () => {};
  context.drawImage = () => assert.fail('painted');
  return context;
}

const CALLS = [
  [(context) => drawLabels(context, RESULT, 3), 'param', /^t = 3 \(expected a whole number, 0\.\.=2\)/],
  [(context) => drawLabels(context, RESULT, 0, { opacity: 2 }), 'param', /^opacity = 2 \(expected a number, 0\.\.=1\)/],
  [
    (context) =>
      drawLabels(context, { ...RESULT, labels: () => new Uint8Array(1200).fill(1) }, 0, { colors: () => 'orange' }),
    'param',
    /^colour = "orange" \(expected #rrggbb\)/,
  ],
  [
    (context) => drawLabels(context, RESULT, 0, { fill: 1 }),
    'param',
    /^fill = 1 \(expected a known option; the options are opacity/,
  ],
  [() => drawLabels(null, RESULT, 0), 'param', /^context = null/],
  [(context) => draw.drawTrajectories(context, {}, 0), 'data', /^result = an Object/],
  [(context) => draw.drawTrajectories(context, RESULT, 0, { tail: -1 }), 'param', /^tail = -1/],
  [(context) => draw.drawTrajectories(context, RESULT, 0, { color: 3 }), 'param', /^color = 3/],
  [(context) => draw.drawDiscontinuities(context, RESULT, 0, { threshold: 'high' }), 'param', /^threshold = "high"/],
  [(context) => draw.drawSuperpixels(context, {}), 'data', /^superpixels = an Object/],
  [
    (context) => draw.drawSuperpixels(context, { label: [0], count: 1, width: 1, height: 1 }, { fill: 'mean' }),
    'param',
    /^image = undefined/,
  ],
  [
    (context) => draw.drawBoundaries(context, { width: 1, height: 1, pb: new Float32Array(2) }),
    'data',
    /^map = an Object/,
  ],
  [(context) => draw.drawCells(context, RESULT, 0, {}), 'param', /^color = undefined/],
  [(context) => draw.fitFrame(context, { width: 0, height: 1 }), 'param', /^frame = an Object/],
];

test('wrong input is refused with its name, and the context keeps its state', () => {
  for (const [call, code, message] of CALLS) {
    const context = createContext();
    assert.throws(() => call(context), { name: 'TraceCutError', code, message });
    assert.equal(context.numSaved, 0, String(call));
  }
});
