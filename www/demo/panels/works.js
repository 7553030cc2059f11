/** Works that are kept: the last is offered when the page opens, all are in a list, to open or to delete. @module */

import { byId, h } from '../dom.js';
import { bytesOf, forget, kept } from '../saved/storage.js';
import { isWork, reopened } from '../saved/work.js';
import { bytes } from '../words.js';
import { connectDialog } from './help.js';
import { say, shownLanguage } from '../language.js';

/** @typedef {import('../saved/storage.js').Saved} Saved */

/** @param {Pick<import('./panels.js').Page, 'store' | 'app' | 'library'>} page */
export function worksList({ store, app, library }) {
  const dialog = /** @type {HTMLDialogElement} */ (byId('works'));
  /** @type {string | null} The work that was opened again and is not on screen yet. */
  let opened = null;
  const open = async (/** @type {Saved} */ saved) => {
    dialog.close();
    byId('saved').hidden = true;
    opened = saved.id;
    await app.openWork(saved.name, () => reopened(saved, library));
  };
  const drop = async (/** @type {Saved} */ saved) => {
    await forget(saved.id);
    await update();
  };
  const update = async () => {
    const works = await kept();
    byId('works-open').hidden = works.length === 0;
    byId('works-list').replaceChildren(...works.map((saved) => lineOf(saved, open, drop)));
    if (works.length === 0) dialog.close();
    return works;
  };
  const list = async () => {
    await update();
    if (!dialog.open) dialog.showModal();
  };
  for (const id of ['works-open', 'saved-all']) byId(id).addEventListener('click', list);
  byId('works-close').addEventListener('click', () => dialog.close());
  connectDialog(dialog);

  /** Offers the last, unless something was opened meanwhile. */
  const offer = async () => {
    const works = await update();
    const [last] = works;
    if (!last || isWork(store.state)) return;
    byId('saved-text').textContent = say`Your work on ${last.name} was kept.`;
    byId('saved-all').hidden = works.length < 2;
    byId('saved').hidden = false;
    byId('saved-open').addEventListener('click', () => open(last));
    byId('saved-forget').addEventListener('click', () => {
      byId('saved').hidden = true;
      drop(last);
    });
  };
  const takeOpened = () => {
    const id = opened;
    opened = null;
    return id;
  };
  return { offer, update, takeOpened };
}

/**
 * @param {Saved} saved
 * @param {(saved: Saved) => void} open
 * @param {(saved: Saved) => void} drop
 */
function lineOf(saved, open, drop) {
  const when = new Date(saved.at).toLocaleString(shownLanguage(), { dateStyle: 'medium', timeStyle: 'short' });
  const { frames } = saved.about.take;
  const facts = [
    when,
    saved.edits ? say`${frames} frames, corrected` : say`${frames} frames`,
    bytes(bytesOf(saved)),
  ].join(' · ');
  const name = h('span', { class: 'work-name' }, saved.name, h('span', { class: 'work-facts' }, facts));
  const opener = h(
    'button',
    { type: 'button', 'aria-label': say`Open ${saved.name}`, 'data-open': saved.id, click: () => open(saved) },
    'Open',
  );
  // Deleting is done by the second press.
  const deleter = h(
    'button',
    {
      type: 'button',
      'aria-label': say`Delete ${saved.name}`,
      click: () => {
        if (deleter.dataset.sure) return drop(saved);
        deleter.dataset.sure = 'asked';
        deleter.textContent = say('Delete for good?');
        deleter.setAttribute('aria-label', say`Delete ${saved.name} for good?`);
      },
      blur: () => {
        delete deleter.dataset.sure;
        deleter.textContent = say('Delete');
        deleter.setAttribute('aria-label', say`Delete ${saved.name}`);
      },
    },
    'Delete',
  );
  return h('li', { class: 'work' }, name, opener, deleter);
}
