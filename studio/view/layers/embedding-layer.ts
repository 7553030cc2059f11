// Layer of boundaries from the embedding of a still image (section 2.2 and Figure 3(b) of the paper), dark on white.

import { drawBoundaries } from '../../model/library.js';
import { FrameCache, drawPicture, readValue } from './frame-cache.js';
import { type Layer, choice, opacity } from './layer.js';
import type { ImageEdges } from '../../model/frame-data.js';

type Kind = 'combined' | 'discontinuity' | 'spectral' | 'pb';

/** Quantiles drawn as white and black, as strengths of the embedding have no scale; chosen by eye. */
const CONTRAST_QUANTILES = { white: 0.4, black: 0.98 };

/** The maps to choose from, and their names in the readout. */
const KINDS: [Kind, string, string][] = [
  ['combined', 'Pb and discontinuities', 'combined'],
  ['discontinuity', 'Embedding discontinuities', 'discontinuity'],
  ['spectral', 'Eigenvector gradients', 'spectral'],
  ['pb', 'Pb only', 'Pb'],
];

export function stillLayer(): Layer {
  const kind = choice(
    'Show',
    KINDS.map(([, name]) => name),
  );
  const maps = new FrameCache('imageEdges', (map) => ({
    map,
    pictures: KINDS.map(([of]) => paint(map, of)),
  }));
  return {
    id: 'still',
    name: 'Embedding discontinuities',
    key: '6',
    only: 'still',
    about: 'Similar pixels lie close together in the embedding; boundaries are where it changes abruptly.',
    z: 16,
    isOn: true,
    settings: { opacity: opacity(), kind },
    legend: () => [],
    reset: () => maps.reset(),
    draw(ctx, view) {
      const cached = maps.get(view, view.frame);
      if (cached) ctx.drawImage(cached.pictures[kind.value], -0.5, -0.5, view.width, view.height);
    },
    readout(view, spot) {
      const { map } = maps.get(view, view.frame) ?? {};
      if (!map) return '';
      const values = KINDS.map(([of, , word]) => [word, readValue(map, map[of], view, spot)]);
      return values
        .map(([word, value]) => (typeof value === 'number' ? `${word} ${value.toFixed(2)}` : ''))
        .filter(Boolean)
        .join(', ');
    },
  };
}

function paint({ width, height, ...values }: ImageEdges, of: Kind) {
  const stretch =
    of === 'pb' || of === 'combined'
      ? {}
      : {
          white: quantile(values[of], CONTRAST_QUANTILES.white),
          black: quantile(values[of], CONTRAST_QUANTILES.black),
        };
  return drawPicture({ width, height }, (ctx) =>
    drawBoundaries(ctx, { width, height, [of]: values[of] }, { of, ...stretch }),
  );
}

/** @param q in 0..1 */
function quantile(values: Float32Array, q: number) {
  return values.slice().sort()[Math.round(q * (values.length - 1))];
}
