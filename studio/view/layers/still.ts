// Boundaries of a still image by the embedding of its pixels (section 2.2 and Figure 3(b) of the paper), dark on white.

import { drawBoundaries } from '../../model/library.js';
import { Fetched, picture, valueAt } from './fetched.js';
import { type Layer, choice, opacity } from './layer.js';
import type { ImageEdges } from '../../model/answers.js';

type Kind = 'combined' | 'discontinuity' | 'spectral' | 'pb';

/**
 * Strengths of the embedding have no scale of their own: shares of pixels that stay white, and that are not quite
 * black.
 */
const STRETCH = { white: 0.4, black: 0.98 };

/** What can be chosen, and its word in the readout. */
const KINDS: [Kind, string, string][] = [
  ['combined', 'Pb and discontinuities together', 'combined'],
  ['discontinuity', 'Discontinuities of the embedding', 'discontinuity'],
  ['spectral', 'Gradients of the eigenvectors', 'spectral'],
  ['pb', 'Pb alone', 'Pb'],
];

export function stillLayer(): Layer {
  const kind = choice(
    'Show',
    KINDS.map(([, name]) => name),
  );
  const maps = new Fetched('imageEdges', (map) => ({
    map,
    pictures: KINDS.map(([of]) => paint(map, of)),
  }));
  return {
    id: 'still',
    name: 'Embedding discontinuities',
    key: '6',
    only: 'still',
    about:
      'Pixels that look connected lie close together in the embedding; boundaries are where its density breaks off.',
    z: 16,
    on: true,
    settings: { opacity: opacity(), kind },
    legend: () => [],
    reset: () => maps.reset(),
    draw(ctx, view) {
      const known = maps.get(view, view.frame);
      if (known) ctx.drawImage(known.pictures[kind.value], -0.5, -0.5, view.width, view.height);
    },
    readout(view, spot) {
      const { map } = maps.get(view, view.frame) ?? {};
      if (!map) return '';
      const words = KINDS.map(([of, , word]) => [word, valueAt(map, map[of], view, spot)]);
      return words
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
      : { white: quantile(values[of], STRETCH.white), black: quantile(values[of], STRETCH.black) };
  return picture({ width, height }, (ctx) =>
    drawBoundaries(ctx, { width, height, [of]: values[of] }, { of, ...stretch }),
  );
}

/** @param q in 0..1 */
function quantile(values: Float32Array, q: number) {
  return values.slice().sort()[Math.round(q * (values.length - 1))];
}
