/**
 * The list of exports, in the order of the dialog. To add one, write its file, a value of type `Export` (see export.js),
 * and list it here; the dialog knows them only through this type.
 * @module
 */

import { background } from './export-background.js';
import { data } from './export-data.js';
import { images } from './export-images.js';
import { frameMask, masks } from './export-masks.js';
import { project } from './export-project.js';
import { cutoutVideo, maskVideo, overlayVideo } from './export-video.js';

/** @type {import('./export.js').Export[]} */
export const EXPORTS = [overlayVideo, cutoutVideo, images, maskVideo, masks, frameMask, background, data, project];
