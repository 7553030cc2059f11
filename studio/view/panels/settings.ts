// The sheet that makes a result again: other settings, another part and size of the clip, and the link to the lab, which
// opens the clip that is open here.

import { byId, connectDialog, h } from '../dom.js';
import {
  otherChanges,
  sessionOptions,
  SETTING_CHOICES,
  type SettingChoice,
  type Settings,
} from '../../model/settings.js';
import { formatPlural } from '../../model/messages.js';
import { describeClip, describeTrim, frameFormatter, trimFromInputs } from '../../model/clip-text.js';
import { clampTrim, type Source, type Trim } from '../../model/source.js';
import type { State, Store } from '../../model/store.js';
import type { Page } from '../page.js';

export function settingsPanel({ app, store, settings }: Pick<Page, 'app' | 'store' | 'settings'>) {
  const dialog = byId<HTMLDialogElement>('redo');
  connectDialog(dialog);
  byId('redo-open').addEventListener('click', () => dialog.showModal());
  byId('redo-close').addEventListener('click', () => dialog.close());
  byId('redo-run').addEventListener('click', () => {
    dialog.close();
    void app.rerun();
  });
  byId('settings-list').append(...SETTING_CHOICES.map((choice) => createRow(settings, choice)));
  byId('settings-reset').addEventListener('click', () => settings.resetAll());
  store.watch(['changed'], showChanged);
  store.watch(['phase', 'job', 'trim', 'changed'], (state) => store.set({ isOutdated: isPending(state) }));
  store.watch(['isOutdated'], ({ isOutdated }) => document.body.toggleAttribute('data-outdated', isOutdated));
}

function showChanged(state: Readonly<State>) {
  const others = otherChanges(state);
  byId('settings-others').hidden = others.length === 0;
  byId('settings-others').textContent = `Also changed: ${others.join(', ')}.`;
  byId('settings-reset').hidden = state.changed.size === 0;
  byId('settings-reset').title = formatPlural(state.changed.size, 'changed setting');
}

/** Returns whether the settings have changed since the run. */
function isPending(state: Readonly<State>) {
  const { phase, job, trim } = state;
  return phase === 'done' && job !== null && !job.hasSettings(trim, sessionOptions(state));
}

function createRow(settings: Settings, { name, label, options }: SettingChoice): HTMLElement {
  const radios = options.map(({ label: text, value }) => {
    const input = h('input', { type: 'radio', name, value: value ?? 'default' });
    input.addEventListener('input', () => (value === null ? settings.reset(name) : settings.set(name, value)));
    return { value, input, element: h('label', {}, input, h('span', {}, text)) };
  });
  settings.store.watch(['changed'], ({ changed }) => {
    for (const { value, input } of radios) input.checked = (changed.get(name) ?? null) === value;
  });
  return h(
    'fieldset',
    { class: 'setting', 'data-parameter': name },
    h('legend', {}, label),
    h('span', { class: 'segmented' }, ...radios.map(({ element }) => element)),
  );
}

export function clipPanel({ store }: Pick<Page, 'store'>) {
  new ClipPanel(store);
}

class ClipPanel {
  start = byId<HTMLInputElement>('clip-start');
  frames = byId<HTMLInputElement>('clip-frames');
  step = byId<HTMLSelectElement>('clip-step');
  side = byId<HTMLSelectElement>('clip-side');

  constructor(readonly store: Store) {
    for (const field of [this.start, this.frames, this.step, this.side])
      field.addEventListener('input', (event) => this.setTrim(this.readInputs(event.target)));
    byId('clip-all').addEventListener('click', () =>
      this.setTrim({ ...store.state.trim, start: 0, frames: store.state.source?.count ?? 0 }),
    );
    // The number is corrected only after typing.
    this.frames.addEventListener('blur', () => this.show(store.state));
    store.watch(['source'], ({ source }) => source && this.showSource(source));
    store.watch(['source', 'trim', 'pace'], (state) => this.show(state));
  }

  readInputs(changed: EventTarget | null) {
    const { trim, source } = this.store.state;
    const [start, frames, step, side] = [this.start, this.frames, this.step, this.side].map(({ value }) =>
      Number(value),
    );
    return trimFromInputs({ start, frames, step, side }, trim, source, changed === this.frames);
  }

  /** @param trim clamped to the source */
  setTrim(trim: Trim) {
    const { source } = this.store.state;
    if (source) this.store.set({ trim: clampTrim(trim, source) });
  }

  showSource(source: Source) {
    const isSample = source.kind === 'sample';
    byId('clip-more').hidden = isSample;
    byId('clip-facts').textContent = describeClip(source);
    this.start.max = String(Math.max(0, source.count - 2));
  }

  show({ source, trim, pace }: Readonly<State>) {
    if (!source) return;
    const at = frameFormatter(source);
    this.start.value = String(trim.start);
    this.start.style.setProperty('--share', String(trim.start / Math.max(1, source.count - 2)));
    this.start.setAttribute('aria-valuetext', at(trim.start));
    byId('clip-start-text').textContent = at(trim.start);
    this.step.value = String(trim.step);
    this.side.value = String(trim.side);
    if (document.activeElement !== this.frames) this.frames.value = String(trim.frames);
    byId('clip-all').hidden = trim.start === 0 && 1 + (trim.frames - 1) * trim.step > source.count - trim.step;
    byId('clip-text').textContent = describeTrim(source, trim, pace);
  }
}

/** Cache that the lab reads the clip from. */
const CACHE = 'tracecut-lab';

export function labPanel({ store }: Pick<Page, 'store'>) {
  const link = byId<HTMLAnchorElement>('lab-open');
  link.addEventListener('click', async (event) => {
    const { source, trim } = store.state;
    if (!source?.files) return;
    event.preventDefault();
    // Without storage the lab opens its sample.
    const isKept = await handOver(source, trim).then(
      () => true,
      () => false,
    );
    location.href = isKept ? `${link.href}#clip` : link.href;
  });
}

/** Stores the files of a clip, and the start of the trim in seconds. */
async function handOver({ files = [], times, fps }: Source, { start }: Trim) {
  // Images have no times: those before the start are left out.
  const [sentFiles, seconds] = files.length > 1 ? [files.slice(start), 0] : [files, times?.[start] ?? start / fps];
  await caches.delete(CACHE);
  const cache = await caches.open(CACHE);
  for (const [k, file] of sentFiles.entries()) {
    const headers = { 'content-type': file.type, 'x-name': encodeURIComponent(file.name), 'x-start': String(seconds) };
    await cache.put(`./lab/clip-${k}`, new Response(file, { headers }));
  }
}
