// The gallery of the page: its index, its files, and that each is a project with the objects of its clip.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { openProject } from 'tracecut/edit';
import { precacheList } from '../../scripts/precache.mjs';
import { root } from '../../scripts/tools.mjs';

const FOLDER = join(root, 'www', 'demo', 'gallery');
const MOST_BYTES = 2.5e6;
/** How many objects each clip has. */
const OBJECTS = { coast: 3, street: 3, parting: 2, forward: 2, ball: 1, hedge: 2 };
const { clips } = JSON.parse(readFileSync(join(FOLDER, 'index.json'), 'utf8'));

test('the index names the clips, and the folder holds what it names and nothing else', () => {
  assert.deepEqual(
    clips.map(({ id }) => id),
    Object.keys(OBJECTS),
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

for (const { id, width, height, frames, seconds, objects } of clips)
  test(`${id} opens as a project with its masks`, async () => {
    const { masks, about, edits, files } = await openProject(readFileSync(join(FOLDER, `${id}.tracecut`)));
    assert.deepEqual([masks.width, masks.height, masks.numFrames], [width, height, frames]);
    assert.ok(Math.abs(masks.end - seconds) < 0.01, `${masks.end} s`);
    assert.equal(objects, masks.objects.length);
    // Nobody has touched them.
    assert.equal(edits, null);
    const lasting = masks.objects.filter((object) => object.frames > 0.8 * frames);
    assert.equal(lasting.length, OBJECTS[id], 'objects that are there nearly all the time');
    for (let t = 0; t < frames; t += 1)
      assert.ok(
        masks.labels(t).some((label) => label > 0),
        `frame ${t}`,
      );
    assert.ok(masks.trajectories.count > 300, `${masks.trajectories.count} trajectories`);
    assert.deepEqual(about.take, { start: 0, frames, step: 1, side: width });
    assert.deepEqual(Object.keys(files), [`${id}.webm`]);
    assert.deepEqual([...files[`${id}.webm`].subarray(0, 4)], [0x1a, 0x45, 0xdf, 0xa3], 'a WebM file');
  });
