// The works that are kept in the browser: made of what is on screen, offered when the page opens, listed, to open or to
// delete. Fetched when there is one.

import { byId, connectDialog, h } from '../dom.js';
import { SavedJob } from '../../model/saved-job.js';
import { Packer, clipId, filesOf, reopened } from '../../model/work.js';
import { type Saved, type Version, bytesOf, keep, kept } from '../../model/slots.js';
import * as storage from '../storage.js';
import { smallPicture } from '../picture.js';
import { bytes } from '../../model/words.js';
import type { Run, RunMemory } from '../../model/cut-off.js';
import type { Source } from '../../model/source.js';
import type { State } from '../../model/store.js';
import type { Page } from '../page.js';

/** What is said of kept work, and what can be done. */
type Offer = { text: string; go?: () => unknown; goes?: string; drop?: () => unknown; lists: boolean };

let fetched: Promise<RunMemory> | undefined;

/** The runs of this page, and what it may be fetched for. */
export function runMemory() {
  fetched ??= import('../../model/cut-off.js').then(({ RunMemory }) => new RunMemory(storage, navigator.locks));
  return fetched;
}

export class Works {
  store: Page['store'];
  app: Page['app'];
  packer = new Packer(smallPicture);
  /** Whether there was no room for what was to be kept last. */
  isFull = false;
  ids = new WeakMap<Source, Promise<string>>();
  /** Addresses of the small pictures in the list. */
  urls: string[] = [];
  /** What the list has. */
  shown = '';
  dialog = byId<HTMLDialogElement>('works');

  /** @param onRoom called when there is room for what could not be kept */
  constructor(
    { store, app }: Pick<Page, 'store' | 'app'>,
    readonly onRoom: () => unknown,
  ) {
    this.store = store;
    this.app = app;
    for (const id of ['works-open', 'saved-all']) byId(id).addEventListener('click', () => this.list());
    byId('works-close').addEventListener('click', () => this.dialog.close());
    connectDialog(this.dialog);
    store.watch(['source'], () => void this.tellCorrected());
  }

  idOf(source: Source): Promise<string> {
    const id = this.ids.get(source) ?? clipId(source.files ?? []);
    this.ids.set(source, id);
    return id;
  }

  /** @returns whether there was room for it */
  async keep(state: State): Promise<boolean> {
    filesOf(state);
    const id = await this.idOf(state.source!);
    const saved = await this.packer.pack(state, id);
    const isKept = await keep(storage, saved).finally(() => void this.update());
    if (!isKept)
      this.ask({
        text: 'There is no room to keep this work: all others are corrected, and none of those goes by itself.',
        goes: 'Choose what to delete…',
        go: () => this.list(),
        lists: false,
      });
    else if (this.isFull) byId('saved').hidden = true;
    this.isFull = !isKept;
    return isKept;
  }

  /** A clip is opened whose work is kept with corrections: the new run does not have them. */
  async tellCorrected() {
    const { source } = this.store.state;
    // The sample comes by itself, also after an offer.
    if (!source?.files) return;
    // What was offered was of another.
    byId('saved').hidden = true;
    const id = await this.idOf(source);
    const slot = (await kept(storage)).find((one) => one.id === id);
    const { state } = this.store;
    const found = slot && (slot.corrected ? slot : slot.earlier[0]);
    if (!found || source !== state.source || state.job instanceof SavedJob) return;
    this.ask({
      text: `Your corrected work on ${slot.name} was kept.`,
      go: () => this.open(slot, found),
      lists: true,
    });
  }

  async open(slot: Saved, version: Saved | Version = slot) {
    this.dialog.close();
    byId('saved').hidden = true;
    await this.app.openWork(slot.name, () => reopened({ ...version, files: slot.files }));
  }

  async drop({ id }: { id: string }) {
    await storage.forget(id);
    await this.update();
    this.onRoom();
  }

  async dropVersion(slot: Saved, version: Version) {
    await storage.put({ ...slot, earlier: slot.earlier.filter((one) => one !== version) });
    await this.update();
    this.onRoom();
  }

  async update() {
    const works = await kept(storage);
    byId('works-open').hidden = works.length === 0;
    if (this.dialog.open) this.show(works);
    return works;
  }

