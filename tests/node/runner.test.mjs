// The runner of the tests: it counts what its programs tell of, each test once, and knows what has changed.

import { deepEqual } from 'node:assert/strict';
import { test } from 'node:test';
import { changedFiles } from '../../scripts/test/fast.mjs';
import { countsIn } from '../../scripts/test/pool.mjs';

test('counts of Cargo, Node and pytest are read, each once', () => {
  const cargo =
    'test result: ok. 441 passed; 1 failed; 7 ignored; 0 measured; 0 filtered out; finished in 35.21s\n' +
    'test result: ok. 9 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s\n';
  deepEqual(countsIn(cargo), { passed: 450, failed: 1, skipped: 7 });
  deepEqual(countsIn('ℹ tests 6\nℹ pass 3\nℹ fail 1\nℹ skipped 2\n'), { passed: 3, failed: 1, skipped: 2 });
  deepEqual(countsIn('..s\n===== 2 passed, 1 skipped in 0.52s =====\n'), { passed: 2, failed: 0, skipped: 1 });
  deepEqual(countsIn('1 failed, 4 passed in 61.10s (0:01:01)\n'), { passed: 4, failed: 1, skipped: 0 });
});

test('what git says has changed is read, its first row too', () => {
  deepEqual(changedFiles('M src/order.rs\n M www/lib/stages/clip.js\n?? tests/new.mjs'), [
    'src/order.rs',
    'www/lib/stages/clip.js',
    'tests/new.mjs',
  ]);
  deepEqual(changedFiles(''), []);
});
