// The API reference: nothing public lacks a description, and there is an entry for all that the package exports.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { reference } from '../../scripts/reference.mjs';
import * as tracecut from '../whole.mjs';
import { root } from '../../scripts/tools.mjs';

const { text, undocumented, names } = reference(join(root, 'dist'), tracecut.parameters());

test('every public name, member and parameter has a description', () => {
  assert.deepEqual(undocumented, []);
});

test('the reference has an entry for all that the package exports', () => {
  for (const name of new Set([...names, ...Object.keys(tracecut)]))
    assert.match(text, new RegExp(`^### ${name}$`, 'm'));
});