  show(works: Saved[]) {
    const shown = works.map(({ id, at, earlier }) => [id, at, earlier.length]).join();
    if (shown === this.shown) return;
    this.shown = shown;
    for (const url of this.urls.splice(0)) URL.revokeObjectURL(url);
    const held = document.activeElement?.getAttribute('aria-label');
    byId('works-list').replaceChildren(...works.map((slot) => this.lineOf(slot)));
    if (works.length === 0) return this.dialog.close();
    // The keyboard's place stays where it was.
    const buttons = [...this.dialog.querySelectorAll('button')];
    buttons.find((button) => held && button.getAttribute('aria-label') === held)?.focus();
  }

  async list() {
    const works = await this.update();
    if (!this.dialog.open) this.dialog.showModal();
    this.show(works);
  }

  /** Offers the run that was cut off, or else the last work, unless something was opened meanwhile. */
  async offer() {
    const works = await this.update();
    const runs = (await storage.stored()).length > works.length ? await runMemory() : null;
    const run = await runs?.cutOff();
    const last = run ?? works[0];
    if (!last || this.store.state.source?.files) return;
    this.ask({
      text: run ? `The run of ${run.name} was cut off.` : `Your work on ${last.name} was kept.`,
      goes: run && `Run again: ${run.name}`,
      go: () => (run ? this.again(run) : this.open(works[0])),
      drop: () => this.drop(last),
      lists: works.length >= (run ? 1 : 2),
    });
  }

  async again(run: Run) {
    byId('saved').hidden = true;
    // The new run is remembered by itself.
    await storage.forget(run.id);
    await this.app.openRun(run);
  }

  ask({ text, go, goes = 'Go on with it', drop, lists }: Offer) {
    byId('saved-text').textContent = text;
    byId('saved-open').textContent = goes;
    byId('saved-open').onclick = () => go?.();
    byId('saved-forget').hidden = !drop;
    byId('saved-forget').onclick = () => {
      byId('saved').hidden = true;
      drop?.();
    };
    byId('saved-all').hidden = !lists;
    byId('saved').hidden = false;
  }

  lineOf(slot: Saved) {
    const { name, corrected, files, project } = slot;
    const size = bytesOf({ files, project, earlier: [] });
    const facts = [factsOf(slot, corrected), bytes(size)].join(' · ');
    const words = h('span', { class: 'work-name' }, name, h('span', { class: 'work-facts' }, facts));
    const line = h(
      'li',
      { class: 'work' },
      this.pictureOf(slot.picture),
      words,
      opener(`Open ${name}`, slot.id, () => this.open(slot)),
      deleter(name, () => this.drop(slot)),
    );
    if (slot.earlier.length > 0)
      line.append(h('ul', { class: 'versions' }, ...slot.earlier.map((one) => this.versionOf(slot, one))));
    return line;
  }

  versionOf(slot: Saved, version: Version) {
    const facts = factsOf(version, true);
    const name = `${slot.name}, ${facts}`;
    return h(
      'li',
      { class: 'work' },
      this.pictureOf(version.picture),
      h('span', { class: 'work-facts' }, `Before: ${facts}`),
      opener(`Open ${name}`, `${slot.id} ${version.about.run}`, () => this.open(slot, version)),
      deleter(name, () => this.dropVersion(slot, version)),
    );
  }

  pictureOf(picture: Blob | null) {
    if (!picture) return h('span', { class: 'work-picture' });
    const url = URL.createObjectURL(picture);
    this.urls.push(url);
    return h('img', { class: 'work-picture', src: url, alt: '' });
  }
}

function factsOf({ at, about }: Pick<Version, 'at' | 'about'>, corrected: boolean) {
  const when = new Date(at).toLocaleString('en', { dateStyle: 'medium', timeStyle: 'short' });
  const { frames } = about.take;
  return [when, corrected ? `${frames} frames, corrected` : `${frames} frames`].join(' · ');
}

function opener(label: string, id: string, open: () => void) {
  return h('button', { type: 'button', 'aria-label': label, 'data-open': id, click: open }, 'Open');
}

/** Deleting is done by the second press. */
function deleter(name: string, drop: () => void) {
  const button = h(
    'button',
    {
      type: 'button',
      'aria-label': `Delete ${name}`,
      click: () => {
        if (button.dataset.sure) return drop();
        button.dataset.sure = 'asked';
        button.textContent = 'Delete for good?';
        button.setAttribute('aria-label', `Delete ${name} for good?`);
      },
      blur: () => {
        delete button.dataset.sure;
        button.textContent = 'Delete';
        button.setAttribute('aria-label', `Delete ${name}`);
      },
    },
    'Delete',
  );
  return button;
}
