// The list of exports, in the order of the dialog, and the exports of masks, data, images and projects. To add one,
// write a value of type Export (see export.ts) and list it here.

import { cocoRle, encodeImages, maskPng, masksZip, objectTable, objectTableCsv } from './library.js';
import * as videos from './export-video.js';
import { type Choice, type Export, resizeLabels, resizeMasks, frameRateOption } from './export.js';
import { PROJECT_EXTENSION } from './view-settings.js';
import { Packer, createProjectFile } from './project-file.js';
import type { TrajectoryPoints } from './library.js';

export const data: Export = {
  title: 'Data',
  about: 'COCO masks for annotation tools, a table of objects, and labelled trajectories for the Moseg benchmark.',
  choices: [
    {
      id: 'coco',
      label: 'COCO JSON',
      file: () => 'coco.json',
      make: async (subject, task) => {
        const { objects, name } = subject;
        const coco = await cocoRle(await resizeMasks(subject, task), {
          objects,
          video: name,
          ...frameRateOption(subject),
        });
        return new Blob([JSON.stringify(coco)], { type: 'application/json' });
      },
    },
    {
      id: 'table',
      label: 'objects.csv',
      ariaLabel: 'objects.csv: position, size and motion of each object in each frame',
      file: () => 'objects.csv',
      make: async (subject, task) => {
        const { objects, points } = subject;
        const masks = await resizeMasks(subject, task);
        const trajectories = scaleTrajectories(
          points,
          masks.width / subject.masks.width,
          masks.height / subject.masks.height,
        );
        const rows = await objectTable(masks, { trajectories, objects, ...frameRateOption(subject) });
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

/** Scales trajectories to larger masks. */
function scaleTrajectories({ startFrame, offset, x, y }: TrajectoryPoints, across: number, down: number) {
  const scalePoints = (values: ArrayLike<number>, scale: number) =>
    Float32Array.from(values, (value) => (value + 0.5) * scale - 0.5);
  return { startFrame, offset, x: scalePoints(x, across), y: scalePoints(y, down) };
}

export const masks: Export = {
  title: 'Masks',
  about: 'Coloured PNG files',
  choices: [{ id: 'zip', label: 'ZIP', file: () => 'masks.zip', make: makeMaskZip(false) }],
};

const objectMasks: Export = {
  title: 'Masks by object',
  about: 'A folder of black and white PNG files per object; times are in masks.json.',
  choices: [{ id: 'zip-objects', label: 'ZIP', file: () => 'objects.zip', make: makeMaskZip(true) }],
};

const frameMask: Export = {
  title: 'Mask of this frame',
  about: 'One PNG, in the colours shown here.',
  choices: [
    {
      id: 'png',
      label: 'PNG',
      ariaLabel: 'Mask of this frame as PNG',
      file: ({ frame }) => `mask-${String(frame + 1).padStart(4, '0')}.png`,
      make: async (subject) => {
        const { frame, objects } = subject;
        const image = await subject.image(frame);
        const labels = (await resizeLabels(subject, frame, image)).map((label) => (objects(label) ? label : 0));
        const { width, height } = image;
        const mask = { width, height, numFrames: 1, labels: () => labels };
        return new Blob([await maskPng(mask, 0)], { type: 'image/png' });
      },
    },
  ],
};

function makeMaskZip(perObject: boolean): Choice['make'] {
  return async (subject, task) => {
    const { objects } = subject;
    const bytes = await masksZip(await resizeMasks(subject, task), {
      perObject,
      objects,
      ...task,
      ...frameRateOption(subject),
    });
    return new Blob([bytes], { type: 'application/zip' });
  };
}

export const images: Export = {
  title: 'Cut-out images',
  about: 'Transparent PNG files, with sound and a timeline for video editors. An animated PNG plays like a GIF.',
  choices: [
    imageChoice('cutout-zip', 'ZIP for editors', 'cutout.zip', 'cutout', 'editor'),
    imageChoice('cutout-apng', 'Animated PNG', 'cutout.png', 'cutout', 'apng'),
    imageChoice('alpha-zip', 'Alpha only, ZIP', 'alpha.zip', 'alpha', 'zip'),
  ],
};

function imageChoice(
  id: string,
  label: string,
  file: string,
  style: 'cutout' | 'alpha',
  format: 'zip' | 'apng' | 'editor',
): Choice {
  return {
    id,
    label,
    file: () => file,
    type: format === 'apng' ? 'image/png' : 'application/zip',
    make: (subject, task) => {
      const { masks, frames, objects, edges } = subject;
      const sound = format === 'editor' && subject.sound('wav');
      const options = { style, format, objects, edges, ...task, ...frameRateOption(subject) };
      return encodeImages(masks, frames(task.signal), { ...options, ...(sound ? { sound } : {}) });
    },
  };
}

export const project: Export = {
  title: 'Project',
  about: 'Masks, corrections and the clip in one file, to open again here.',
  choices: [
    {
      id: 'project',
      label: 'Project file',
      file: () => `project${PROJECT_EXTENSION}`,
      isAvailable: ({ source }) => Boolean(source.files),
      make: async ({ state }) => createProjectFile(await new Packer().pack(state, '')),
    },
  ],
};

/** The main exports, with one choice each. */
export const MAIN_EXPORTS: Export[] = [videos.transparentVideo, videos.greenVideo, videos.blurredVideo, masks];

/** Returns the other exports, in the order of the dialog. */
export const otherExports = (background: Export): Export[] => [
  ...[videos.overlayVideo, videos.cutoutVideo, images, videos.maskVideo],
  ...[objectMasks, frameMask, background, data, project],
];
