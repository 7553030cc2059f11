/**
 * What a layer of the viewer is, and what it may look at.
 * @module
 */

/** @typedef {import('./points.js').Points} Points */

/**
 * What a layer may look at while it draws. The context's unit is one pixel of the clip and its origin the centre of the
 * first one: a point of the result is drawn at its own coordinates, a picture of the frame from (-0.5, -0.5).
 *
 * @typedef {object} View
 * @property {Points | null} points the result by frame; null before there is one
 * @property {CanvasImageSource | null} image the frame itself, at clip size
 * @property {number} frame
 * @property {number} width of the clip in pixels
 * @property {number} height
 * @property {number} unit clip pixels in one CSS pixel: line widths times this look the same at every zoom
 * @property {(cluster: number) => boolean} visible
 * @property {(frame: number) => Promise<Flow>} flow asks the session for a flow field
 * @property {() => void} redraw asks for another `draw`, when something that was missing has come
 */

/** @typedef {{width: number, height: number, u: Float32Array, v: Float32Array}} Flow Motion in clip pixels per frame. */

/**
 * A number that the user may change, shown as a slider.
 *
 * @typedef {object} Setting
 * @property {string} name
 * @property {number} value
 * @property {number} min
 * @property {number} max
 * @property {number} step
 * @property {(value: number) => string} text
 */

/**
 * @typedef {object} Layer
 * @property {string} id
 * @property {string} name
 * @property {string} about one sentence on what the layer shows
 * @property {number} z layers with larger z are drawn over those with smaller
 * @property {boolean} on
 * @property {Record<string, Setting>} settings each layer has at least `opacity`
 * @property {() => Node[]} legend
 * @property {(ctx: CanvasRenderingContext2D, view: View) => void} draw
 * @property {() => void} [reset] forgets everything about the last result
 * @property {() => void} [changed] set by the panel: the layer calls it when its legend has new figures
 */

/**
 * @param {number} [value] in 0..1
 * @returns {Setting}
 */
export function opacity(value = 1) {
  return { name: 'Opacity', value, min: 0, max: 1, step: 0.05, text: (v) => `${Math.round(v * 100)} %` };
}
