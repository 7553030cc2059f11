// The dialog in which results are saved: files, a link with the settings, and what it takes to get the same result
// again.

import { type MaskSource, version } from '../../model/library.js';
import { PLAYS_MP4, byId, connectDialog, h } from '../dom.js';
import { edgesOf, groundOf } from '../../model/look.js';
import { type Choice, type Export, type Subject, stemOf, subjectOf } from '../../model/export.js';
import { framesOf } from '../../model/export-size.js';
import { FIRST, otherExports } from '../../model/exports.js';
import { background } from '../background-export.js';
import { objectName } from '../../model/palette.js';
import { linkOf, recipeOf } from '../../model/recipe.js';
import { download, placeFor } from '../save-file.js';
import { TimeLeft } from '../../model/time-left.js';
import { untilAborted } from '../../model/stage-clock.js';
import { bytes, count, explain, plural, remaining } from '../../model/words.js';
import { ExportOptions } from './export-options.js';
import { SavePreview } from './save-preview.js';
import type { Page } from '../page.js';

/** What the choices with a preview are called where there is little room. */
const LOOKS: Record<string, string> = { transparent: 'Cut-out', green: 'Green', blurred: 'Blurred', zip: 'Masks' };

/** How often progress is looked at, in milliseconds. */
const TICK_MS = 200;

export class ExportDialog {
  store: Page['store'];
  selection: Page['selection'];
  viewer: Page['viewer'];
  options = new ExportOptions();
  dialog = byId<HTMLDialogElement>('export');
  recipeBox = byId<HTMLDetailsElement>('recipe-box');
  /** What it takes to get the same result again. */
  recipe = '';
  abort: AbortController | null = null;
  saved: File | null = null;
  first: { choice: Choice; button: HTMLButtonElement }[];
  preview: SavePreview;
  named: { title: string; choice: Choice; button: HTMLButtonElement }[];
  choices: { choice: Choice; button: HTMLButtonElement }[];

  constructor({ store, selection, viewer }: Pick<Page, 'store' | 'selection' | 'viewer'>) {
    this.store = store;
    this.selection = selection;
    this.viewer = viewer;
    const rows = otherExports(background).map((one) => this.row(one));
    byId('export-list').replaceChildren(...rows.map(({ element }) => element));
    const first = FIRST.map((one, k) => this.card(one, k === 0));
    byId('export-first').replaceChildren(...first.map(({ button }) => button));
    this.first = first;
    this.preview = new SavePreview(
      first.map(({ choice }) => choice),
      () => this.subjectNow(),
    );
    this.named = rows.flatMap(({ choices }) => choices);
    this.choices = [...first, ...this.named];
    this.nameChoices();
    this.connect();
  }

  connect() {
    byId('export-close').addEventListener('click', () => this.dialog.close());
    byId('export-cancel').addEventListener('click', () => this.abort?.abort());
    byId('export-share').addEventListener('click', () => this.share());
    byId('copy-link').addEventListener('click', () =>
      this.copy(linkOf(this.store.state.changed, location.href), 'The link is on the clipboard.'),
    );
    byId('copy-recipe').addEventListener('click', () => this.copy(this.recipe, 'The recipe is on the clipboard.'));
    this.recipeBox.addEventListener('toggle', () => this.showRecipe());
    byId('export-more').addEventListener('change', () => {
      const { choice } = this.preview;
      this.preview.begin();
      if (choice) this.look(choice);
    });
    this.connectShown();
    this.dialog.addEventListener('close', () => {
      this.abort?.abort();
      this.preview.begin();
    });
    connectDialog(this.dialog);
  }

  /** Whoever is at a choice sees what it would save; fingers choose that beside the picture. */
  connectShown() {
    for (const { choice, button } of this.first)
      for (const kind of ['pointerenter', 'focus']) button.addEventListener(kind, () => this.look(choice));
    const looks = this.first.map(({ choice }) =>
      h(
        'label',
        {},
        h('input', { type: 'radio', name: 'look', value: choice.id, input: () => this.look(choice) }),
        h('span', {}, LOOKS[choice.id] ?? choice.id),
      ),
    );
    byId('export-looks').append(...looks);
  }

