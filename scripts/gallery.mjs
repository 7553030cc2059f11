// `node scripts/gallery.mjs [ID|ID=FILE ...]`: renews the page's gallery, www/demo/gallery/, or these clips of it. Runs the
// package with its usual settings over the video that a clip's project holds, or over a WebM file that is to take its
// place, and saves what it finds. Pictures to look at go to out/gallery/. `--welcome` renews what the page shows before
// anything is computed, www/demo/welcome/, from the masks that the gallery has.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { unzipSync } from 'fflate';
import { launchBrowser } from './browser.mjs';
import { build } from './build.mjs';
import { serve } from './serve.mjs';
import { root } from './tools.mjs';

const FOLDER = join(root, 'www', 'demo', 'gallery');
const LOOKS = join(root, 'out', 'gallery');
const WELCOME = join(root, 'www', 'demo', 'welcome');
const INDEX = join(FOLDER, 'index.json');

/** The frame that a clip's poster shows, where it is not the middle one. */
const POSTERS = { coast: 30, street: 34, parting: 44, forward: 30, ball: 20, hedge: 18 };

const { clips } = JSON.parse(readFileSync(INDEX, 'utf8'));
const words = process.argv.slice(2).filter((word) => word !== '--welcome');
const isWelcome = process.argv.includes('--welcome');
const chosen = words.length > 0 || isWelcome ? words.map((word) => word.split('=')) : clips.map(({ id }) => [id]);

/** The video of a clip, as Base64. */
function filmOf([id, file]) {
  const bytes = file ? readFileSync(file) : unzipSync(readFileSync(join(FOLDER, `${id}.tracecut`)))[`files/${id}.webm`];
  return Buffer.from(bytes).toString('base64');
}

/** A blank page of the server's, with what makes clips beside it. */
async function pageAt(url, browser) {
  const page = await browser.newPage();
  await page.route(`${url}gallery-maker/*`, (route) => {
    const name = new URL(route.request().url()).pathname.split('/').pop();
    if (!name) return route.fulfill({ contentType: 'text/html', body: '<!doctype html><title>gallery</title>' });
    const body = readFileSync(join(root, 'scripts', 'gallery', name));
    return route.fulfill({ contentType: 'text/javascript', body });
  });
  await page.goto(`${url}gallery-maker/`);
  return page;
}

/** Runs in the page: one clip, its files as Base64. */
async function made(clip) {
  const { makeClip } = await import('/gallery-maker/make.mjs');
  return makeClip(clip);
}

/** Runs in the page: what it shows first, as Base64. */
async function madeWelcome(clip) {
  const { makeWelcome } = await import('/gallery-maker/welcome.mjs');
  return makeWelcome(clip);
}

/** The bus and the car of the street, in a frame that shows both whole. */
async function writeWelcome(page) {
  const project = readFileSync(join(FOLDER, 'street.tracecut')).toString('base64');
  const clip = { project, frame: 24, objects: { bus: 1, car: 2 } };
  const { files, ...places } = await page.evaluate(madeWelcome, clip);
  mkdirSync(WELCOME, { recursive: true });
  for (const [name, base64] of Object.entries(files)) writeFileSync(join(WELCOME, name), Buffer.from(base64, 'base64'));
  console.log('styles/welcome.css says where they are:', JSON.stringify(places));
}

await build();
mkdirSync(LOOKS, { recursive: true });
const [server, browser] = [await serve(), await launchBrowser()];
try {
  const page = await pageAt(server.url, browser);
  for (const [id, file] of chosen) {
    const { facts, files, look } = await page.evaluate(made, { id, film: filmOf([id, file]), poster: POSTERS[id] });
    for (const [name, base64] of Object.entries(files))
      writeFileSync(join(FOLDER, name), Buffer.from(base64, 'base64'));
    writeFileSync(join(LOOKS, `${id}.png`), Buffer.from(look, 'base64'));
    const { sizes, ...kept } = facts;
    console.log(`${id}: ${facts.objects} objects, ${(facts.bytes / 1000).toFixed(0)} KB`, sizes);
    const at = clips.findIndex((clip) => clip.id === id);
    clips.splice(at < 0 ? clips.length : at, 1, kept);
  }
  if (isWelcome) await writeWelcome(page);
  writeFileSync(INDEX, `${JSON.stringify({ clips }, null, 2)}\n`);
} finally {
  await browser.close();
  await server.close();
}
