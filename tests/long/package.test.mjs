// Recipes of docs/recipes.md: Node in several versions, each with the results of this one, and FFmpeg with the archive of masks.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { TASKS, alphaOverlaps, codeOf, writeSceneVideo } from '../readme.mjs';
import { outcome } from '../package/app/segment.js';
import { execute, installed, nodeOf, project, recipe } from '../package/project.mjs';

let expected;
before(async () => {
  expected = await outcome();
});

const PRINT = "import { outcome } from './segment.js';\nconsole.log(JSON.stringify(await outcome()));\n";
const asCommonJs = (text) =>
  text.replace(/import \{(.*?)\} from '(.*?)';/gs, "const {$1} = require('$2');").replaceAll('export ', '');

for (const version of ['18.20.8', '20.19.5', '22.21.1', '24.11.1']) {
  test(`Node ${version}, as modules and as CommonJS`, async (t) => {
    const node = await nodeOf(t, version);
    const folder = await project(t, { recipe: 'Node', files: { 'print.mjs': PRINT } });
    assert.equal(await execute(folder, node, ['--version']), `v${version}\n`);
    for (const file of recipe('Node').keys()) assert.equal(await execute(folder, node, [file]), '3\n', file);
    const text = asCommonJs(readFileSync(join(folder, 'segment.js'), 'utf8'));
    const print = 'outcome().then((found) => console.log(JSON.stringify(found)));';
    writeFileSync(join(folder, 'segment.cjs'), `${text}\n${print}`);
    for (const file of ['print.mjs', 'segment.cjs'])
      assert.deepEqual(JSON.parse(await execute(folder, node, [file])), expected, file);
  });
}

const isInstalled = (program, ...args) => spawnSync(program, args).status === 0;
const skip = !(isInstalled('ffmpeg', '-version') && isInstalled('unzip', '-v')) && 'ffmpeg or unzip is not installed';

test('the recipe for FFmpeg gives a video the masks as its alpha channel', { skip }, async (t) => {
  const folder = installed(t);
  const clip = join(folder, 'clip.mp4');
  await writeSceneVideo(clip, ['-c:v', 'mpeg4', '-q:v', '2']);
  const [heading] = TASKS.long;
  writeFileSync(join(folder, 'main.mjs'), codeOf('docs/tasks.md').get(heading));
  execFileSync(process.execPath, ['main.mjs'], { cwd: folder });
  const commands = codeOf('docs/tasks.md', 'sh').get(heading);
  execFileSync('sh', ['-ec', commands], { cwd: folder, stdio: ['ignore', 'ignore', 'pipe'] });
  for (const overlap of await alphaOverlaps(join(folder, 'cutout.mov'), clip)) assert.ok(overlap > 0.99, `${overlap}`);
});
