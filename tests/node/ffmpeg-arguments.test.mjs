// Command line and package ask ffmpeg for the same in the same words.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import * as words from '../../dist/node/ffmpeg.js';

const rust = readFileSync(join(root, 'cli', 'src', 'ffmpeg.rs'), 'utf8').replaceAll('\r', '');

/** The value of a constant of Rust: a text, or a list of texts and of names of other constants. */
function constant(name) {
  const [, source] = new RegExp(`^const ${name}: [^=]*= &?([^;]*);$`, 'm').exec(rust) ?? [];
  assert.ok(source, `cli/src/ffmpeg.rs has no constant ${name}`);
  const texts = source.replace(/\\\n\s*/g, '').matchAll(/"([^"]*)"|\b([A-Z_]+)\b/g);
  const list = [...texts].map(([, text, other]) => text ?? constant(other));
  return source.startsWith('[') ? list : list[0];
}

test('the words for ffmpeg are those of the command line', () => {
  for (const name of ['GENERAL', 'LIST', 'DECODE', 'FILTERS', 'WRITE'])
    assert.deepEqual(words[name], constant(name), name);
});
