// The stages of the method in order, each with its section of the paper, an explanation, and its parameters.
// Read it beside K. Fragkiadaki, G. Zhang, J. Shi, "Video Segmentation by Tracing Discontinuities in a Trajectory
// Embedding", CVPR 2012, and docs/method.md.

/**
 * @typedef {object} Stage
 * @property {string} id of its layer
 * @property {string} title
 * @property {string} section of the paper
 * @property {string} text
 * @property {string[]} groups of parameters
 * @property {import('tracecut').Stage[]} coreStages the core's names for it
 */

/** @type {readonly Stage[]} */
export const STAGES = [
  {
    id: 'frames',
    title: 'Frames',
    section: '',
    text: 'Each frame is drawn on a canvas, and the core reads the canvas. Frames larger than clip.maxSide are scaled down; all results are in pixels of the canvas.',
    groups: ['clip'],
    coreStages: [],
  },
  {
    id: 'flow',
    title: 'Optical flow',
    section: '2.1',
    text: 'The motion of each pixel to the next frame, from an inverse search on patches (DIS) and variational refinement. It is computed forward and backward: where the two disagree, the point is occluded.',
    groups: ['flow'],
    coreStages: ['flow'],
  },
  {
    id: 'trajectories',
    title: 'Trajectories',
    section: '2.1',
    text: 'Points on a grid follow the flow from frame to frame. A trajectory ends at occlusions and at motion boundaries; new ones start where none are near. Tails show the last eight frames.',
    groups: ['trajectory'],
    coreStages: ['trajectories'],
  },
  {
    id: 'embedding',
    title: 'Spectral embedding',
    section: '2.1',
    text: 'The affinity A of two trajectories is high unless their velocities differ in some frame. The leading eigenvectors V of P = D⁻¹A, where D holds the row sums of A, place trajectories that move alike close together. Ŵ = VΛVᵀ is the affinity in this embedding.',
    groups: ['affinity', 'embedding'],
    coreStages: ['affinities', 'embedding'],
  },
  {
    id: 'discontinuities',
    title: 'Discontinuities',
    section: '2.2',
    text: 'Delaunay edges join neighbouring trajectories. With the density δ, the largest Ŵ of a trajectory to any neighbour, an edge has the discontinuity d = 1 − Ŵ / max(δᵢ, δⱼ): near 1 on object boundaries and low inside, however large the object is.',
    groups: ['discontinuity'],
    coreStages: ['discontinuities'],
  },
  {
    id: 'saliency',
    title: 'Saliency and connectedness',
    section: '3',
    text: 'A pixel is salient if its motion relative to the camera is rare in its surroundings. The saliency s of a trajectory is the maximum over its points; s̄ is its mean over nearby trajectories in the embedding. A trajectory with s̄ above 0.5 is foreground. Trajectories in different connected components of the foreground lose their affinity, and embedding and discontinuities are computed again.',
    groups: ['saliency', 'connectedness'],
    coreStages: ['saliency', 'connectedness'],
  },
  {
    id: 'clusters',
    title: 'Clusters',
    section: '2.3',
    text: 'A rotation of the eigenvectors gives more clusters than there are objects. Clusters are then merged: in the paper if the mean discontinuity along their common border is low, by default if a weighted sum of evidence says that they are one object.',
    groups: ['discretize'],
    coreStages: ['clusters'],
  },
  {
    id: 'contours',
    title: 'Contours',
    section: '4.1',
    text: 'Pb is the probability that a pixel lies on a boundary, from changes of brightness, colour and texture in one frame. Line segments are fitted to its ridges.',
    groups: ['contour'],
    coreStages: [],
  },
  {
    id: 'superpixels',
    title: 'Gabriel superpixels',
    section: '4.1',
    text: 'The segments constrain a Delaunay triangulation of their end points. Of its other edges, those with an empty diametral circle (the Gabriel property) stay and bridge gaps in the contours. The rest are deleted, and the remaining edges enclose the superpixels.',
    groups: ['superpixel'],
    coreStages: ['superpixels'],
  },
  {
    id: 'cut',
    title: 'Gabriel cut',
    section: '4.2',
    text: 'One graph cut labels the superpixels of all frames. Trajectories in a superpixel vote (unary term); a change of label is cheap across strong contours and where few trajectories are shared with the next frame (pairwise terms). Not in the paper: evidence from the background, a second cut with the appearance of the objects, and borders refined to the pixel.',
    groups: ['cut', 'background', 'refine'],
    coreStages: ['cut', 'masks'],
  },
];
