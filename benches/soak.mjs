// `npm run soak`: memory over a thousand sessions in one process, a hundred at once, hours of windows, a page left running:
// each in a process of its own, measured after collecting garbage. `npm run soak -- sessions=200 page=50` runs these
// two, 200 and 50 times; results go into `docs/reliability.md` with `--write`.

import { spawn } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { availableParallelism } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { build } from '../scripts/build.mjs';
import { fail, root } from '../scripts/tools.mjs';
import { table } from './soak/report.mjs';

/** How many times each is done. */
const USUALLY = { sessions: 1000, crowd: 20, windows: 12000, page: 2000 };
/** Bytes that a session or a window may leave behind. */
const MOST_SLOPE = 1024;

const args = process.argv.slice(2);
const asked = Object.fromEntries(args.filter((arg) => !arg.startsWith('-')).map((arg) => arg.split('=')));

/**
 * Runs one part to its end.
 * @param {string} part
 * @param {number} count
 * @returns {Promise<import('./soak/report.mjs').Soaked>}
 */
function soaked(part, count) {
  const script = join(root, 'benches', 'soak', `${part}.mjs`);
  return new Promise((done, failed) => {
    const child = spawn(process.execPath, ['--expose-gc', script, String(count)], {
      stdio: ['ignore', 'pipe', 'inherit'],
    });
    let text = '';
    child.stdout.on('data', (data) => (text += data));
    child.on('close', (code) =>
      code === 0 ? done(JSON.parse(text)) : failed(new Error(`${part} ended with ${code}`)),
    );
  });
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const chosen = Object.keys(asked).length > 0 ? Object.keys(asked) : Object.keys(USUALLY);
  const unknown = chosen.find((part) => !(part in USUALLY));
  if (unknown) fail(`There is no part "${unknown}" (expected ${Object.keys(USUALLY).join(', ')}).`);
  await build();
  const results = [];
  for (const part of chosen) results.push(await soaked(part, Number(asked[part] ?? USUALLY[part])));
  mkdirSync(join(root, 'out'), { recursive: true });
  writeFileSync(join(root, 'out', 'soak.json'), JSON.stringify(results, null, 2));
  const text = table(results, { node: process.version, cores: availableParallelism() });
  console.log(text);
  if (args.includes('--write')) {
    const file = join(root, 'docs', 'reliability.md');
    const place = /(<!-- soak: npm run soak -- --write -->\n)[\s\S]*?(<!-- \/soak -->)/;
    writeFileSync(
      file,
      readFileSync(file, 'utf8').replace(place, (_, from, to) => `${from}\n${text}\n${to}`),
    );
  }
  // What a process holds goes up and down by megabytes: only over many does that tell anything.
  const steep = results.filter(
    ({ count, slope: { heap, rss } }) => Math.max(heap, count < 1000 ? 0 : rss) > MOST_SLOPE,
  );
  if (steep.length > 0) fail(`Memory grows: ${steep.map(({ part }) => part).join(', ')}.`);
}
