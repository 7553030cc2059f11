// What a still image shows: the boundary probability, contours, superpixels.

import { type DrawSuperpixelsOptions, drawBoundaries, drawSuperpixels } from '../../model/library.js';
import { Fetched, picture, valueAt } from './fetched.js';
import { type Layer, fromCorner, opacity, toggle } from './layer.js';
import { key } from '../dom.js';
import { EDGE_STYLES } from '../../model/palette.js';
import type { Boundaries, Superpixels } from '../../model/answers.js';

export function boundaryLayer(): Layer {
  const thin = toggle('Ridges only', false);
  const maps = new Fetched('boundaries', (map) => ({
    map,
    pb: boundariesOf(map, 'pb'),
    thin: boundariesOf(map, 'thin'),
  }));
  return {
    id: 'boundaries',
    name: 'Boundaries (Pb)',
    key: '5',
    about: 'How likely each pixel lies on a boundary, from brightness, colour and texture; computed when first shown.',
    only: 'still',
    z: 14,
    on: false,
    settings: { opacity: opacity(), thin },
    legend: () => [],
    reset: () => maps.reset(),
    draw(ctx, view) {
      const known = maps.get(view, view.frame);
      if (known) ctx.drawImage(thin.value > 0 ? known.thin : known.pb, -0.5, -0.5, view.width, view.height);
    },
    readout(view, spot) {
      const map = maps.get(view, view.frame)?.map;
      const here = map && valueAt(map, map.pb, view, spot);
      return here === undefined ? '' : `Pb ${here.toFixed(2)}`;
    },
  };
}

function boundariesOf({ width, height, ...values }: Boundaries, of: 'pb' | 'thin') {
  return picture({ width, height }, (ctx) => drawBoundaries(ctx, { width, height, [of]: values[of] }, { of }));
}

/** Width of contours in CSS pixels. */
const WIDTH = 1.6;

export function contourLayer(): Layer {
  const deleted = toggle('Deleted edges', false);
  const regions = new Fetched('superpixels', (superpixels) => superpixels);
  return {
    id: 'contours',
    name: 'Contours',
    key: '4',
    about: 'Lines fitted to the contours, and the Gabriel edges that bridge the gaps between them.',
    only: 'still',
    z: 50,
    on: false,
    settings: { opacity: opacity(), deleted },
    legend: () => [
      key('line', EDGE_STYLES.Constraint.color, 'contours'),
      key('line', EDGE_STYLES.Gabriel.color, 'Gabriel edges'),
      key('thin', 'currentcolor', 'Delaunay edges deleted'),
    ],
    reset: () => regions.reset(),
    draw(ctx, view) {
      const known = regions.get(view, view.frame);
      if (!known) return;
      const options: DrawSuperpixelsOptions = {
        fill: 'none',
        borders: false,
        edges: true,
        deleted: deleted.value > 0,
        width: WIDTH * view.unit,
      };
      fromCorner(ctx, () => drawSuperpixels(ctx, known, options));
    },
  };
}

/** Pixels of the picture along one of the superpixels' grid, so that lines between them are finer than that. */
const FINE = 3;

export function superpixelLayer(): Layer {
  const mean = toggle('Mean colour', true);
  const pictures = new Map<string, OffscreenCanvas>();
  const regions = new Fetched('superpixels', (superpixels) => superpixels);
  return {
    id: 'superpixels',
    name: 'Superpixels',
    key: '3',
    about: 'Pieces of the frame that lie between its contours, gaps bridged; each belongs to one object.',
    only: 'still',
    z: 12,
    on: false,
    settings: { opacity: opacity(0.9), mean },
    legend: () => [],
    reset() {
      pictures.clear();
      regions.reset();
    },
    draw(ctx, view) {
      const known = regions.get(view, view.frame);
      if (!known) return;
      const key = `${view.frame} ${mean.value}`;
      const canvas = pictures.get(key) ?? superpixelsOf(known, mean.value > 0 ? view.image : null);
      pictures.set(key, canvas);
      ctx.drawImage(canvas, -0.5, -0.5, view.width, view.height);
    },
  };
}

/** @param image for mean colours */
function superpixelsOf(superpixels: Superpixels, image: CanvasImageSource | null) {
  const { width, height } = superpixels;
  return picture({ width: FINE * width, height: FINE * height }, (ctx) => {
    ctx.scale(FINE, FINE);
    drawSuperpixels(ctx, { ...superpixels, scaleX: 1, scaleY: 1 }, image ? { image } : {});
  });
}
