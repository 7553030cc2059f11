// The save dialog: files, a link with the settings, and the recipe that reproduces the result.

import {
  drawCutout,
  fitSize,
  type MaskSource,
  SCREEN_GREEN,
  soundInfo,
  type SoundInfo,
  type SoundOptions,
  StageClock,
  version,
  type VideoQuality,
  untilAborted,
} from '../../model/library.js';
import { byId, connectDialog, h, PLAYS_MP4 } from '../dom.js';
import { maskEdges } from '../../model/view-settings.js';
import { type Choice, type Export, exportSource, fileStem, type Subject } from '../../model/export.js';
import {
  computeDuration,
  describeImages,
  describeKept,
  describeProgress,
  describeSound,
  describeVideo,
  exportSizes,
  MIN_SIDE_PX,
  resizedFrames,
} from '../../model/export-text.js';
import { MAIN_EXPORTS, otherExports } from '../../model/exports.js';
import { background } from '../background-export.js';
import { createRecipe, settingsLink } from '../../model/recipe.js';
import { explain, formatBytes } from '../../model/messages.js';
import { SavePreview } from './save-preview.js';
import type { Page } from '../page.js';

/** Interval between updates of the progress, in milliseconds; chosen by eye. */
const TICK_MS = 200;

export class ExportDialog {
  store: Page['store'];
  selection: Page['selection'];
  viewer: Page['viewer'];
  options = new ExportOptions();
  dialog = byId<HTMLDialogElement>('export');
  recipeBox = byId<HTMLDetailsElement>('recipe-box');
  /** Settings and hashes that reproduce the result. */
  recipe = '';
  abort: AbortController | null = null;
  sharedFile: File | null = null;
  mainChoices: { choice: Choice; button: HTMLInputElement; facts: HTMLElement }[];
  preview: SavePreview;
  otherChoices: { title: string; choice: Choice; button: HTMLButtonElement }[];
  choices: { choice: Choice; button: HTMLButtonElement | HTMLInputElement }[];

  constructor({ store, selection, viewer }: Pick<Page, 'store' | 'selection' | 'viewer'>) {
    this.store = store;
    this.selection = selection;
    this.viewer = viewer;
    const rows = otherExports(background).map((item) => this.row(item));
    byId('export-list').replaceChildren(...rows.map(({ element }) => element));
    const cards = MAIN_EXPORTS.map((item) => this.card(item));
    byId('export-main').append(...cards.map(({ element }) => element));
    this.mainChoices = cards;
    this.preview = new SavePreview(
      cards.map(({ choice }) => choice),
      () => this.subject(),
      (choice) => drawSketch(choice, viewer),
    );
    this.otherChoices = rows.flatMap(({ choices }) => choices);
    this.choices = [...cards, ...this.otherChoices];
    this.options.onChange = () => this.showFacts();
    this.nameChoices();
    this.connect();
  }

  connect() {
    byId('export-close').addEventListener('click', () => this.dialog.close());
    byId('export-cancel').addEventListener('click', () => this.abort?.abort());
    byId('export-run').addEventListener('click', () => this.chosen && this.save(this.chosen));
    byId('export-share').addEventListener('click', () => this.share());
    byId('copy-link').addEventListener('click', () =>
      this.copy(settingsLink(this.store.state.changed, location.href), 'Link copied.'),
    );
    byId('copy-recipe').addEventListener('click', () => this.copy(this.recipe, 'Recipe copied.'));
    this.recipeBox.addEventListener('toggle', () => this.showRecipe());
    byId('export-more').addEventListener('change', () => {
      const { choice } = this.preview;
      this.preview.begin();
      if (choice) this.showPreview(choice);
    });
    this.dialog.addEventListener('close', () => {
      this.abort?.abort();
      this.preview.begin();
    });
    connectDialog(this.dialog);
  }

  /** The chosen card. */
  get chosen(): Choice | undefined {
    return this.mainChoices.find(({ button }) => button.checked)?.choice;
  }

  choose(choice: Choice) {
    for (const { choice: one, button } of this.mainChoices) button.checked = one === choice;
    this.showPreview(choice);
  }

