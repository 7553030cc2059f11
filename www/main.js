// Wires the page: runs the core on a clip and draws each stage of the method over its frames.

import { fitFrame } from 'tracecut/draw';
import { Clip, DEFAULT_SELECTION, fetchStudioClip, segment } from './clip.js';
import { byId, h, number } from './dom.js';
import { LAYERS } from './layers.js';
import { Parameters, selectionForm } from './parameters.js';
import { STAGES } from './stages.js';
import { Why } from './why.js';

/** Minimum width of the canvas in pixels, so that lines are fine on small clips. */
const MIN_CANVAS_WIDTH = 1200;

/** Delay after a changed parameter before the clip is segmented again, in milliseconds. */
const CHANGE_DELAY_MS = 400;

/** Stages of the core, for the progress bar. */
const CORE_STAGES = STAGES.flatMap(({ coreStages }) => coreStages);

/** Advice for errors, by their code. */
const ADVICE = {
  'too-few-frames': 'Motion needs at least two frames: open a video, or use more of its frames.',
  'no-video': 'Open a video, an animated image, or the images of a sequence.',
  codec: 'This browser cannot decode the file: try MP4 or WebM.',
  memory: 'Use fewer or smaller frames (stage 1).',
  param: 'Correct this parameter, or reset all.',
  poisoned: 'The core crashed. A new run starts a new one.',
};

const [canvas, scrub, progress, opacity, preset] = ['canvas', 'scrub', 'progress', 'opacity', 'preset'].map(byId);
const context = canvas.getContext('2d');

let clip = new Clip([]);
/** @type {import('./clip.js').Run} The finished run, if there is one. */
let run = null;
let abort = new AbortController();
/** The current frame and stage. */
let t = 0;
let currentStage = 'clusters';
/** The current playback loop, if there is one. */
let playback = null;
/** Number of drawings so far: a drawing that waited for its data stops if another has started. */
let drawings = 0;
/** The core's pending query for a drawing: one at a time, and none for frames that were skipped meanwhile. */
let loading = Promise.resolve(null);
let changeTimer;

const why = new Why();
const form = selectionForm((selection) => open(clip.files, selection));
const parameters = new Parameters(() => {
  const { size } = parameters.values;
  preset.value = parameters.preset;
  byId('changes').textContent = size > 0 ? `${size} changed` : '';
  byId('reset').hidden = size === 0 && parameters.preset === 'default';
  clearTimeout(changeTimer);
  changeTimer = setTimeout(start, CHANGE_DELAY_MS);
});
const cards = new Map(STAGES.map((stage, k) => [stage.id, addCard(stage, k + 1)]));

// Clip and run

/** Opens a clip and segments it; without files, the sample. */
async function open(files, selection = DEFAULT_SELECTION) {
  clip = new Clip([...files], selection);
  t = 0;
  byId('clip-name').textContent = clip.name;
  seek(0);
  form.show(clip);
  await start();
}

/** Opens the user's files, or the sample, and forgets the studio's clip. */
function openFiles(files) {
  history.replaceState(null, '', location.pathname);
  return open(files);
}

/** Opens the studio's clip if the studio linked here, else the sample. */
async function openFirst() {
  const { files, start } = location.hash === '#clip' ? await fetchStudioClip() : { files: [], start: 0 };
  await open(files, { ...DEFAULT_SELECTION, start });
}

/** Segments the clip with the current parameters, and ends any earlier run. */
async function start() {
  end();
  const { signal } = (abort = new AbortController());
  const isNew = !clip.isDecoded;
  showState('running', 'Starting…');
  try {
    const finished = await segment(clip, parameters.options(), { signal, onFrame, onProgress });
    if (signal.aborted) return finished.close();
    run = finished;
    showState('done', summary(run.result));
    seek(isNew ? run.result.numFrames >> 1 : t);
  } catch (error) {
    if (signal !== abort.signal) return;
    if (signal.aborted) showState('stopped', 'Cancelled.');
    else fail(error);
  }

  function onFrame(index) {
    if (signal.aborted) return;
    byId('status').textContent = 'Reading frames…';
    if (isNew) seek(index);
  }

  function onProgress({ stage, done, total }) {
    if (signal.aborted) return;
    progress.value = (CORE_STAGES.indexOf(stage) + done / total) / CORE_STAGES.length;
    byId('status').textContent = `${STAGES.find(({ coreStages }) => coreStages.includes(stage)).title}…`;
  }
}