  look(choice: Choice) {
    if (this.abort || !this.dialog.open) return;
    this.preview.show(choice);
    for (const { choice: one, button } of this.first) button.toggleAttribute('data-looked', one === choice);
    const radio = byId('export-looks').querySelector<HTMLInputElement>(`[value="${choice.id}"]`);
    if (radio) radio.checked = true;
  }

  /** What there is to save; null without a result. */
  subject() {
    return subjectOf(this.store.state);
  }

  open() {
    const found = this.subject();
    if (!found || this.dialog.open) return;
    this.options.open(found);
    byId('export-kept').textContent = keptWords(this.selection.objects);
    this.nameChoices();
    this.tell('');
    this.offer(null);
    this.setBusy(false);
    this.recipeBox.open = false;
    this.preview.begin();
    // What is shown is one frame.
    this.store.set({ playing: false });
    byId('export-preview').style.setProperty('--aspect', String(found.source.width / found.source.height));
    this.dialog.showModal();
    this.look(this.first[0].choice);
  }

  /** @param isNext whether it is what most would save */
  card({ title, about, choices: [choice] }: Export, isNext: boolean) {
    const button = h(
      'button',
      {
        type: 'button',
        class: isNext ? 'card primary' : 'card',
        'data-export': choice.id,
        click: () => this.save(choice),
      },
      h('strong', {}, title),
      h('span', {}, about),
    );
    return { choice, button };
  }

  row({ title, about, choices }: Export) {
    const withButtons = choices.map((choice) => ({
      title,
      choice,
      button: h('button', {
        type: 'button',
        class: 'save',
        'data-export': choice.id,
        click: () => this.save(choice),
      }),
    }));
    const element = h(
      'li',
      { class: 'export' },
      h('h3', {}, title),
      h('p', { class: 'about' }, about),
      h('div', { class: 'saves' }, ...withButtons.map(({ button }) => button)),
    );
    return { element, choices: withButtons };
  }

  /** Buttons of cut-outs say on which ground. */
  nameChoices() {
    const { name } = this.store.state.ground;
    for (const { title, choice, button } of this.named) {
      button.textContent = typeof choice.label === 'string' ? choice.label : choice.label(name);
      button.setAttribute('aria-label', choice.says ? choice.says : `${title}: ${button.textContent}`);
    }
  }

  /** Returns the choice as it is to be saved. */
  subjectNow(): Subject | null {
    const found = this.subject();
    const { job } = this.store.state;
    if (!found || !job) return null;
    const { side, quality } = this.options.chosen;
    const frames = framesOf(job, found.masks, side);
    return {
      ...found,
      frames: frames.all,
      image: frames.one,
      look: this.viewer.maskLook(side),
      quality,
      edges: edgesOf(this.store.state.edges, found.masks),
      ground: groundOf(this.store.state.ground),
      sound: (format: 'webm' | 'mp4') => this.options.soundFor(format),
      objects: (object: number) => object > 0 && this.selection.has(object),
    };
  }

  async save(choice: Choice) {
    const subject = this.subjectNow();
    if (!subject || this.abort) return;
    this.preview.stop();
    const { masks } = subject;
    const file = `${stemOf(subject.name)}-${choice.file(subject)}`;
    this.offer(null);
    this.abort = new AbortController();
    const { signal } = this.abort;
    const pressed = document.activeElement as HTMLElement | null;
    const timeLeft = new TimeLeft(performance.now());
    this.setBusy(true);
    this.tell(`Making ${file}…`);
    try {
      // Asked first, while the click is fresh.
      const place = choice.type ? await placeFor(file, choice.type) : null;
      const save = async (made: Blob | ReadableStream<Uint8Array<ArrayBuffer>>) => {
        if (!(made instanceof Blob)) return place!(made, signal);
        download(made, file);
        return made.size;
      };
      const whole = await this.smoothed(signal, timeLeft);
      if (whole) subject.masks = { ...masks, labels: (t) => whole.labels(t) };
      if (whole) timeLeft.begin(performance.now());
      const made = await choice.make(subject, { signal, onProgress: (progress) => showProgress(progress, timeLeft) });
      signal.throwIfAborted();
      const size = await save(made);
      if (made instanceof Blob) this.offer(new File([made], file, { type: made.type }));
      this.tell(`Saved ${file}, ${bytes(size)}.`);
    } catch (error) {
      if (signal.aborted || isCancel(error)) this.tell('Cancelled; nothing was saved.');
      else this.tell(wordsOf(error), true);
    } finally {
      this.abort = null;
      this.setBusy(false);
      // A button that cannot be pressed for a while loses the keyboard's place.
      if (document.activeElement === document.body && this.dialog.open) pressed?.focus();
    }
  }

