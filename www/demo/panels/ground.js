/** The view of the result as it is saved: the objects that are kept, on a ground of one's choice. @module */

import { drawCutout } from '../../dist/draw.js';
import { byId } from '../dom.js';
import { fromCorner } from '../layers/layer.js';
import { errorPatch } from '../store.js';
import { PageError } from '../words.js';

/** @typedef {'transparent' | 'green' | 'colour' | 'blurred' | 'desaturated' | 'dimmed' | 'picture'} GroundName */

/** The green of screens. */
export const GREEN = '#00b140';

/** @param {Pick<import('./panels.js').Page, 'store' | 'viewer'>} page */
export function groundPanel({ store, viewer }) {
  const choice = /** @type {HTMLSelectElement} */ (byId('ground'));
  const colour = /** @type {HTMLInputElement} */ (byId('ground-colour'));
  const file = /** @type {HTMLInputElement} */ (byId('ground-file'));
  choice.addEventListener('change', () => {
    const name = /** @type {GroundName} */ (choice.value);
    if (name === 'picture') file.click();
    // Without a picture it stays as it was.
    if (name === 'picture' && !store.state.ground.picture) choice.value = store.state.ground.name;
    else store.set({ ground: { ...store.state.ground, name } });
  });
  const trail = connectTrail(store);
  colour.addEventListener('input', () => store.set({ ground: { ...store.state.ground, colour: colour.value } }));
  file.addEventListener('change', async () => {
    const [picked] = file.files ?? [];
    file.value = '';
    if (!picked) return;
    try {
      const picture = await createImageBitmap(picked);
      store.set({ ground: { ...store.state.ground, name: 'picture', picture } });
    } catch {
      store.set(errorPatch(new PageError('unreadable-image', picked.name)));
    }
  });
  store.watch(['view', 'ground'], ({ view, ground }) => {
    byId('ground-row').hidden = view !== 'cutout';
    byId('screen').dataset.ground = ground.name;
    choice.value = ground.name;
    colour.hidden = ground.name !== 'colour';
    trail.value = `${ground.trail.copies} ${ground.trail.spacing}`;
    viewer.redraw();
  });
}

/**
 * The choices say how many copies, and how many frames apart.
 *
 * @param {import('../store.js').Store} store
 */
function connectTrail(store) {
  const choice = /** @type {HTMLSelectElement} */ (byId('trail'));
  choice.addEventListener('change', () => {
    const [copies, spacing] = choice.value.split(' ').map(Number);
    store.set({ ground: { ...store.state.ground, trail: { copies, spacing } } });
  });
  return choice;
}

/**
 * @param {import('../store.js').Ground} ground
 * @returns {import('../../dist/draw.js').Ground} as the package takes it
 */
export function groundOf({ name, colour, picture }) {
  if (name === 'green') return GREEN;
  if (name === 'colour') return colour;
  return name === 'picture' && picture ? picture : name;
}

/**
 * Draws the frame's objects that are kept on their ground.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../layers/layer.js').View} view
 * @param {import('../store.js').Ground} ground
 */
export function drawKept(ctx, { image, mask, trail }, ground) {
  const edged = mask();
  if (!image || !edged) return;
  fromCorner(ctx, () => drawCutout(ctx, image, edged, { background: groundOf(ground), trail: trail() }));
}
