/** The clips of the gallery: their posters, and opening them as work that is done. @module */

import { byId, h, toPicture } from '../dom.js';
import { readProjectFile } from '../saved/work.js';
import { plural } from '../words.js';

/** @typedef {Pick<import('../page.js').Page, 'store' | 'app'>} Page */
/** @typedef {{id: string, width: number, height: number, frames: number, seconds: number, objects: number}} Facts */

/** What each clip shows, by its name. */
export const CLIPS = [
  {
    id: 'coast',
    title: 'On the coast',
    about: 'The camera pans, while two boats and a balloon go their own ways.',
  },
  { id: 'street', title: 'In the street', about: 'The camera stands still; a bus, a car and a walker pass.' },
  { id: 'parting', title: 'Two that part', about: 'Two ladybirds walk alike, then each goes its own way.' },
  { id: 'forward', title: 'Forward', about: 'The camera goes forward; a car crosses ahead, a balloon drifts by.' },
  { id: 'ball', title: 'A small ball', about: 'It bounces across a lawn, and the camera follows.' },
  { id: 'hedge', title: 'Behind a hedge', about: 'A car passes half hidden, and a walker before it.' },
];

/** @param {string} name of a file */
const fetched = async (name, init = {}) => {
  const response = await fetch(new URL(`demo/gallery/${name}`, document.baseURI), init);
  if (!response.ok) throw new Error(`${name}: ${response.status}`);
  return response;
};

/** @param {string} text */
const tell = (text) => (byId('gallery-status').textContent = text);

/**
 * Fills the list, once; without a network it says so, and tries again the next time.
 *
 * @param {Page} page
 */
export async function showGallery(page) {
  const list = byId('gallery-list');
  if (list.childElementCount > 0) return;
  try {
    const { clips } = /** @type {{clips: Facts[]}} */ (await (await fetched('index.json')).json());
    const opener = new Opener(page);
    list.replaceChildren(
      ...clips.map((facts) =>
        h(
          'li',
          {},
          card(facts, (id) => opener.open(id)),
        ),
      ),
    );
    page.store.watch(['source'], ({ source }) => markShown(source?.gallery));
    markShown(page.store.state.source?.gallery);
    tell('');
  } catch {
    tell('The gallery comes by the network, which does not answer. Everything else works without.');
  }
}

/**
 * @param {Facts} facts
 * @param {(id: string) => void} open
 */
function card({ id, width, height, seconds, objects }, open) {
  const { title, about } = wordsOf(id);
  const facts = [plural(objects, 'object'), `${seconds.toFixed(1)}\u00a0s`].join(', ');
  const poster = h('img', { alt: '', loading: 'lazy', width, height });
  poster.src = new URL(`demo/gallery/${id}.webp`, document.baseURI).href;
  const label = `${title}. ${about} ${facts}`;
  const props = { type: 'button', class: 'gallery-card', 'data-clip': id, 'aria-label': label, title: about };
  return h('button', { ...props, click: () => open(id) }, poster, h('span', {}, title));
}

/** @param {string} id */
function wordsOf(id) {
  return CLIPS.find((clip) => clip.id === id) ?? { title: id, about: '' };
}

/** @param {string | undefined} shown the clip on screen, if it is one of these */
function markShown(shown) {
  for (const button of byId('gallery-list').querySelectorAll('button'))
    if (button.dataset.clip === shown) button.setAttribute('aria-current', 'true');
    else button.removeAttribute('aria-current');
}

/** Opens one clip at a time: what is on screen stays until the clip is there. */
class Opener {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {AbortController | null} */
    this.abort = null;
  }

  /** @param {string} id */
  async open(id) {
    this.abort?.abort();
    const { signal } = (this.abort = new AbortController());
    const { app, store } = this.page;
    const { visit } = store.state;
    const title = wordsOf(id).title;
    tell(`Fetching “${title}”…`);
    try {
      const bytes = await (await fetched(`${id}.tracecut`, { signal })).arrayBuffer();
      // Whoever has opened something else meanwhile wants that.
      tell('');
      if (signal.aborted || visit !== store.state.visit) return;
      toPicture();
      await app.openWork(title, async () => {
        const work = await readProjectFile(new File([bytes], `${id}.tracecut`));
        return { ...work, about: { ...work.about, name: title }, gallery: id };
      });
    } catch {
      if (!signal.aborted) tell(`“${title}” comes by the network, which does not answer.`);
    }
  }
}
