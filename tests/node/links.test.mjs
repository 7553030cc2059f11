// Links between the Markdown files, relative or to the repository's address, lead to files that are there.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { output, root } from '../../scripts/tools.mjs';

const HERE = /^https:\/\/(raw\.githubusercontent|github)\.com\/tracecut\/tracecut\/((blob|tree)\/)?HEAD\//;

test('every link to a file of the repository leads to one', () => {
  const links = output('git', ['ls-files', '*.md'])
    .split('\n')
    .flatMap((file) =>
      [...readFileSync(join(root, file), 'utf8').matchAll(/\]\(([^)#\s]+)/g)].map(([, target]) => ({ file, target })),
    )
    .filter(({ target }) => HERE.test(target) || !/^[a-z]+:/.test(target));
  assert.ok(links.length > 50, `${links.length} links`);
  // Registries show the README on pages of their own.
  assert.ok(links.every(({ file, target }) => file !== 'README.md' || HERE.test(target)));
  const place = ({ file, target }) => join(root, HERE.test(target) ? '.' : dirname(file), target.replace(HERE, ''));
  assert.deepEqual(
    links.filter((link) => !existsSync(place(link))),
    [],
  );
});
