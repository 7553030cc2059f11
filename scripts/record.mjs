// `node scripts/record.mjs NAME COMMAND ...` runs a command, shows its output and keeps it in out/tests/NAME.log, where
// `npm test` counts tests. The project's own tools come first on the command's PATH.

import { spawn } from 'node:child_process';
import { createWriteStream, mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { environment, root } from './tools.mjs';

const [name, command, ...args] = process.argv.slice(2);
const folder = join(root, 'out', 'tests');
mkdirSync(folder, { recursive: true });
const log = createWriteStream(join(folder, `${name}.log`));
const child = spawn(command, args, { cwd: root, env: environment(), stdio: ['ignore', 'pipe', 'pipe'] });
for (const [stream, shown] of [
  [child.stdout, process.stdout],
  [child.stderr, process.stderr],
])
  stream.on('data', (bytes) => {
    shown.write(bytes);
    log.write(bytes);
  });
child.on('error', (error) => {
  console.error(`${command} cannot be started: ${error.message}`);
  process.exitCode = 1;
});
child.on('close', (code) => (process.exitCode ||= code ?? 1));
