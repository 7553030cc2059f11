// Projects in the browser's storage: offered after a closed tab, listed, deleted; project files; interrupted runs.

import { movingFrames } from '../moving.mjs';
import { expect, openSample, runEnd, test } from './fixtures.mjs';
import {
  accessibilityFaults,
  drag,
  masks,
  openFix,
  openLook,
  openSave,
  pngFiles,
  saveExport,
  selectTool,
} from './studio-page.mjs';

const CLIP = pngFiles(movingFrames(9, [96, 64]));

/** Does something that changes the project, and waits until all is saved. */
async function untilSaved(page, act) {
  const before = await page.evaluate(() => Number(document.body.dataset.saved ?? 0));
  await act();
  await page.waitForFunction(
    (last) => Number(document.body.dataset.saved ?? 0) > last && !('unsaved' in document.body.dataset),
    before,
  );
}

const waitForFrames = async (page, count) => {
  await page.waitForFunction(
    (numFrames) => globalThis.tracecutStudio.app.segmentation?.result.numFrames === numFrames,
    count,
  );
  expect(await runEnd(page)).toBe('done');
};

const openClip = (page, files = CLIP) =>
  untilSaved(page, async () => {
    await page.setInputFiles('#file', files);
    await waitForFrames(page, files.length);
  });

/** Adds a piece of the background to a new object. */
const addObject = (page) =>
  untilSaved(page, async () => {
    await openFix(page);
    await selectTool(page, 'paint');
    await page.selectOption('#correct-object', '-1');
    await drag(page, [
      [76, 6],
      [86, 6],
    ]);
    await expect(page.locator('#correct-status')).toHaveText(/^Applied to .*\./);
    await page.click('#correct-done');
  });

/** Opens another page of the same browser, after closing the first as if its process had been killed. */
async function reopen(page) {
  const [context, url] = [page.context(), page.url()];
  const next = await context.newPage();
  await page.close({ runBeforeUnload: false });
  await next.goto(url);
  return next;
}

/** Runs in the page: saved projects, newest first. */
async function readProjects() {
  const [{ listProjects }, storage] = await Promise.all([
    import('/model/saved-projects.js'),
    import('/view/storage.js'),
  ]);
  return (await listProjects(storage)).map(({ name, corrected, picture, earlier }) => ({
    ...{ name, corrected, hasPicture: (picture?.size ?? 0) > 500, earlier: earlier.length },
  }));
}

const readView = (page) =>
  page.evaluate(() => ({
    values: [...document.querySelectorAll('#edge-grow, #edge-feather, #edge-smooth, #backdrop')].map(
      ({ id, value }) => `${id} ${value}`,
    ),
    kept: [...document.querySelectorAll('[data-object] input')].map(({ checked }) => checked),
  }));

test('a corrected project is offered after its tab was killed, saved as a file, and deleted when confirmed', async ({
  openStudio,
}) => {
  let page = await openSample(openStudio, { sample: 'tiny', bypassCSP: true });
  await openClip(page);
  await addObject(page);
  await untilSaved(page, async () => {
    await openLook(page);
    for (const [name, value] of Object.entries({ grow: 3, feather: 2, smooth: 1 }))
      await page.fill(`#edge-${name}`, String(value));
    await page.check('[name="view"][value="cutout"]', { force: true });
    await page.selectOption('#backdrop', 'green');
    await page.uncheck('[data-object="1"] input');
  });
  const [corrected, view] = [await masks(page), await readView(page)];
  expect(view.kept).toContain(false);
  page = await reopen(page);
  await expect(page.locator('#recent-text')).toHaveText(/^Recent project: ./);
  await runEnd(page);
  expect(await accessibilityFaults(page)).toEqual([]);
  await page.click('#recent-open');
  await waitForFrames(page, 9);
  expect((await masks(page)) === corrected).toBe(true);
  expect(await readView(page)).toEqual(view);

  await openSave(page);
  const { name, bytes } = await saveExport(page, 'project');
  expect(name).toBe('frame0-project.tracecut');
  await page.click('#export-close');
  await openFix(page);
  await page.click('#correct-undo');
  await expect(page.locator('#correct-undo')).toBeDisabled();
  expect((await masks(page)) === corrected).toBe(false);
  await page.click('#correct-redo');
  await expect(page.locator('#correct-redo')).toBeDisabled();
  expect((await masks(page)) === corrected).toBe(true);

  const otherPage = await openSample(openStudio, { sample: 'tiny' });
  await otherPage.setInputFiles('#file', { name: 'work.tracecut', mimeType: 'application/zip', buffer: bytes });
  await waitForFrames(otherPage, 9);
  expect((await masks(otherPage)) === corrected).toBe(true);
  expect(await readView(otherPage)).toEqual(view);

  page = await reopen(page);
  await page.click('#recent-discard');
  await expect(page.locator('#recent-discard')).toHaveText('Delete forever?');
  expect(await page.evaluate(readProjects)).toHaveLength(1);
  await page.click('#recent-discard');
  // A reload would come before the storage has removed it.
  await expect(page.locator('#projects-open')).toBeHidden();
  expect(await page.evaluate(readProjects)).toEqual([]);
});