/** Ends the current run and drops its result. */
function end() {
  clearTimeout(changeTimer);
  abort.abort();
  run?.close();
  run = null;
  why.clear();
  pause();
  draw();
}

/** @param {import('tracecut').Result} result */
function summary({ objects, clusters, masks, numFrames }) {
  const hasMasks = masks.length > 0;
  const count = hasMasks ? objects.length : clusters.count;
  const kind = hasMasks ? 'moving object' : 'cluster';
  const total = clip.total > numFrames ? ` of ${number(clip.total)}` : '';
  const damage = clip.damage && ` The rest of the file is damaged: ${clip.damage}.`;
  return `${number(count)} ${kind}${count === 1 ? '' : 's'} in ${number(numFrames)}${total} frames.${damage}`;
}

/** @param {'running' | 'done' | 'stopped' | 'error'} state */
function showState(state, text) {
  document.body.dataset.state = state;
  byId('status').textContent = text;
  byId('cancel').hidden = progress.hidden = state !== 'running';
  byId('again').hidden = state !== 'stopped';
  byId('error').hidden = state !== 'error';
  progress.value = 0;
  for (const { id, coreStages } of STAGES) {
    const { time, facts, legend } = cards.get(id);
    const seconds = coreStages.reduce((sum, name) => sum + (run?.result.seconds[name] ?? 0), 0);
    time.textContent = seconds > 0 ? `${number(seconds, 1)} s` : '';
    facts.textContent = '';
    legend.replaceChildren();
  }
}

/** Shows an error instead of the picture, with ways to continue. */
function fail(error) {
  end();
  showState('error', 'Failed.');
  byId('error-text').textContent = error.message;
  byId('error-advice').textContent = ADVICE[error.code] ?? 'Run again, or open another clip.';
}

// Picture

/** Shows a frame. */
function seek(index) {
  const { length } = clip.frames;
  t = Math.max(0, Math.min(index, length - 1));
  scrub.max = Math.max(0, length - 1);
  scrub.value = t;
  scrub.setAttribute('aria-valuetext', `Frame ${t + 1} of ${length}`);
  byId('counter').textContent = length > 0 ? `${t + 1} / ${length}` : '';
  if (why.pixel && !playback) explain(why.pixel.x, why.pixel.y);
  return draw();
}

/** Draws the frame and, once its data is loaded, the layer of the current stage. */
async function draw() {
  drawings += 1;
  const drawing = drawings;
  const image = clip.frames[t]?.canvas;
  if (!image) return;
  const card = cards.get(currentStage);
  const layer = LAYERS[currentStage];
  // During playback the previous layer stays until this one is ready.
  if (!playback || !run) drawImage(image);
  const view = { run, result: run?.result, t, image, mode: card.mode.value, unit: image.width / canvas.width };
  canvas.setAttribute('aria-label', `Frame ${t + 1}: ${card.title}`);
  if (!run) return;
  try {
    await loading;
    if (drawing !== drawings) return;
    const query = Promise.resolve(layer.load?.(view));
    loading = query.catch(() => null);
    const data = await query;
    if (drawing !== drawings) return;
    drawImage(image);
    context.save();
    context.globalAlpha = opacity.valueAsNumber;
    layer.draw(context, view, data);
    context.restore();
    why.draw(context, view);
    card.facts.textContent = layer.facts(view, data);
    card.legend.replaceChildren(...(layer.legend?.(view, data) ?? []).map(legendEntry));
    canvas.dataset.drawn = `${currentStage} ${view.mode} ${t}`;
  } catch (error) {
    if (drawing !== drawings) return;
    // The parameters turned the stage off.
    if (error.code === 'state') card.facts.textContent = error.message;
    else fail(error);
  }
}

/** Draws a frame on the canvas, whose size is a multiple of the frame's. */
function drawImage(image) {
  const scale = Math.max(1, Math.ceil(MIN_CANVAS_WIDTH / image.width));
  const [width, height] = [scale * image.width, scale * image.height];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  fitFrame(context, image);
  context.drawImage(image, 0, 0);
}

function legendEntry([colors, text]) {
  const swatches = colors.map((color) => {
    const swatch = h('span', { class: 'swatch', 'aria-hidden': 'true' });
    swatch.style.background = color;
    return swatch;
  });
  return h('li', {}, h('span', { class: 'swatches' }, ...swatches), text);
}

