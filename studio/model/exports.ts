// The list of exports, in the order of the dialog, and those of files that are written at once: masks, data, pictures,
// the project. To add one, write a value of type Export (see export.ts) and list it here; the dialog knows them only
// through this type.

import { cocoRle, encodeImages, maskPng, masksZip, objectTable, objectTableCsv } from './library.js';
import * as videos from './export-video.js';
import { type Choice, type Export, labelsOf, masksOf, rateOf } from './export.js';
import { EXTENSION } from './look.js';
import { Packer, projectFile } from './work.js';
import type { TrajectoryPoints } from './library.js';

export const data: Export = {
  title: 'Data',
  about:
    'COCO run lengths for annotation tools; a table of objects; trajectories with their labels for the Moseg benchmark.',
  choices: [
    {
      id: 'coco',
      label: 'COCO JSON',
      file: () => 'coco.json',
      make: async (subject, work) => {
        const { objects, name } = subject;
        const coco = await cocoRle(await masksOf(subject, work), { objects, video: name, ...rateOf(subject) });
        return new Blob([JSON.stringify(coco)], { type: 'application/json' });
      },
    },
    {
      id: 'table',
      label: 'objects.csv',
      says: 'objects.csv: place, size and motion of the objects in each frame',
      file: () => 'objects.csv',
      make: async (subject, work) => {
        const { objects, points } = subject;
        const masks = await masksOf(subject, work);
        const trajectories = enlarged(points, masks.width / subject.masks.width, masks.height / subject.masks.height);
        const rows = await objectTable(masks, { trajectories, objects, ...rateOf(subject) });
        return new Blob([await objectTableCsv(rows)], { type: 'text/csv' });
      },
    },
    {
      id: 'tracks',
      label: 'tracks.dat',
      file: () => 'tracks.dat',
      make: async ({ tracks }) => new Blob([await tracks()], { type: 'text/plain' }),
    },
  ],
};

/** Points of trajectories in pixels of masks that are so much larger. */
function enlarged({ startFrame, offset, x, y }: TrajectoryPoints, across: number, down: number) {
  const by = (values: ArrayLike<number>, scale: number) =>
    Float32Array.from(values, (value) => (value + 0.5) * scale - 0.5);
  return { startFrame, offset, x: by(x, across), y: by(y, down) };
}

export const masks: Export = {
  title: 'Masks',
  about: 'PNG files, in colours',
  choices: [{ id: 'zip', label: 'ZIP', file: () => 'masks.zip', make: zip(false) }],
};

const objectMasks: Export = {
  title: 'Masks by object',
  about: 'A ZIP with a folder of black and white PNG files for each object. Times are in masks.json.',
  choices: [{ id: 'zip-objects', label: 'ZIP', file: () => 'objects.zip', make: zip(true) }],
};

const frameMask: Export = {
  title: 'Mask of this frame',
  about: 'One PNG in the colours of the page.',
  choices: [
    {
      id: 'png',
      label: 'PNG',
      says: 'Mask of this frame as PNG',
      file: ({ frame }) => `mask-${String(frame + 1).padStart(4, '0')}.png`,
      make: async (subject) => {
        const { frame, objects } = subject;
        const image = await subject.image(frame);
        const labels = (await labelsOf(subject, frame, image)).map((label) => (objects(label) ? label : 0));
        const { width, height } = image;
        const mask = { width, height, numFrames: 1, labels: () => labels };
        return new Blob([await maskPng(mask, 0)], { type: 'image/png' });
      },
    },
  ],
};

function zip(perObject: boolean): Choice['make'] {
  return async (subject, work) => {
    const { objects } = subject;
    const bytes = await masksZip(await masksOf(subject, work), {
      perObject,
      objects,
      ...work,
      ...rateOf(subject),
    });
    return new Blob([bytes], { type: 'application/zip' });
  };
}

export const images: Export = {
  title: 'Cut-out pictures',
  about:
    'The objects alone on nothing, for editors that want pictures. An animated PNG plays in browsers and chats as a GIF does.',
  choices: [
    stream('cutout-zip', 'ZIP of PNG files', 'cutout.zip', 'cutout', 'zip'),
    stream('cutout-apng', 'Animated PNG', 'cutout.png', 'cutout', 'apng'),
    stream('alpha-zip', 'Alpha alone, ZIP', 'alpha.zip', 'alpha', 'zip'),
  ],
};

function stream(id: string, label: string, file: string, style: 'cutout' | 'alpha', format: 'zip' | 'apng'): Choice {
  return {
    id,
    label,
    file: () => file,
    type: format === 'zip' ? 'application/zip' : 'image/png',
    make: (subject, work) => {
      const { masks, frames, objects, edges } = subject;
      const options = { style, format, objects, edges, ...work, ...rateOf(subject) };
      return encodeImages(masks, frames(work.signal), options);
    },
  };
}

export const project: Export = {
  title: 'Project',
  about: 'Masks, corrections and the clip itself in one file, which this page opens again.',
  choices: [
    {
      id: 'project',
      label: 'Project file',
      file: () => `project${EXTENSION}`,
      there: ({ source }) => Boolean(source.files),
      make: async ({ state }) => projectFile(await new Packer().pack(state, '')),
    },
  ],
};

/** What most people want: a choice each. */
export const FIRST: Export[] = [videos.transparentVideo, videos.greenVideo, videos.blurredVideo, masks];

/** The others, in the order of the dialog. */
export const otherExports = (background: Export): Export[] => [
  ...[videos.overlayVideo, videos.cutoutVideo, images, videos.maskVideo],
  ...[objectMasks, frameMask, background, data, project],
];
