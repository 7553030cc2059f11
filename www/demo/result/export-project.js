/** The work as a file that this page opens again. @module */

import { EXTENSION, Packer, projectFile } from '../saved/work.js';

/** @type {import('./export.js').Export} */
export const project = {
  title: 'Project',
  about: 'Masks, corrections and the clip itself in one file, which this page opens again.',
  choices: [
    {
      id: 'project',
      label: 'Project file',
      file: () => `project${EXTENSION}`,
      there: ({ source }) => Boolean(source.files),
      make: async ({ library, state }) => projectFile(await new Packer(library).pack(state, ''), library),
    },
  ],
};
