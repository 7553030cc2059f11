// Wires the page: a clip goes into the core frame by frame, and each stage of the method is drawn over its frames.

import { fitFrame } from 'tracecut/draw';
import { Clip, DEFAULT_TAKE, fetchHandedOver } from './clip.js';
import { byId, h, number } from './dom.js';
import { LAYERS } from './layers.js';
import { Parameters } from './parameters.js';
import { segment } from './run.js';
import { STAGES } from './stages.js';
import { takeForm } from './take.js';
import { Why } from './why.js';

/** Least width of the canvas in pixels, so that lines are fine on small clips. */
const MIN_CANVAS_WIDTH = 1200;

/** How long a changed parameter waits for others before the clip is segmented again, in milliseconds. */
const CHANGE_DELAY_MS = 400;

/** Stages of the core, for the progress bar. */
const CORE_STAGES = STAGES.flatMap(({ coreStages }) => coreStages);

/** What to do about an error, by its code. */
const ADVICE = {
  'too-few-frames': 'Motion needs at least two frames: open a video, or take more frames of it.',
  'no-video': 'Open a video, an animated image, or the images of a sequence.',
  codec: 'This browser cannot decode it: try an MP4 or WebM file.',
  memory: 'Take fewer or smaller frames (stage 1).',
  param: 'Reset the parameters, or correct the one that is named.',
  poisoned: 'The core has stopped on an error of its own; a new run starts a new core.',
};

const [canvas, scrub, progress, opacity, preset] = ['canvas', 'scrub', 'progress', 'opacity', 'preset'].map(byId);
const context = canvas.getContext('2d');

let clip = new Clip([]);
/** @type {import('./run.js').Run} The finished run, if there is one. */
let run = null;
let abort = new AbortController();
/** The frame and the stage that are shown. */
let t = 0;
let shown = 'clusters';
/** The loop that plays, if there is one. */
let playing = null;
/** Number of drawings so far: one that has waited for its data is void if another has begun. */
let drawings = 0;
/** What the core is asked for a drawing: one question at a time, and none for frames that were passed meanwhile. */
let loading = Promise.resolve(null);
let changeTimer;

const why = new Why();
const take = takeForm((chosen) => open(clip.files, chosen));
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

/** Opens a clip and segments it; no files for the sample. */
async function open(files, chosen = DEFAULT_TAKE) {
  clip = new Clip([...files], chosen);
  t = 0;
  byId('clip-name').textContent = clip.name;
  seek(0);
  take.show(clip);
  await start();
}

/** Opens what the user has chosen, in place of what the page handed over. */
function openChosen(files) {
  history.replaceState(null, '', location.pathname);
  return open(files);
}

/** Opens what the page hands over if its link leads here, else the sample. */
async function openFirst() {
  const handed = location.hash === '#clip' ? await fetchHandedOver() : { files: [], start: 0 };
  await open(handed.files, { ...DEFAULT_TAKE, start: handed.start });
}

/** Segments the clip with the parameters as they are; what is under way ends. */
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
    byId('status').textContent = 'Frames go in…';
    if (isNew) seek(index);
  }

  function onProgress({ stage, done, total }) {
    if (signal.aborted) return;
    progress.value = (CORE_STAGES.indexOf(stage) + done / total) / CORE_STAGES.length;
    byId('status').textContent = `${STAGES.find(({ coreStages }) => coreStages.includes(stage)).title}…`;
  }
}

/** Ends the run under way, and drops the one that is shown. */
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
function summary({ objects, clusters, numFrames }) {
  const count = objects?.length ?? clusters.count;
  const kind = objects ? 'moving object' : 'cluster';
  const all = clip.total > numFrames ? ` of ${number(clip.total)}` : '';
  const damage = clip.damage && ` The file is damaged after these: ${clip.damage}.`;
  return `${number(count)} ${kind}${count === 1 ? '' : 's'} in ${number(numFrames)}${all} frames.${damage}`;
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

/** Shows an error in place of the picture, and ways on. */
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
  if (why.place && !playing) explain(why.place.x, why.place.y);
  return draw();
}

