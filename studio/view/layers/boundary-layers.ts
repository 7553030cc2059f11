// Layers of a still image: boundary probability, contours and superpixels.

import { type DrawSuperpixelsOptions, drawBoundaries, drawSuperpixels } from '../../model/library.js';
import { FrameCache, drawPicture, readValue } from './frame-cache.js';
import { type Layer, fromCorner, opacity, toggle } from './layer.js';
import { legendEntry } from '../dom.js';
import { EDGE_STYLES } from '../../model/palette.js';
import type { Boundaries, Superpixels } from '../../model/frame-data.js';

export function boundaryLayer(): Layer {
  const thin = toggle('Ridges only', false);
  const maps = new FrameCache('boundaries', (map) => ({
    map,
    pb: renderBoundaries(map, 'pb'),
    thin: renderBoundaries(map, 'thin'),
  }));
  return {
    id: 'boundaries',
    name: 'Boundaries (Pb)',
    key: '5',
    about: 'Boundary probability of each pixel, from brightness, colour and texture.',
    only: 'still',
    z: 14,
    isOn: false,
    settings: { opacity: opacity(), thin },
    legend: () => [],
    reset: () => maps.reset(),
    draw(ctx, view) {
      const cached = maps.get(view, view.frame);
      if (cached) ctx.drawImage(thin.value > 0 ? cached.thin : cached.pb, -0.5, -0.5, view.width, view.height);
    },
    readout(view, spot) {
      const map = maps.get(view, view.frame)?.map;
      const value = map && readValue(map, map.pb, view, spot);
      return value === undefined ? '' : `Pb ${value.toFixed(2)}`;
    },
  };
}

function renderBoundaries({ width, height, ...values }: Boundaries, of: 'pb' | 'thin') {
  return drawPicture({ width, height }, (ctx) => drawBoundaries(ctx, { width, height, [of]: values[of] }, { of }));
}

/** Width of contours in CSS pixels. */
const CONTOUR_WIDTH_PX = 1.6;

export function contourLayer(): Layer {
  const deleted = toggle('Deleted edges', false);
  const regions = new FrameCache('superpixels', (superpixels) => superpixels);
  return {
    id: 'contours',
    name: 'Contours',
    key: '4',
    about: 'Lines fitted to contours, and Gabriel edges across the gaps.',
    only: 'still',
    z: 50,
    isOn: false,
    settings: { opacity: opacity(), deleted },
    legend: () => [
      legendEntry('line', EDGE_STYLES.Constraint.color, 'contours'),
      legendEntry('line', EDGE_STYLES.Gabriel.color, 'Gabriel edges'),
      legendEntry('thin', 'currentcolor', 'deleted Delaunay edges'),
    ],
    reset: () => regions.reset(),
    draw(ctx, view) {
      const superpixels = regions.get(view, view.frame);
      if (!superpixels) return;
      const options: DrawSuperpixelsOptions = {
        fill: 'none',
        borders: false,
        edges: true,
        deleted: deleted.value > 0,
        width: CONTOUR_WIDTH_PX * view.unit,
      };
      fromCorner(ctx, () => drawSuperpixels(ctx, superpixels, options));
    },
  };
}

/** Scale of the drawing relative to the superpixel map, for thin lines. */
const PIXELS_PER_CELL = 3;

export function superpixelLayer(): Layer {
  const mean = toggle('Mean colour', true);
  const pictures = new Map<string, OffscreenCanvas>();
  const regions = new FrameCache('superpixels', (superpixels) => superpixels);
  return {
    id: 'superpixels',
    name: 'Superpixels',
    key: '3',
    about: 'Regions between contours; each belongs to one object.',
    only: 'still',
    z: 12,
    isOn: false,
    settings: { opacity: opacity(0.9), mean },
    legend: () => [],
    reset() {
      pictures.clear();
      regions.reset();
    },
    draw(ctx, view) {
      const superpixels = regions.get(view, view.frame);
      if (!superpixels) return;
      const key = `${view.frame} ${mean.value}`;
      const canvas = pictures.get(key) ?? renderSuperpixels(superpixels, mean.value > 0 ? view.image : null);
      pictures.set(key, canvas);
      ctx.drawImage(canvas, -0.5, -0.5, view.width, view.height);
    },
  };
}

/** @param image for mean colours */
function renderSuperpixels(superpixels: Superpixels, image: CanvasImageSource | null) {
  const { width, height } = superpixels;
  return drawPicture({ width: PIXELS_PER_CELL * width, height: PIXELS_PER_CELL * height }, (ctx) => {
    ctx.scale(PIXELS_PER_CELL, PIXELS_PER_CELL);
    drawSuperpixels(ctx, { ...superpixels, scaleX: 1, scaleY: 1 }, image ? { image } : {});
  });
}
