// The recipe for FFmpeg with the archive of masks.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { alphaOverlaps, writeSceneVideo } from '../alpha-video.mjs';
import { installed } from '../package/installed.mjs';
import { TASKS, codeOf } from '../readme.mjs';

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