test('an earlier corrected result of a clip is offered, listed with its picture, and opened by keyboard', async ({
  openStudio,
}) => {
  const page = await openSample(openStudio, { sample: 'tiny', bypassCSP: true });
  await openClip(page);
  await addObject(page);
  const corrected = await masks(page);
  await openClip(page, CLIP.slice(0, 8));
  await openClip(page);
  await expect(page.locator('#recent-text')).toHaveText(/^You have a corrected project of frame0/);
  expect((await masks(page)) === corrected).toBe(false);
  const plain = { corrected: false, hasPicture: true };
  expect(await page.evaluate(readProjects)).toMatchObject([
    { ...plain, earlier: 1 },
    { ...plain, earlier: 0 },
  ]);
  await page.click('#projects-open');
  await page.waitForSelector('#projects[open]');
  await expect(page.locator('.projects > .project')).toHaveCount(2);
  await expect(page.locator('.projects img')).toHaveCount(3);
  await page.waitForFunction(() =>
    [...document.querySelectorAll('.projects img')].every((image) => image.naturalWidth > 0),
  );
  expect(await accessibilityFaults(page)).toEqual([]);
  await page.setViewportSize({ width: 390, height: 844 });
  expect(await page.$eval('#projects', (dialog) => dialog.scrollWidth <= dialog.clientWidth)).toBe(true);
  await page.focus('.versions [data-open]');
  await page.keyboard.press('Enter');
  await expect(page.locator('#facts, #subline').filter({ hasText: 'reopened' })).not.toHaveCount(0);
  expect(await runEnd(page)).toBe('done');
  expect((await masks(page)) === corrected).toBe(true);
  await page.click('#projects-open');
  await page.waitForSelector('#projects[open]');
  const remove = page.locator('.projects > .project:nth-child(2) > button').last();
  await remove.focus();
  await page.keyboard.press('Enter');
  await expect(remove).toHaveText('Delete forever?');
  await page.keyboard.press('Enter');
  await expect(page.locator('.projects > .project')).toHaveCount(1);
});

test('asks to delete a project if storage is full of corrected ones, and then saves', async ({ openStudio }) => {
  const page = await openSample(openStudio, { sample: 'tiny', bypassCSP: true });
  await page.evaluate(async () => {
    const storage = await import('/view/storage.js');
    for (let at = 1; at <= 8; at += 1)
      await storage.put({
        ...{ id: `p${at}`, name: `n${at}`, at, files: [], project: new Uint8Array(3), edits: null },
        ...{ corrected: true, picture: null, earlier: [] },
        about: { name: `n${at}`, trim: { start: 0, frames: 2, step: 1, side: 480 }, changed: [], run: `r${at}` },
      });
  });
  await page.setInputFiles('#file', CLIP);
  await expect(page.locator('#recent-text')).toHaveText(/^Storage is full/);
  await expect(page.locator('body'), 'leaving asks first').toHaveAttribute('data-unsaved');
  await page.focus('#recent-open');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#projects[open]');
  await untilSaved(page, async () => {
    await page.locator('.projects > .project:nth-child(8) > button').last().focus();
    await page.keyboard.press('Enter');
    await page.keyboard.press('Enter');
  });
  const projects = await page.evaluate(readProjects);
  expect([projects.length, projects[0].name]).toEqual([8, 'frame0.png … frame8.png']);
  await expect(page.locator('#recent')).toBeHidden();
});

/** Runs in the page: the interrupted run that would be offered. */
async function findInterrupted() {
  const [{ RunMemory }, storage] = await Promise.all([
    import('/model/interrupted-runs.js'),
    import('/view/storage.js'),
  ]);
  return (await new RunMemory(storage, navigator.locks).findInterrupted())?.name;
}

test('an interrupted run is offered with its settings once no other tab continues it', async ({ openStudio }) => {
  let page = await openSample(openStudio, { sample: 'tiny', bypassCSP: true });
  const files = CLIP.map(({ name, buffer }) => ({ name, bytes: [...buffer] }));
  await page.evaluate(async (list) => {
    const [{ RunMemory }, storage] = await Promise.all([
      import('/model/interrupted-runs.js'),
      import('/view/storage.js'),
    ]);
    const clip = list.map(({ name, bytes }) => new File([new Uint8Array(bytes)], name, { type: 'image/png' }));
    const trim = { start: 0, frames: 3, step: 3, side: 480 };
    const state = { name: 'frame0.png', source: { files: clip }, trim, changed: new Map() };
    await new RunMemory(storage, navigator.locks).remember(state);
  }, files);
  const beside = await page.context().newPage();
  await beside.goto(page.url());
  await runEnd(beside);
  expect(await beside.evaluate(findInterrupted)).toBe(undefined);
  await expect(beside.locator('#recent')).toBeHidden();
  await beside.close();

  page = await reopen(page);
  await expect(page.locator('#recent-text')).toHaveText('The run of frame0.png was interrupted.');
  await expect(page.locator('#recent-open')).toHaveText('Run again: frame0.png');
  await runEnd(page);
  expect(await accessibilityFaults(page)).toEqual([]);
  await untilSaved(page, () => page.click('#recent-open'));
  await waitForFrames(page, 3);
  expect(await page.evaluate(() => globalThis.tracecutStudio.trim.step)).toBe(3);
  expect(await page.evaluate(findInterrupted)).toBe(undefined);
  page = await reopen(page);
  await expect(page.locator('#recent-text')).toHaveText(/^Recent project: ./);
});
