// Saved projects: stores the current one, with a thumbnail, offers the last one, and lists all. Loaded when a clip is opened
// or projects exist.

import * as storage from '../storage.js';
import { byId, connectDialog, h } from '../dom.js';
import { hashClip, Packer, reopenProject, SavedJob, storedFiles } from '../../model/project-file.js';
import {
  Autosave,
  listProjects,
  projectBytes,
  type ProjectVersion,
  rememberRuns,
  type SavedProject,
  saveProject,
} from '../../model/saved-projects.js';
import { formatBytes } from '../../model/messages.js';
import { drawLabels, type MaskSource } from '../../model/library.js';
import { runInSlices } from '../../model/slices.js';
import type { InterruptedRun, RunMemory } from '../../model/interrupted-runs.js';
import type { Source } from '../../model/source.js';
import type { State } from '../../model/store.js';
import type { Page } from '../page.js';

/** A notice with actions; `removable` can be deleted. */
type Notice = {
  text: string;
  action?: () => unknown;
  actionText?: string;
  removable?: { id: string; name: string };
  hasList: boolean;
};

let loading: Promise<RunMemory> | undefined;

/** Loads the memory of interrupted runs. */
export function runMemory() {
  loading ??= import('../../model/interrupted-runs.js').then(
    ({ RunMemory }) => new RunMemory(storage, navigator.locks),
  );
  return loading;
}

export class Projects {
  store: Page['store'];
  app: Page['app'];
  packer = new Packer(makeThumbnail);
  /** True if storage was full at the last save. */
  isFull = false;
  ids = new WeakMap<Source, Promise<string>>();
  urls: string[] = [];
  shownKey = '';
  dialog = byId<HTMLDialogElement>('projects');

  /** @param onRoom called when storage was freed */
  constructor(
    { store, app }: Pick<Page, 'store' | 'app'>,
    readonly onRoom: () => unknown,
  ) {
    this.store = store;
    this.app = app;
    for (const id of ['projects-open', 'recent-all']) byId(id).addEventListener('click', () => this.list());
    byId('projects-close').addEventListener('click', () => this.dialog.close());
    connectDialog(this.dialog);
    store.watch(['source'], () => void this.offerCorrected());
  }

  idOf(source: Source): Promise<string> {
    const id = this.ids.get(source) ?? hashClip(source.files ?? []);
    this.ids.set(source, id);
    return id;
  }

  /** Saves the current project; returns false if storage is full. */
  async save(state: State): Promise<boolean> {
    storedFiles(state);
    const id = await this.idOf(state.source!);
    const project = await this.packer.pack(state, id);
    const isSaved = await saveProject(storage, project).finally(() => void this.update());
    if (!isSaved)
      this.showNotice({
        text: 'Storage is full. Delete a project to save this one.',
        actionText: 'Manage projects…',
        action: () => this.list(),
        hasList: false,
      });
    else if (this.isFull) byId('recent').hidden = true;
    this.isFull = !isSaved;
    return isSaved;
  }

  /** Offers the corrected project of a clip that is opened again. */
  async offerCorrected() {
    const { source } = this.store.state;
    // The sample opens by itself.
    if (!source?.files) return;
    // The last offer was for another clip.
    byId('recent').hidden = true;
    const id = await this.idOf(source);
    const slot = (await listProjects(storage)).find((project) => project.id === id);
    const { state } = this.store;
    const version = slot && (slot.corrected ? slot : slot.earlier[0]);
    if (!version || source !== state.source || state.job instanceof SavedJob) return;
    this.showNotice({
      text: `You have a corrected project of ${slot.name}.`,
      action: () => this.open(slot, version),
      hasList: true,
    });
  }

  async open(slot: SavedProject, version: SavedProject | ProjectVersion = slot) {
    this.dialog.close();
    byId('recent').hidden = true;
    await this.app.openProject(slot.name, () => reopenProject({ ...version, files: slot.files }));
  }

  async remove({ id }: { id: string }) {
    await storage.remove(id);
    await this.update();
    this.onRoom();
  }

  async removeVersion(slot: SavedProject, version: ProjectVersion) {
    await storage.put({ ...slot, earlier: slot.earlier.filter((candidate) => candidate !== version) });
    await this.update();
    this.onRoom();
  }

