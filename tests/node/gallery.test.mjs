// The gallery of the page: its index, its files, and that each is a project of the clip that its scene says.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { openProject } from 'tracecut/edit';
import { FRAME_RATE, SCENES, SIZE } from '../../scripts/gallery/scenes.mjs';
import { precacheList } from '../../scripts/precache.mjs';
import { root } from '../../scripts/tools.mjs';

const FOLDER = join(root, 'www', 'demo', 'gallery');
const MOST_BYTES = 2.5e6;
const { clips } = JSON.parse(readFileSync(join(FOLDER, 'index.json'), 'utf8'));

test('the index names the scenes, and the folder holds what it names and nothing else', () => {
  assert.deepEqual(
    clips.map(({ id }) => id),
    SCENES.map(({ id }) => id),
  );
  const wanted = clips.flatMap(({ id }) => [`${id}.tracecut`, `${id}.webp`]);
  assert.deepEqual(readdirSync(FOLDER).sort(), [...wanted, 'README.md', 'index.json'].sort());
  const sizes = Object.fromEntries(readdirSync(FOLDER).map((name) => [name, statSync(join(FOLDER, name)).size]));
  for (const { id, bytes } of clips) assert.equal(sizes[`${id}.tracecut`], bytes, id);
  const all = Object.values(sizes).reduce((sum, size) => sum + size, 0);
  assert.ok(all < MOST_BYTES, `${all} bytes`);
});

test('nothing of it is fetched before somebody looks at it', () => {
  assert.deepEqual(
    precacheList().files.filter(([name]) => name.includes('demo/gallery/')),
    [],
  );
});

for (const { id, frames, objects } of SCENES)
  test(`${id} opens as a project with its masks`, async () => {
    const facts = clips.find((clip) => clip.id === id);
    const { masks, about, edits, files } = await openProject(readFileSync(join(FOLDER, `${id}.tracecut`)));
    assert.deepEqual([masks.width, masks.height, masks.numFrames], [SIZE.width, SIZE.height, frames]);
    const { width, height, seconds } = facts;
    assert.deepEqual(
      { width, height, seconds, frames: facts.frames },
      { ...SIZE, seconds: frames / FRAME_RATE, frames },
    );
    assert.equal(facts.objects, masks.objects.length);
    // Nobody has touched them.
    assert.equal(edits, null);
    const lasting = masks.objects.filter((object) => object.frames > 0.8 * frames);
    assert.equal(lasting.length, objects, 'objects that are there nearly all the time');
    for (let t = 0; t < frames; t += 1)
      assert.ok(
        masks.labels(t).some((label) => label > 0),
        `frame ${t}`,
      );
    assert.ok(masks.trajectories.count > 300, `${masks.trajectories.count} trajectories`);
    assert.deepEqual(about.take, { start: 0, frames, step: 1, side: SIZE.width });
    assert.deepEqual(Object.keys(files), [`${id}.webm`]);
    assert.deepEqual([...files[`${id}.webm`].subarray(0, 4)], [0x1a, 0x45, 0xdf, 0xa3], 'a WebM file');
  });