/** Draws the frame, and once its data is there, the layer of the stage that is shown. */
async function draw() {
  drawings += 1;
  const drawing = drawings;
  const image = clip.frames[t]?.canvas;
  if (!image) return;
  const card = cards.get(shown);
  const layer = LAYERS[shown];
  // While it plays, the layer before stays until this one is there.
  if (!playing || !run) drawImage(image);
  const view = { run, result: run?.result, t, image, mode: card.mode.value, unit: image.width / canvas.width };
  canvas.setAttribute('aria-label', `Frame ${t + 1}: ${card.title}`);
  if (!run) return;
  try {
    await loading;
    if (drawing !== drawings) return;
    const asked = Promise.resolve(layer.load?.(view));
    loading = asked.catch(() => null);
    const data = await asked;
    if (drawing !== drawings) return;
    drawImage(image);
    context.save();
    context.globalAlpha = opacity.valueAsNumber;
    layer.draw(context, view, data);
    context.restore();
    why.draw(context, view);
    card.facts.textContent = layer.facts(view, data);
    card.legend.replaceChildren(...(layer.legend?.(view, data) ?? []).map(legendEntry));
    canvas.dataset.drawn = `${shown} ${view.mode} ${t}`;
  } catch (error) {
    if (drawing !== drawings) return;
    // The parameters left the stage out.
    if (error.code === 'state') card.facts.textContent = error.message;
    else fail(error);
  }
}

/** Draws a frame on a canvas of a multiple of its size. */
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

/** Plays in a loop; each frame waits until its layer is drawn. */
async function play() {
  const loop = (playing = {});
  byId('play').textContent = 'Pause';
  while (loop === playing && clip.frames.length > 1) {
    const due = performance.now() + clip.frameDuration;
    await seek((t + 1) % clip.frames.length);
    await new Promise((done) => setTimeout(done, due - performance.now()));
  }
}

function pause() {
  playing = null;
  byId('play').textContent = 'Play';
}

/** Explains the pixel at `x`, `y` of the frame that is shown. */
async function explain(x, y) {
  if (!run?.result.masks) return;
  const asked = run;
  const { width, height } = run.result;
  const within = (value, size) => Math.max(0, Math.min(Math.floor(value), size - 1));
  pause();
  try {
    await why.ask(run, t, within(x, width), within(y, height));
    await draw();
  } catch (error) {
    if (asked === run) fail(error);
  }
}

// Stages

/** Adds the card of a stage: its explanation, how it is drawn, and its parameters. */
function addCard({ id, title, section, text, groups }, place) {
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
    ...(id === 'frames' ? [take.element] : []),
    parameters.list(groups),
  );
  const button = h(
    'button',
    { type: 'button', 'aria-controls': body.id, click },
    h('span', { class: 'place' }, String(place)),
    h('span', { class: 'title' }, title),
    h('span', { class: 'section' }, section && `§${section}`),
    time,
  );
  byId('stages').append(h('li', { class: 'stage' }, h('h3', {}, button), body));
  return { title, body, button, time, mode, legend, facts };

  function click() {
    openStage(id);
    // The card that was open may have been above.
    button.scrollIntoView({ block: 'nearest' });
  }
}

/** Opens the card of a stage, which is drawn from now on. */
function openStage(id) {
  shown = id;
  for (const [other, { body, button }] of cards) {
    body.hidden = other !== id;
    button.setAttribute('aria-expanded', String(other === id));
  }
  draw();
}

// Controls

const ON_CLICK = {
  open: () => byId('file').click(),
  sample: () => openChosen([]),
  again: start,
  reset: () => parameters.reset(),
  cancel: () => abort.abort(),
  play: () => (playing ? pause() : play()),
  back: () => seek(t - 1),
  forward: () => seek(t + 1),
};
for (const [id, act] of Object.entries(ON_CLICK))
  for (const button of [byId(id), byId(`error-${id}`)]) button?.addEventListener('click', act);

scrub.addEventListener('input', () => seek(scrub.valueAsNumber));
opacity.addEventListener('input', draw);
preset.addEventListener('change', () => parameters.choosePreset(preset.value));
byId('file').addEventListener('change', ({ target }) => {
  if (target.files.length > 0) openChosen(target.files);
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
  if (event.dataTransfer.files.length > 0) openChosen(event.dataTransfer.files);
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

openStage(shown);
openFirst();
