/**
 * What a layer of the viewer is, and what it may look at.
 * @module
 */

/** @typedef {import('../../model/points.js').Points} Points */

/** @typedef {import('../../model/answers.js').Answers} Answers */
/** @typedef {import('../../model/answers.js').Spot} Spot */

/** @typedef {CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D} Canvas2D */

/**
 * What a layer may look at while it draws. The context's unit is one pixel of the clip and its origin the centre of the
 * first one: a point of the result is drawn at its own coordinates, a picture of the frame from (-0.5, -0.5).
 *
 * @typedef {object} View
 * @property {Points | null} points the result by frame; null before there is one
 * @property {CanvasImageSource | null} image the frame itself, at clip size or larger
 * @property {number} frame
 * @property {number} width of the clip in pixels
 * @property {number} height
 * @property {number} unit clip pixels in one CSS pixel: line widths times this look the same at every zoom
 * @property {(object: number) => boolean} visible
 * @property {() => ReturnType<typeof import('../../model/library.js').adjustMask> | null} mask of the frame, its edges as
 *   they are wanted; null where there is none
 * @property {Answers} answers
 * @property {() => void} redraw asks for another `draw`, when something that was missing has come
 */

/**
 * A number that the user may change, shown as a slider, as a switch, or as a list of names.
 *
 * @typedef {object} Setting
 * @property {string} name
 * @property {number} value
 * @property {number} min
 * @property {number} max
 * @property {number} step
 * @property {(value: number) => string} text
 * @property {boolean} [toggle] it is 0 or 1
 * @property {string[]} [choices] it is the place of one of these names
 */

/**
 * @typedef {object} Layer
 * @property {string} id
 * @property {string} name
 * @property {string} key on the keyboard; of layers that share one only one can be there at a time
 * @property {'clip' | 'still'} [only] for which kind of source it is there; both if not said
 * @property {string} about one sentence on what the layer shows
 * @property {number} z layers with larger z are drawn over those with smaller
 * @property {boolean} on
 * @property {Record<string, Setting>} settings each layer has at least `opacity`
 * @property {() => Node[]} legend
 * @property {(ctx: Canvas2D, view: View) => void} draw
 * @property {(view: View, spot: Spot) => string} [readout] words about a place; empty for none
 * @property {() => void} [reset] forgets everything about the last result
 */

/**
 * @param {number} [value] in 0..1
 * @returns {Setting}
 */
export function opacity(value = 1) {
  return { name: 'Opacity', value, min: 0, max: 1, step: 0.05, text: (v) => `${Math.round(v * 100)} %` };
}

/**
 * @param {string} name
 * @param {boolean} on
 * @returns {Setting}
 */
export function toggle(name, on) {
  return {
    name,
    value: on ? 1 : 0,
    min: 0,
    max: 1,
    step: 1,
    text: (v) => (v > 0 ? 'on' : 'off'),
    toggle: true,
  };
}

/**
 * @param {string} name
 * @param {string[]} choices the first is chosen
 * @param {number} [value] or the one at this place
 * @returns {Setting}
 */
export function choice(name, choices, value = 0) {
  return { name, value, min: 0, max: choices.length - 1, step: 1, text: (v) => choices[v], choices };
}

/**
 * Draws as the package's helpers do, whose origin is the frame's upper left corner and not the centre of its first
 * pixel.
 *
 * @param {Canvas2D} ctx
 * @param {() => void} draw
 */
export function fromCorner(ctx, draw) {
  ctx.save();
  ctx.translate(-0.5, -0.5);
  draw();
  ctx.restore();
}