  /** What was saved can be handed to another app, where the browser lets a page do that with such a file. */
  offer(file: File | null) {
    this.saved = file;
    byId('export-share').hidden = !file || !navigator.canShare?.({ files: [file] });
  }

  async share() {
    if (!this.saved) return;
    try {
      await navigator.share({ files: [this.saved], title: this.saved.name });
    } catch (error) {
      // Whoever thinks better of it needs no words.
      if ((error as { name?: string })?.name !== 'AbortError')
        this.tell('Sharing did not work here; the file is saved.', true);
    }
  }

  /** Returns the masks as they are on screen, when all of them are smoothed; null where none are to be. */
  async smoothed(signal: AbortSignal, timeLeft: TimeLeft): Promise<MaskSource | null> {
    const { smoothed } = this.store.state;
    const tick = setInterval(() => {
      if (this.store.state.smoothed) showProgress(this.store.state.smoothed, timeLeft);
    }, TICK_MS);
    try {
      return smoothed && (await untilAborted(smoothed.whole, signal));
    } finally {
      clearInterval(tick);
    }
  }

  setBusy(busy: boolean) {
    const subject = this.subject();
    for (const { choice, button } of this.choices)
      button.disabled = busy || !subject || choice.there?.(subject) === false;
    byId('export-progress').hidden = !busy;
    showProgress({ done: 0, total: 0 });
  }

  tell(text: string, wrong = false) {
    byId('export-status').textContent = text;
    byId('export-status').classList.toggle('is-wrong', wrong);
  }

  async showRecipe() {
    const { state } = this.store;
    const masks = this.subject()?.masks;
    if (!this.recipeBox.open || !masks || !state.job) return;
    const corrections = state.job.corrector?.count() ?? 0;
    this.recipe = await recipeOf({ version, job: state.job, masks, corrections });
    byId('recipe').textContent = this.recipe;
  }

  /** @param done what is told then */
  async copy(text: string, done: string) {
    try {
      await navigator.clipboard.writeText(text);
      this.tell(done);
    } catch {
      this.tell(`The browser does not let the page write to the clipboard. Copy it yourself: ${text}`, true);
    }
  }
}

/** Returns which objects are saved, in words. */
function keptWords({ kept, all }: { kept: number[]; all: number }): string {
  if (kept.length === all) return '';
  const names = kept.length > 0 ? kept.map(objectName).join(', ') : 'No object';
  const of = plural(all, 'object');
  return kept.length < 2
    ? `${names} of ${of} is kept: what is saved has no other.`
    : `${names} of ${of} are kept: what is saved has no other.`;
}

/** @param progress a total of 0 before the first step */
function showProgress({ done, total }: { done: number; total: number }, timeLeft?: TimeLeft) {
  const share = total > 0 ? done / total : 0;
  byId('export-bar').style.setProperty('--share', String(share));
  byId('export-bar').setAttribute('aria-valuenow', String(Math.round(100 * share)));
  const words = total === 1 ? `${done} of 1 frame` : `${done} of ${count(total)} frames`;
  const left = timeLeft?.after({ done, total }, performance.now()) ?? null;
  const shown = left === null ? words : `${words}, ${remaining(left)}`;
  byId('export-count').textContent = total > 0 ? shown : '';
}

/** @param error whether no file was chosen */
function isCancel(error: unknown) {
  return error instanceof DOMException && error.name === 'AbortError';
}

function wordsOf(error: unknown) {
  const { title, advice, detail } = explain(error, PLAYS_MP4);
  return [title, advice, detail].filter(Boolean).join('. ');
}
