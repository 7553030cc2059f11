// Pictures and optical flow at the size of masks, which may be another.

import { TraceCutError } from '../../check/errors.js';
import type { FlowField } from '../../session/engine.js';

/** The pixels of a frame: RGBA bytes, row by row. */
export type Picture = { data: Uint8Array | Uint8ClampedArray; width: number; height: number };

export type FlowBetween = (from: Picture, to: Picture) => Promise<FlowField>;

export type Size = { width: number; height: number };

export function checkPicture(picture: Picture, t: number): Picture {
  const { data, width, height } = picture ?? {};
  if (!data || data.length !== 4 * width * height)
    throw new TraceCutError('data', `picture(${t}) is no {data, width, height} of RGBA bytes`);
  return picture;
}

/** Returns the place of each pixel. */
export function createPlaces({ width, height }: Size): { x: Float32Array; y: Float32Array } {
  const [x, y] = [new Float32Array(width * height), new Float32Array(width * height)];
  for (let p = 0; p < x.length; p += 1) [x[p], y[p]] = [p % width, Math.floor(p / width)];
  return { x, y };
}

/** Returns the flow at a place, in pixels of the masks. */
export function readFlow(flow: FlowField, x: number, y: number, { width, height }: Size): [number, number] {
  const [sx, sy] = [flow.width / width, flow.height / height];
  const column = Math.max(0, Math.min(flow.width - 1, Math.floor((x + 0.5) * sx)));
  const row = Math.max(0, Math.min(flow.height - 1, Math.floor((y + 0.5) * sy)));
  const f = row * flow.width + column;
  return [Number(flow.u[f]) / sx, Number(flow.v[f]) / sy];
}

/** Returns the pixel at a place; -1 outside of the frame. */
export function findPixel(x: number, y: number, { width, height }: Size): number {
  const [column, row] = [Math.floor(x + 0.5), Math.floor(y + 0.5)];
  return column >= 0 && row >= 0 && column < width && row < height ? row * width + column : -1;
}

/** Returns the colours of a picture at the size of the masks: of each pixel the mean over nine pixels of the picture. */
export function readColours({ data, width: w, height: h }: Picture, { width, height }: Size): Float32Array {
  const colours = new Float32Array(3 * width * height);
  for (let p = 0; p < width * height; p += 1) {
    const x = Math.floor((((p % width) + 0.5) * w) / width);
    const y = Math.floor(((Math.floor(p / width) + 0.5) * h) / height);
    let count = 0;
    for (let j = Math.max(0, y - 1); j <= Math.min(h - 1, y + 1); j += 1) {
      for (let i = Math.max(0, x - 1); i <= Math.min(w - 1, x + 1); i += 1) {
        for (let c = 0; c < 3; c += 1) colours[3 * p + c]! += Number(data[4 * (j * w + i) + c]);
        count += 1;
      }
    }
    for (let c = 0; c < 3; c += 1) colours[3 * p + c]! /= count;
  }
  return colours;
}
