import { TraceCutError } from './errors.js';
import { wholeNumber } from './options.js';
import { REQUESTS } from './requests.js';
import { tracksDat } from './tracks-dat.js';

/**
 * Point trajectories. The points of trajectory `i` are `offset[i]` to `offset[i + 1]` of `x` and `y`, in input pixels,
 * one for each of the consecutive frames from `startFrame[i]` on. `id[i]` is its number in the clip, which it keeps
 * from window to window.
 * @typedef {{count: number, startFrame: Uint32Array, offset: Uint32Array, x: Float32Array, y: Float32Array, id:
 *   Uint32Array}} TrajectoryList
 */

/**
 * A label for each trajectory, `0` to `count - 1`; 0 is the cluster with most points.
 * @typedef {{count: number, label: Uint32Array}} ClusterList
 */

/**
 * The spectral embedding: `dimensions` eigenvalues, largest first, and one row of as many numbers per trajectory.
 * @typedef {{dimensions: number, eigenvalues: Float64Array, vectors: Float32Array, converged: boolean, residual:
 *   number}} EmbeddingTable
 */

/**
 * Neighbour pairs with their discontinuities, and which of them are Delaunay edges of which frame.
 * @typedef {{i: Uint32Array, j: Uint32Array, d: Float32Array, frameOffset: Uint32Array, frameEdges: Uint32Array}}
 *   EdgeTable
 */

/**
 * Edges between trajectories `i` and `j`, with discontinuity `d` in 0 to 1.
 * @typedef {{i: Uint32Array, j: Uint32Array, d: Float32Array}} Edges
 */

/**
 * The objects of the masks: the highest label, for each cluster the label that it has in the masks (0 for the
 * background), and the labels of all objects, lowest first. Several clusters may be one object, or the background.
 * Labels run from 1 on without gaps, but not in later windows of a long clip and after corrections.
 * @typedef {{count: number, ofCluster: Uint8Array, labels: Uint8Array}} ObjectList
 */

/**
 * How much each trajectory stands out against what surrounds it, 0 to 1: `ofPoints`, the greatest saliency of the
 * pixels that it went over (the paper's s), and `inContext`, the mean of that over the trajectories that move like it
 * (s̄). `foreground` is 1 where s̄ is above `saliency.threshold`, else 0.
 * @typedef {{ofPoints: Float32Array, inContext: Float32Array, foreground: Uint8Array}} SaliencyTable
 */

/**
 * The connected pieces of the foreground: their number in each frame, and the piece of each trajectory point in its
 * frame (points as in `trajectories.x`), `0` to `count[t] - 1`. It is -1 for points that are in none: background, and
 * foreground too small to count.
 * @typedef {{count: Uint32Array, ofPoint: Int32Array}} ComponentTable
 */

/**
 * The scene of a frame without the objects, as RGBA bytes for `ImageData`: pixels of the background are the frame's own,
 * those behind objects come from the nearest frames that show them, as the camera moves. Alpha is 0 where none does,
 * else 255.
 * @typedef {import('./image.js').Grid & {data: Uint8ClampedArray<ArrayBuffer>}} Background
 */

/**
 * How much each pixel of a frame stands out against its surroundings, 0 to 1, row by row.
 * @typedef {import('./image.js').Grid & {saliency: Float32Array<ArrayBuffer>}} SaliencyMap
 */

/** What a run found. */
export class Result {
  #edges;
  #labels;
  #askMap;

  /**
   * @param {import('./engine.js').RawResult} raw
   * @param {import('./requests.js').AskMap} askMap
   */
  constructor(raw, askMap) {
    /** Width of the input in pixels. */
    this.width = raw.info.width;
    /** Height of the input in pixels. */
    this.height = raw.info.height;
    /** Number of frames. */
    this.numFrames = raw.info.numFrames;
    /** Point trajectories in input pixels. */
    this.trajectories = raw.trajectories;
    /** The label of each trajectory. */
    this.clusters = raw.clusters;
    /**
     * The simpler segmentation by thresholded discontinuities alone (`discontinuity.threshold`); strays are clusters.
     */
    this.thresholdClusters = raw.thresholdClusters;
    /** The embedding coordinates of each trajectory. */
    this.embedding = raw.embedding;
    /** Seconds spent in each stage. */
    this.seconds = raw.seconds;
    /** The objects of the masks; null when there are no masks (`clip.dense` off, or no frames). */
    this.objects = raw.objects;
    /**
     * How salient each trajectory is, and which are foreground; null for trajectories without frames, which have no flow.
     */
    this.saliency = raw.saliency;
    /** The connected pieces of the foreground in each frame; null for trajectories without frames. */
    this.components = raw.components;
    this.#edges = raw.edges;
    this.#labels = raw.labels;
    this.#askMap = askMap;
  }

  /**
   * The mask of frame `t`, a copy: one byte for each input pixel, row by row; 0 is the background, `1` to
   * `objects.count` are the objects.
   * @param {number} t
   * @returns {Uint8Array<ArrayBuffer>}
   */
  labels(t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    if (!this.#labels) throw without('masks', 'masks');
    const size = this.width * this.height;
    return this.#labels.slice(t * size, (t + 1) * size);
  }

  /**
   * The Gabriel superpixels of frame `t`, at the size that frames are processed at. They are fetched from the session,
   * which must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<import('./image.js').Superpixels>}
   */
  async superpixels(t) {
    return this.#map('superpixels', t);
  }

  /**
   * The scene of frame `t` without the objects, at the size that frames are processed at. The session makes it at each
   * call, by its masks of that time; it must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<Background>}
   */
  async background(t) {
    return this.#map('background', t);
  }

  /**
   * The boundary probability of frame `t`, at the size that frames are processed at. The session computes it at each
   * call; it must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<import('./image.js').BoundaryMap>}
   */
  async boundaries(t) {
    return this.#map('boundaries', t);
  }

  /**
   * How salient each pixel of frame `t` is, at the size that frames are processed at; the last frame is seen through
   * the flow that leads to it. The session computes it at each call; it must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<SaliencyMap>}
   */
  async saliencyMap(t) {
    return this.#map('saliencyMap', t);
  }

  /** @type {import('./requests.js').AskMap} */
  async #map(name, t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    const { called, from } = REQUESTS[name];
    const there = { frames: true, saliency: this.saliency, masks: this.#labels };
    if (!there[from]) throw without(called, from);
    return this.#askMap(name, t);
  }

  /**
   * The Delaunay edges of frame `t` with their discontinuities.
   * @param {number} t
   * @returns {Edges}
   */
  edges(t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    const { i, j, d, frameOffset, frameEdges } = this.#edges;
    const chosen = frameEdges.subarray(frameOffset[t], frameOffset[t + 1]);
    return {
      i: Uint32Array.from(chosen, (edge) => /** @type {number} */ (i[edge])),
      j: Uint32Array.from(chosen, (edge) => /** @type {number} */ (j[edge])),
      d: Float32Array.from(chosen, (edge) => /** @type {number} */ (d[edge])),
    };
  }

  /**
   * The trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track
   * its label and length and, line by line, `x y frame`.
   * @returns {string}
   */
  toTracksDat() {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames, label: this.clusters.label });
  }
}

/**
 * @param {string} what
 * @param {string} from what it is made from, which is not there
 */
function without(what, from) {
  const dense = from === 'masks' ? ', and clip.dense = true' : '';
  const needs = `frames, not trajectories alone${dense}`;
  return new TraceCutError('state', `this result has no ${what} (they need ${needs})`);
}