  async update() {
    const projects = await listProjects(storage);
    byId('projects-open').hidden = projects.length === 0;
    if (this.dialog.open) this.show(projects);
    return projects;
  }

  show(projects: SavedProject[]) {
    const key = projects.map(({ id, at, earlier }) => [id, at, earlier.length]).join();
    if (key === this.shownKey) return;
    this.shownKey = key;
    for (const url of this.urls.splice(0)) URL.revokeObjectURL(url);
    const focusedLabel = document.activeElement?.getAttribute('aria-label');
    byId('projects-list').replaceChildren(...projects.map((slot) => this.createLine(slot)));
    if (projects.length === 0) return this.dialog.close();
    // Keeps the focus on the same button.
    const buttons = [...this.dialog.querySelectorAll('button')];
    buttons.find((button) => focusedLabel && button.getAttribute('aria-label') === focusedLabel)?.focus();
  }

  async list() {
    const projects = await this.update();
    if (!this.dialog.open) this.dialog.showModal();
    this.show(projects);
  }

  /** Offers the interrupted run, or the last project, unless a clip is open. */
  async offer() {
    const projects = await this.update();
    const runs = (await storage.list()).length > projects.length ? await runMemory() : null;
    const run = await runs?.findInterrupted();
    const last = run ?? projects[0];
    if (!last || this.store.state.source?.files) return;
    this.showNotice({
      text: run ? `The run of ${run.name} was interrupted.` : `Recent project: ${last.name}`,
      actionText: run && `Run again: ${run.name}`,
      action: () => (run ? this.rerun(run) : this.open(projects[0])),
      removable: last,
      hasList: projects.length >= (run ? 1 : 2),
    });
  }

  async rerun(run: InterruptedRun) {
    byId('recent').hidden = true;
    // The new run is remembered separately.
    await storage.remove(run.id);
    await this.app.openInterruptedRun(run);
  }

  showNotice({ text, action, actionText = 'Continue', removable, hasList }: Notice) {
    byId('recent-text').textContent = text;
    byId('recent-open').textContent = actionText;
    byId('recent-open').onclick = () => action?.();
    const discard = byId<HTMLButtonElement>('recent-discard');
    discard.hidden = !removable;
    if (removable)
      confirmDelete(discard, removable.name, () => {
        byId('recent').hidden = true;
        void this.remove(removable);
      });
    byId('recent-all').hidden = !hasList;
    byId('recent').hidden = false;
  }

  createLine(slot: SavedProject) {
    const { name, corrected, files, project } = slot;
    const size = projectBytes({ files, project, earlier: [] });
    const facts = [describeVersion(slot, corrected), formatBytes(size)].join(' · ');
    const title = h('span', { class: 'project-name' }, name, h('span', { class: 'project-facts' }, facts));
    const line = h(
      'li',
      { class: 'project' },
      this.createThumbnail(slot.picture),
      title,
      createOpenButton(`Open ${name}`, slot.id, () => this.open(slot)),
      createDeleteButton(name, () => this.remove(slot)),
    );
    if (slot.earlier.length > 0)
      line.append(
        h('ul', { class: 'versions' }, ...slot.earlier.map((version) => this.createVersionLine(slot, version))),
      );
    return line;
  }

  createVersionLine(slot: SavedProject, version: ProjectVersion) {
    const facts = describeVersion(version, true);
    const name = `${slot.name}, ${facts}`;
    return h(
      'li',
      { class: 'project' },
      this.createThumbnail(version.picture),
      h('span', { class: 'project-facts' }, `Earlier: ${facts}`),
      createOpenButton(`Open ${name}`, `${slot.id} ${version.about.run}`, () => this.open(slot, version)),
      createDeleteButton(name, () => this.removeVersion(slot, version)),
    );
  }

  createThumbnail(picture: Blob | null) {
    if (!picture) return h('span', { class: 'project-thumbnail' });
    const url = URL.createObjectURL(picture);
    this.urls.push(url);
    return h('img', { class: 'project-thumbnail', src: url, alt: '' });
  }
}