  showPreview(choice: Choice) {
    if (!this.abort && this.dialog.open) this.preview.show(choice);
  }

  /** Shows size and length on the cards. */
  showFacts() {
    for (const { choice, facts } of this.mainChoices) facts.textContent = this.options.describe(choice.id === 'zip');
  }

  /** Returns the data to export; null without a result. */
  source() {
    return exportSource(this.store.state);
  }

  open() {
    const source = this.source();
    if (!source || this.dialog.open) return;
    this.options.open(source);
    byId('export-kept').textContent = describeKept(this.selection.objects);
    this.nameChoices();
    this.showStatus('');
    this.offerSharing(null);
    this.setBusy(false);
    this.recipeBox.open = false;
    this.preview.begin();
    // The preview shows one frame.
    this.store.set({ isPlaying: false });
    byId('export-preview').style.setProperty('--aspect', String(source.source.width / source.source.height));
    this.dialog.showModal();
    this.choose(this.chosen ?? this.mainChoices[0].choice);
  }

  card({ title, about, choices: [choice] }: Export) {
    const facts = h('span', { class: 'value' });
    const button = h('input', {
      ...{ type: 'radio', name: 'export-choice', 'data-export': choice.id },
      input: () => this.showPreview(choice),
    });
    const element = h('label', { class: 'card' }, button, h('strong', {}, title), h('span', {}, about), facts);
    return { choice, button, facts, element };
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

  /** Updates labels that depend on the backdrop. */
  nameChoices() {
    const { name } = this.store.state.backdrop;
    for (const { title, choice, button } of this.otherChoices) {
      button.textContent = typeof choice.label === 'string' ? choice.label : choice.label(name);
      button.setAttribute('aria-label', choice.ariaLabel ? choice.ariaLabel : `${title}: ${button.textContent}`);
    }
  }

  /** Returns the data to export with the chosen options. */
  subject(): Subject | null {
    const source = this.source();
    const { job } = this.store.state;
    if (!source || !job) return null;
    const { side, quality } = this.options.values;
    const frames = resizedFrames(job, source.masks, side);
    return {
      ...source,
      frames: frames.stream,
      image: frames.read,
      maskStyle: this.viewer.maskStyle(side),
      quality,
      edges: maskEdges(this.store.state.edges, source.masks),
      sound: (format) => this.options.soundFor(format),
      objects: (object: number) => object > 0 && this.selection.has(object),
    };
  }

  async save(choice: Choice) {
    const subject = this.subject();
    if (!subject || this.abort) return;
    this.preview.stop();
    const { masks } = subject;
    const file = `${fileStem(subject.name)}-${choice.file(subject)}`;
    this.offerSharing(null);
    this.abort = new AbortController();
    const { signal } = this.abort;
    const pressed = document.activeElement as HTMLElement | null;
    this.setBusy(true);
    this.showStatus(`Saving ${file}…`);
    try {
      // Asked first, as file pickers need a recent click.
      const place = choice.type ? await chooseDestination(file, choice.type) : null;
      const save = async (made: Blob | ReadableStream<Uint8Array<ArrayBuffer>>) => {
        if (!(made instanceof Blob)) return place!(made, signal);
        download(made, file);
        return made.size;
      };
      const smoothed = await this.waitForSmoothing(signal);
      if (smoothed) subject.masks = { ...masks, labels: (t) => smoothed.labels(t) };
      const clock = startClock();
      const output = await choice.make(subject, { signal, onProgress: (progress) => showProgress(progress, clock) });
      signal.throwIfAborted();
      const size = await save(output);
      if (output instanceof Blob) this.offerSharing(new File([output], file, { type: output.type }));
      this.showStatus(`Saved ${file}, ${formatBytes(size)}.`);
    } catch (error) {
      if (signal.aborted || isCancel(error)) this.showStatus('Cancelled.');
      else this.showStatus(describeError(error), true);
    } finally {
      this.abort = null;
      this.setBusy(false);
      // A disabled button loses the focus.
      if (document.activeElement === document.body && this.dialog.open) pressed?.focus();
    }
  }

  /** Offers to share the saved file, if the browser can. */
  offerSharing(file: File | null) {
    this.sharedFile = file;
    byId('export-share').hidden = !file || !navigator.canShare?.({ files: [file] });
  }

  async share() {
    if (!this.sharedFile) return;
    try {
      await navigator.share({ files: [this.sharedFile], title: this.sharedFile.name });
    } catch (error) {
      // Cancelled by the user.
      if ((error as { name?: string })?.name !== 'AbortError')
        this.showStatus('Couldn’t share; the file is saved.', true);
    }
  }

  /** Waits for all smoothed masks; returns null if smoothing is off. */
  async waitForSmoothing(signal: AbortSignal): Promise<MaskSource | null> {
    const { smoothedMasks } = this.store.state;
    const clock = startClock();
    const tick = setInterval(() => {
      if (this.store.state.smoothedMasks) showProgress(this.store.state.smoothedMasks, clock);
    }, TICK_MS);
    try {
      return smoothedMasks && (await untilAborted(smoothedMasks.complete, signal));
    } finally {
      clearInterval(tick);
    }
  }

  setBusy(busy: boolean) {
    const subject = this.source();
    for (const { choice, button } of this.choices)
      button.disabled = busy || !subject || choice.isAvailable?.(subject) === false;
    byId('export-progress').hidden = byId('export-cancel').hidden = !busy;
    byId('export-run').hidden = busy;
    showProgress({ done: 0, total: 0 });
  }

  showStatus(text: string, isError = false) {
    byId('export-status').textContent = text;
    byId('export-status').classList.toggle('is-error', isError);
  }

  async showRecipe() {
    const { state } = this.store;
    const masks = this.source()?.masks;
    if (!this.recipeBox.open || !masks || !state.job) return;
    const corrections = state.job.corrector?.undoCount() ?? 0;
    this.recipe = await createRecipe({ version, job: state.job, masks, corrections });
    byId('recipe').textContent = this.recipe;
  }

  /** @param doneText status shown when copied */
  async copy(text: string, doneText: string) {
    try {
      await navigator.clipboard.writeText(text);
      this.showStatus(doneText);
    } catch {
      this.showStatus(`Clipboard access is blocked. Copy it here: ${text}`, true);
    }
  }
}

/** Starts a clock of frames to be made. */
function startClock(): StageClock {
  const clock = new StageClock([{ id: 'frames', cost: 1 }]);
  clock.start();
  return clock;
}

/** @param progress its total is 0 before the first step */
function showProgress({ done, total }: { done: number; total: number }, clock?: StageClock) {
  clock?.mark('frames', done, total);
  const share = total > 0 ? done / total : 0;
  byId('export-bar').style.setProperty('--share', String(share));
  byId('export-bar').setAttribute('aria-valuenow', String(Math.round(100 * share)));
  const msLeft = clock?.timeLeft(performance.now()) ?? null;
  byId('export-count').textContent = describeProgress({ done, total }, msLeft);
}

/** Draws roughly what a choice saves of the frame on screen, until its preview is made. */
function drawSketch({ id }: Choice, viewer: Page['viewer']): HTMLCanvasElement | null {
  const { image, width, height } = viewer.view;
  const mask = viewer.edgedMask();
  if (!image || !mask) return null;
  const canvas = h('canvas', { width, height });
  const ctx = canvas.getContext('2d')!;
  const background = id === 'green' ? SCREEN_GREEN : id === 'blurred' ? 'blurred' : 'transparent';
  drawCutout(ctx, image, mask, { background });
  return canvas;
}

function isCancel(error: unknown) {
  return error instanceof DOMException && error.name === 'AbortError';
}

function describeError(error: unknown) {
  const { title, advice, detail } = explain(error, PLAYS_MP4);
  return [title, advice, detail].filter(Boolean).join('. ');
}

/** Time until the URL of a saved file is released, in milliseconds; chosen by eye. */
const URL_LIFETIME_MS = 60_000;

/** The browser's file picker, where it exists. */
type Picker = (options: { suggestedName: string }) => Promise<{ createWritable: () => Promise<WritableStream> }>;

/**
 * Chooses the destination of a stream: a picked file, or memory. Needs a recent click.
 * @returns saves a stream and resolves to its size in bytes
 */
export async function chooseDestination(
  file: string,
  type: string,
): Promise<(stream: ReadableStream<Uint8Array<ArrayBuffer>>, signal: AbortSignal) => Promise<number>> {
  const pick = (globalThis as { showSaveFilePicker?: Picker }).showSaveFilePicker;
  if (!pick)
    return async (stream) => {
      // Browsers store large blobs on disk.
      const blob = await new Response(stream, { headers: { 'Content-Type': type } }).blob();
      download(blob, file);
      return blob.size;
    };
  const handle = await pick.call(globalThis, { suggestedName: file });
  return async (stream, signal) => {
    let size = 0;
    const counted = stream.pipeThrough(
      new TransformStream({
        transform(piece, controller) {
          size += piece.length;
          controller.enqueue(piece);
        },
      }),
    );
    // Unfinished files are discarded.
    await counted.pipeTo(await handle.createWritable(), { signal });
    return size;
  };
}

export function download(blob: Blob, file: string) {
  const url = URL.createObjectURL(blob);
  h('a', { href: url, download: file }).click();
  setTimeout(() => URL.revokeObjectURL(url), URL_LIFETIME_MS);
}

type SizedSource = Pick<Subject, 'masks' | 'source' | 'fps'>;

export class ExportOptions {
  size = byId<HTMLSelectElement>('export-size');
  customSide = byId<HTMLInputElement>('export-side');
  quality = byId<HTMLSelectElement>('export-quality');
  withSound = byId<HTMLInputElement>('export-sound');
  source: SizedSource | null = null;
  sizes: ReturnType<typeof exportSizes> = [];
  onChange = () => {};
  /** Soundtrack of the source. */
  sound: SoundInfo | null = null;

