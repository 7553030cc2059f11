// Wires the page: a clip goes into the core frame by frame, and each stage of the method is drawn over its frames.

import { TraceCutError } from 'tracecut';
import { fitFrame } from 'tracecut/draw';
import { Clip, DEFAULT_TAKE, fetchHandedOver } from './clip.js';
import { byId, h, number } from './dom.js';
import { LAYERS } from './layers.js';
import { Parameters } from './parameters.js';
import { segment } from './run.js';
import { STAGES } from './stages.js';
import { takeForm } from './take.js';
import { WhyPanel } from './why.js';

/** Least width of the canvas in pixels, so that lines are fine on small clips. */
const CANVAS_WIDTH = 1200;

/** How long a changed parameter waits for others before the clip is segmented again, in milliseconds. */
const CHANGE_DELAY = 400;

/** Stages of the core, for the progress bar. */
const WORK = STAGES.flatMap(({ work }) => work);

const canvas = /** @type {HTMLCanvasElement} */ (byId('canvas'));
const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
const scrub = /** @type {HTMLInputElement} */ (byId('scrub'));
const progress = /** @type {HTMLProgressElement} */ (byId('progress'));
const opacity = /** @type {HTMLInputElement} */ (byId('opacity'));
const preset = /** @type {HTMLSelectElement} */ (byId('preset'));

const page = {
  clip: new Clip([], DEFAULT_TAKE),
  /** @type {import('./run.js').Run | null} */
  run: null,
  abort: new AbortController(),
  t: 0,
  stage: 'clusters',
  isPlaying: false,
  /** Grows with each drawing: earlier ones that still wait for data are void. */
  drawing: 0,
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  change: undefined,
};

const parameters = new Parameters(() => {
  preset.value = parameters.preset;
  const count = parameters.values.size;
  byId('reset').hidden = count === 0 && parameters.preset === 'default';
  byId('changes').textContent = count > 0 ? `${count} changed` : '';
  clearTimeout(page.change);
  page.change = setTimeout(start, CHANGE_DELAY);
});
const take = takeForm((chosen) => open(page.clip.files, chosen));
const why = new WhyPanel({ onPlace: explain, redraw: draw });
const cards = new Map(STAGES.map((stage, k) => [/** @type {string} */ (stage.id), card(stage, k)]));

// Clip and run

/**
 * Opens a clip and segments it.
 * @param {File[]} files none for the sample
 * @param {import('./clip.js').Take} [chosen]
 */
async function open(files, chosen = DEFAULT_TAKE) {
  page.clip = new Clip(files, chosen);
  page.t = 0;
  byId('clip-name').textContent = page.clip.name;
  take.show(chosen, files.length > 0);
  await start();
}

/** Opens what the studio has handed over if it leads here, else the sample. */
async function openFirst() {
  const { files, start: seconds } = location.hash === '#clip' ? await fetchHandedOver() : { files: [], start: 0 };
  await open(files, { ...DEFAULT_TAKE, start: seconds });
}

/** Opens files that the user has chosen. @param {Iterable<File>} files */
function openChosen(files) {
  history.replaceState(null, '', location.pathname);
  return open([...files]);
}

/** Segments the clip with the parameters as they are. What is under way ends. */
async function start() {
  clearTimeout(page.change);
  page.abort.abort();
  page.run?.close();
  page.run = null;
  why.clear();
  pause();
  const { signal } = (page.abort = new AbortController());
  showState('running', 'Starting…');
  try {
    const run = await segment(page.clip, parameters.options(), { signal, onFrame, onProgress });
    if (signal.aborted) return run.close();
    page.run = run;
    page.t = Math.min(page.t, run.result.numFrames - 1);
    showState('done', summary(run));
    showFrame();
  } catch (error) {
    if (signal !== page.abort.signal) return;
    if (signal.aborted) showState('stopped', 'Cancelled.');
    else fail(error);
  }

  /** @type {(frame: import('./clip.js').Frame, t: number) => void} */
  function onFrame(_, t) {
    if (signal.aborted) return;
    page.t = t;
    showFrame();
    byId('status').textContent = 'Frames go in…';
  }

  /** @param {import('tracecut').Progress} state */
  function onProgress({ stage, done, total }) {
    if (signal.aborted) return;
    progress.value = (WORK.indexOf(stage) + done / total) / WORK.length;
    const current = STAGES.findIndex(({ work }) => work.includes(stage));
    byId('status').textContent = `${STAGES[current]?.title}…`;
  }
}

/** @param {import('./run.js').Run} run */
function summary({ result }) {
  const { objects, numFrames } = result;
  const found = objects
    ? `${objects.length} moving ${objects.length === 1 ? 'object' : 'objects'}`
    : `${result.clusters.count} clusters`;
  const of = page.clip.total && page.clip.total > numFrames ? ` of ${number(page.clip.total)}` : '';
  const damage = page.clip.damage && ` The file is damaged after these: ${page.clip.damage}.`;
  return `${found} in ${number(numFrames)}${of} frames.${damage}`;
}