function describeVersion({ at, about }: Pick<ProjectVersion, 'at' | 'about'>, corrected: boolean) {
  const when = new Date(at).toLocaleString('en', { dateStyle: 'medium', timeStyle: 'short' });
  const { frames } = about.trim;
  return [when, corrected ? `${frames} frames, corrected` : `${frames} frames`].join(' · ');
}

function createOpenButton(label: string, id: string, open: () => void) {
  return h('button', { type: 'button', 'aria-label': label, 'data-open': id, click: open }, 'Open');
}

function createDeleteButton(name: string, drop: () => void) {
  const button = h('button', { type: 'button' });
  confirmDelete(button, name, drop);
  return button;
}

/** Lets a button delete on the second press. */
function confirmDelete(button: HTMLButtonElement, name: string, drop: () => void) {
  const show = (isSure: boolean) => {
    button.toggleAttribute('data-sure', isSure);
    button.textContent = isSure ? 'Delete forever?' : 'Delete';
    button.setAttribute('aria-label', isSure ? `Delete ${name} forever?` : `Delete ${name}`);
  };
  show(false);
  button.onclick = () => (button.hasAttribute('data-sure') ? drop() : show(true));
  button.onblur = () => show(false);
}

export function startAutosave({ store, app }: Pick<Page, 'store' | 'app'>): Projects {
  const projects = new Projects({ store, app }, () => autosave.saveSoon());
  const { body } = document;
  const autosave = new Autosave(
    store,
    async (state) => {
      const isSaved = await projects.save(state);
      if (isSaved) body.dataset.saved = String(Date.now());
      return isSaved;
    },
    (isPending) => body.toggleAttribute('data-unsaved', isPending),
  );
  addEventListener('beforeunload', (event) => autosave.hasUnsaved && event.preventDefault());
  rememberRuns(store, runMemory);
  return projects;
}

/** Long side in pixels: twice the displayed size. */
const THUMBNAIL_SIDE_PX = 192;

/** Number of sampled frames; chosen by eye. */
const MAX_SAMPLED_FRAMES = 16;

/**
 * @param hidden objects to leave out
 * @returns null if the frame is missing
 */
export async function makeThumbnail(
  masks: MaskSource,
  frame: (t: number) => Promise<CanvasImageSource | ImageData | null>,
  hidden: readonly number[] = [],
): Promise<Blob | null> {
  const t = await findFullestFrame(masks, hidden);
  const image = await frame(t).catch(() => null);
  if (!image) return null;
  const picture = image instanceof ImageData ? await createImageBitmap(image) : image;
  const { width, height } = masks;
  const scale = Math.min(1, THUMBNAIL_SIDE_PX / Math.max(width, height));
  const canvas = new OffscreenCanvas(Math.max(1, Math.round(scale * width)), Math.max(1, Math.round(scale * height)));
  const ctx = canvas.getContext('2d')!;
  ctx.imageSmoothingQuality = 'high';
  ctx.scale(canvas.width / width, canvas.height / height);
  ctx.drawImage(picture, 0, 0, width, height);
  if (picture !== image && picture instanceof ImageBitmap) picture.close();
  const objects = (object: number) => object > 0 && !hidden.includes(object);
  drawLabels(ctx, masks, t, { outlineWidth: 2 / scale, objects });
  return canvas.convertToBlob({ type: 'image/jpeg', quality: 0.85 });
}

/** Returns the sampled frame with most object pixels. */
async function findFullestFrame(masks: MaskSource, hidden: readonly number[]): Promise<number> {
  const step = Math.max(1, Math.floor(masks.numFrames / MAX_SAMPLED_FRAMES));
  const isCounted = Uint8Array.from({ length: 256 }, (_, label) => Number(label > 0 && !hidden.includes(label)));
  let [best, most] = [0, -1];
  function* countFrames() {
    for (let t = 0; t < masks.numFrames; t += step) {
      const labels = masks.labels(t);
      let count = 0;
      for (let p = 0; p < labels.length; p += 1) count += isCounted[labels[p]];
      if (count > most) [best, most] = [t, count];
      yield;
    }
  }
  await runInSlices(countFrames());
  return best;
}
