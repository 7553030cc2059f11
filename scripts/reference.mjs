// Writes docs/reference.md from the built package. `npm test` fails while it is out of date.

import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { build } from './build.mjs';
import { reference } from './reference/write.mjs';
import { root } from './tools.mjs';

await build();
const dist = join(root, 'dist');
const { PARAMETERS } = await import(pathToFileURL(join(dist, 'parameters.js')).href);
const { text, undocumented } = reference(dist, PARAMETERS);
writeFileSync(join(root, 'docs', 'reference.md'), text);
console.log(
  undocumented.length > 0 ? `Without a description: ${undocumented.join(', ')}` : 'docs/reference.md is written.',
);