  constructor() {
    for (const control of [this.size, this.customSide, this.quality, this.withSound])
      control.addEventListener('input', () => this.show());
  }

  /** Shows the options of a source; keeps the chosen ones if it is the same. */
  async open(source: SizedSource) {
    const isSame = source.source === this.source?.source;
    this.source = source;
    this.sizes = exportSizes(source.source, source.masks);
    const before = this.size.value;
    this.size.replaceChildren(...this.sizes.map(({ name, label }) => h('option', { value: name }, label)));
    this.size.value = isSame && this.sizes.some(({ name }) => name === before) ? before : this.sizes[0].name;
    if (!isSame) {
      this.sound = null;
      this.customSide.max = String(Math.max(source.source.width, source.source.height));
      this.customSide.value = String(Math.max(source.masks.width, source.masks.height));
    }
    this.show();
    if (isSame || !source.source.file) return;
    const sound = await soundInfo(source.source.file).catch(() => null);
    if (this.source !== source) return;
    this.sound = sound;
    this.show();
  }

  /** Long side of the export, in pixels. */
  get side() {
    const preset = this.sizes.find(({ name }) => name === this.size.value);
    if (preset?.name !== 'own') return preset?.side ?? 0;
    const typed = Math.round(Number(this.customSide.value));
    return Math.min(preset.side, Math.max(MIN_SIDE_PX, Number.isFinite(typed) ? typed : MIN_SIDE_PX));
  }

  get values() {
    return { side: this.side, quality: this.quality.value as VideoQuality };
  }

  /** Returns the options of the soundtrack; null for none. */
  soundFor(format: SoundInfo['formats'][number]): SoundOptions | null {
    const { source, sound, withSound } = this;
    if (!source?.source.file || !source.masks.times || !withSound.checked || !sound?.formats.includes(format))
      return null;
    const start = source.masks.times[0];
    return { source: source.source.file, start, end: start + computeDuration(source.masks, source.fps) };
  }

  /** Describes the size and the length of what is saved; of videos its bytes too. */
  describe(areImages: boolean): string {
    const { source } = this;
    if (!source) return '';
    const size = fitSize(source.source, this.side);
    if (areImages) return describeImages(size, source.masks.numFrames);
    return describeVideo(size, source, this.values.quality);
  }

  show() {
    this.onChange();
    byId('export-custom').hidden = this.size.value !== 'own';
    byId('export-with-sound').hidden = !this.sound;
    byId('export-sound-facts').textContent = describeSound(this.sound);
  }
}