/** Plays in a loop; waits for each layer to be drawn. */
async function play() {
  const loop = (playback = {});
  byId('play').textContent = 'Pause';
  while (loop === playback && clip.frames.length > 1) {
    const due = performance.now() + clip.frameDuration;
    await seek((t + 1) % clip.frames.length);
    await new Promise((done) => setTimeout(done, due - performance.now()));
  }
}

function pause() {
  playback = null;
  byId('play').textContent = 'Play';
}

/** Explains the pixel at `x`, `y` of the current frame. */
async function explain(x, y) {
  if (!run?.result.masks) return;
  const explained = run;
  const { width, height } = run.result;
  const clampPixel = (value, size) => Math.max(0, Math.min(Math.floor(value), size - 1));
  pause();
  try {
    await why.ask(run, t, clampPixel(x, width), clampPixel(y, height));
    await draw();
  } catch (error) {
    if (explained === run) fail(error);
  }
}

// Stages

/** Adds the card of a stage: its explanation, drawing modes and parameters. */
function addCard({ id, title, section, text, groups }, position) {
  const modes = Object.entries(LAYERS[id].modes ?? {}).map(([value, name]) => h('option', { value }, name));
  const mode = h('select', { id: `mode-${id}`, change: draw }, ...modes);
  const legend = h('ul', { class: 'legend' });
  const facts = h('p', { class: 'facts' });
  const time = h('span', { class: 'time' });
  const body = h(
    'div',
    { class: 'stage-body', id: `stage-${id}` },
    h('p', {}, text),
    h('label', { class: 'mode', hidden: modes.length === 0 }, 'Show ', mode),
    legend,
    facts,
    ...(id === 'frames' ? [form.element] : []),
    parameters.list(groups),
  );
  const button = h(
    'button',
    { type: 'button', 'aria-controls': body.id, click },
    h('span', { class: 'position' }, String(position)),
    h('span', { class: 'title' }, title),
    h('span', { class: 'section' }, section && `§${section}`),
    time,
  );
  byId('stages').append(h('li', { class: 'stage' }, h('h3', {}, button), body));
  return { title, body, button, time, mode, legend, facts };

  function click() {
    openStage(id);
    // The open card may have been above.
    button.scrollIntoView({ block: 'nearest' });
  }
}

/** Opens the card of a stage and draws the stage. */
function openStage(id) {
  currentStage = id;
  for (const [stage, { body, button }] of cards) {
    body.hidden = stage !== id;
    button.setAttribute('aria-expanded', String(stage === id));
  }
  draw();
}

// Controls

const ON_CLICK = {
  open: () => byId('file').click(),
  sample: () => openFiles([]),
  again: start,
  reset: () => parameters.reset(),
  cancel: () => abort.abort(),
  play: () => (playback ? pause() : play()),
  back: () => seek(t - 1),
  forward: () => seek(t + 1),
};
for (const [id, act] of Object.entries(ON_CLICK))
  for (const button of [byId(id), byId(`error-${id}`)]) button?.addEventListener('click', act);

scrub.addEventListener('input', () => seek(scrub.valueAsNumber));
opacity.addEventListener('input', draw);
preset.addEventListener('change', () => parameters.choosePreset(preset.value));
byId('file').addEventListener('change', ({ target }) => {
  if (target.files.length > 0) openFiles(target.files);
  target.value = '';
});
byId('why-form').addEventListener('submit', (event) => {
  event.preventDefault();
  explain(event.target.x.valueAsNumber, event.target.y.valueAsNumber);
});
canvas.addEventListener('click', ({ clientX, clientY }) => {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  const image = clip.frames[t].canvas;
  byId('why').scrollIntoView({ block: 'nearest' });
  explain(((clientX - left) / width) * image.width, ((clientY - top) / height) * image.height);
});
document.addEventListener('dragover', (event) => event.preventDefault());
document.addEventListener('drop', (event) => {
  event.preventDefault();
  if (event.dataTransfer.files.length > 0) openFiles(event.dataTransfer.files);
});
document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === 'Escape' && !run) abort.abort();
  if (event.key === 'Escape' && run) {
    why.clear();
    draw();
  }
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (!step || /** @type {Element} */ (event.target).closest('input, select, .scroll')) return;
  event.preventDefault();
  pause();
  seek(t + step);
});

openStage(currentStage);
openFirst();