/**
 * @param {'running' | 'done' | 'stopped' | 'error'} state
 * @param {string} text
 */
function showState(state, text) {
  document.body.dataset.state = state;
  byId('status').textContent = text;
  byId('cancel').hidden = state !== 'running';
  byId('again').hidden = state !== 'stopped';
  byId('error').hidden = state !== 'error';
  progress.hidden = state !== 'running';
  progress.value = 0;
  for (const { time, facts, key } of cards.values()) {
    time.textContent = '';
    facts.textContent = '';
    key.replaceChildren();
  }
  if (!page.run) return;
  for (const { id, work } of STAGES) {
    const seconds = work.reduce((sum, name) => sum + (page.run?.result.seconds[name] ?? 0), 0);
    const { time } = /** @type {ReturnType<typeof card>} */ (cards.get(id));
    time.textContent = seconds > 0 ? `${number(seconds, 1)} s` : '';
  }
}

/** What to do about an error, by its code. @type {Record<string, string>} */
const ADVICE = {
  'too-few-frames': 'Motion needs at least two frames. Open a video, or take more of its frames.',
  'no-video': 'Open a video, an animated image, or the images of a sequence.',
  codec: 'This browser cannot decode it. Open an MP4 or WebM file.',
  memory: 'Take fewer or smaller frames: see Frames.',
  param: 'Reset the parameters, or correct the one named above.',
  poisoned: 'The core has stopped on an error of its own. Running again starts a new one.',
};

/** Shows an error in place of the picture. @param {unknown} error */
function fail(error) {
  const code = error instanceof TraceCutError ? error.code : '';
  page.run?.close();
  page.run = null;
  why.clear();
  pause();
  showState('error', 'Failed.');
  byId('error-text').textContent = error instanceof Error ? error.message : String(error);
  byId('error-advice').textContent = ADVICE[code] ?? 'Run again, or open another clip.';
}

// Picture

/** Shows frame `page.t` and what the open stage found in it. */
function showFrame() {
  const count = Math.max(page.clip.frames.length, 1);
  scrub.max = String(count - 1);
  scrub.value = String(page.t);
  scrub.setAttribute('aria-valuetext', `Frame ${page.t + 1} of ${count}`);
  byId('counter').textContent = `${page.t + 1} / ${count}`;
  if (why.place && page.run && !page.isPlaying) explain(why.place.x, why.place.y);
  return draw();
}

/** Draws the frame; once the data is there, the layer over it. */
async function draw() {
  page.drawing += 1;
  const mine = page.drawing;
  const { run, t } = page;
  const image = page.clip.frames[t]?.canvas;
  if (!image) return;
  const unit = drawImage(image);
  const stage = /** @type {ReturnType<typeof card>} */ (cards.get(page.stage));
  canvas.setAttribute('aria-label', `Frame ${t + 1} with ${stage.title}`);
  if (!run) return;
  /** @type {import('./layers.js').Layer} */
  const layer = LAYERS[/** @type {keyof typeof LAYERS} */ (page.stage)];
  const view = { run, result: run.result, t, image, unit, mode: stage.mode.value };
  try {
    const data = await layer.load?.(view);
    if (mine !== page.drawing) return;
    drawImage(image);
    context.save();
    context.globalAlpha = opacity.valueAsNumber;
    layer.draw(context, view, data);
    context.restore();
    why.draw(context, t, unit);
    stage.facts.textContent = layer.facts?.(view, data) ?? '';
    stage.key.replaceChildren(...(layer.key?.(view, data) ?? []).map(keyEntry));
    canvas.dataset.drawn = `${page.stage} ${view.mode} ${t}`;
  } catch (error) {
    if (mine === page.drawing) fail(error);
  }
}

/**
 * Draws a frame alone, on a canvas of a multiple of its size.
 * @param {OffscreenCanvas} image
 * @returns {number} pixels of the frame for one of the canvas
 */
function drawImage(image) {
  const scale = Math.max(1, Math.ceil(CANVAS_WIDTH / image.width));
  const [width, height] = [scale * image.width, scale * image.height];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const unit = fitFrame(context, image);
  context.globalAlpha = 1;
  context.drawImage(image, 0, 0);
  return unit;
}

/** @param {import('./layers.js').KeyEntry} entry */
function keyEntry({ colors, text }) {
  const swatches = colors.map((color) => {
    const swatch = h('span', { class: 'swatch' });
    swatch.style.background = color;
    return swatch;
  });
  return h('li', {}, h('span', { class: 'swatches', 'aria-hidden': 'true' }, ...swatches), text);
}

/** @param {number} t */
function seek(t) {
  page.t = Math.min(Math.max(t, 0), Math.max(page.clip.frames.length - 1, 0));
  return showFrame();
}

/** Plays in a loop; each frame waits for its layer. */
async function play() {
  page.isPlaying = true;
  showPlaying();
  while (page.isPlaying && page.clip.frames.length > 1) {
    const due = performance.now() + page.clip.frameDuration;
    await seek((page.t + 1) % page.clip.frames.length);
    await new Promise((done) => setTimeout(done, Math.max(0, due - performance.now())));
  }
}

function pause() {
  page.isPlaying = false;
  showPlaying();
}

function showPlaying() {
  byId('play').textContent = page.isPlaying ? 'Pause' : 'Play';
}

/**
 * Explains a pixel of the frame that is shown.
 * @param {number} x
 * @param {number} y
 */
async function explain(x, y) {
  if (!page.run?.result.masks) return;
  pause();
  const { run } = page;
  const within = (/** @type {number} */ value, /** @type {number} */ size) =>
    Math.min(size - 1, Math.max(0, Math.floor(value)));
  const { width, height } = run.result;
  try {
    await why.ask(run, page.t, within(x, width), within(y, height));
  } catch (error) {
    if (run === page.run) fail(error);
  }
}

// Stages

/**
 * Builds the card of a stage: its explanation, how it is drawn, and its parameters.
 * @param {import('./stages.js').Stage} stage
 * @param {number} k
 */
function card({ id, title, section, text, groups }, k) {
  const { modes = [] } = /** @type {import('./layers.js').Layer} */ (LAYERS[id]);
  const time = h('span', { class: 'time' });
  const mode = h(
    'select',
    { id: `mode-${id}`, change: draw },
    ...modes.map(([value, name]) => h('option', { value }, name)),
  );
  const facts = h('p', { class: 'facts' });
  const key = h('ul', { class: 'key' });
  const body = h(
    'div',
    { class: 'stage-body', id: `stage-${id}`, hidden: true },
    h('p', {}, text),
    ...(modes.length > 0 ? [h('label', { class: 'mode', for: mode.id }, 'Show ', mode)] : []),
    key,
    facts,
    ...(id === 'frames' ? [take.element] : []),
    parameters.list(groups),
  );
  const button = h(
    'button',
    { type: 'button', 'aria-expanded': 'false', 'aria-controls': body.id, click: () => openStage(id) },
    h('span', { class: 'place', 'aria-hidden': 'true' }, String(k + 1)),
    h('span', { class: 'title' }, title),
    ...(section ? [h('span', { class: 'section' }, `§${section}`)] : []),
    time,
  );
  byId('stages').append(h('li', { class: 'stage' }, h('h3', {}, button), body));
  return { title, time, mode, facts, key, body, button };
}

/** Opens one stage, which is drawn from now on. @param {string} id */
function openStage(id) {
  page.stage = id;
  for (const [other, { body, button }] of cards) {
    body.hidden = other !== id;
    button.setAttribute('aria-expanded', String(other === id));
  }
  cards.get(id)?.button.scrollIntoView({ block: 'nearest' });
  return draw();
}

// Controls

const file = /** @type {HTMLInputElement} */ (byId('file'));
for (const id of ['open', 'error-open']) byId(id).addEventListener('click', () => file.click());
for (const id of ['sample', 'error-sample']) byId(id).addEventListener('click', () => openChosen([]));
for (const id of ['again', 'error-again']) byId(id).addEventListener('click', start);
for (const id of ['reset', 'error-reset']) byId(id).addEventListener('click', () => parameters.reset());
byId('cancel').addEventListener('click', () => page.abort.abort());
byId('back').addEventListener('click', () => seek(page.t - 1));
byId('forward').addEventListener('click', () => seek(page.t + 1));
byId('play').addEventListener('click', () => (page.isPlaying ? pause() : play()));
scrub.addEventListener('input', () => seek(scrub.valueAsNumber));
opacity.addEventListener('input', draw);
preset.addEventListener('change', () => parameters.choosePreset(/** @type {Parameters['preset']} */ (preset.value)));
file.addEventListener('change', () => {
  if (file.files?.length) openChosen(file.files);
  file.value = '';
});
canvas.addEventListener('click', (event) => {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  const image = page.clip.frames[page.t]?.canvas;
  if (image) explain(((event.clientX - left) / width) * image.width, ((event.clientY - top) / height) * image.height);
});
document.addEventListener('dragover', (event) => event.preventDefault());
document.addEventListener('drop', (event) => {
  event.preventDefault();
  if (event.dataTransfer?.files.length) openChosen(event.dataTransfer.files);
});
document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === 'Escape') return page.run ? clearWhy() : page.abort.abort();
  if (event.target instanceof Element && event.target.closest('input, select')) return;
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (!step) return;
  event.preventDefault();
  pause();
  seek(page.t + step);
});

function clearWhy() {
  why.clear();
  draw();
}

openStage(page.stage);
openFirst();
