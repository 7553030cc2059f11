// The recipes of frameworks: on the page, and on the server.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { outcome } from '../package/app/segment.js';
import { gives } from '../package/found.mjs';
import { project, recipe, tool } from '../package/project.mjs';
import { freePort } from '../port.mjs';
import { useServerAndBrowser } from '../site.mjs';

const site = useServerAndBrowser();
let expected;
before(async () => {
  expected = await outcome();
});

const ROUTE = `import { outcome } from '../../../segment.js';
export const dynamic = 'force-dynamic';
export async function GET() {
  return Response.json(await outcome());
}
`;

for (const bundler of ['webpack', 'turbopack']) {
  for (const outside of [false, true]) {
    test(`Next with ${bundler}${outside ? ', the package outside of the server bundle' : ''}`, async (t) => {
      const layout = 'export default ({ children }) => <html lang="en"><body>{children}</body></html>;\n';
      const files = { 'app/layout.js': layout, 'app/api/run/route.js': ROUTE, 'app/icon.svg': ICON };
      files['app/page.js'] = recipe('next').get('app/page.js');
      if (outside) files['next.config.mjs'] = recipe('next').get('next.config.mjs');
      const folder = await project(t, { tools: { next: '16.4.6', react: '19.3.1', 'react-dom': '19.3.1' }, files });
      await tool(folder, 'next', 'build', `--${bundler}`);
      const url = await running(t, folder, [join('node_modules', 'next', 'dist', 'bin', 'next'), 'start', '--port']);
      assert.deepEqual(await (await fetch(`${url}api/run`)).json(), expected);
      await gives(t, site.browser, url, expected);
    });
  }
}

const ICON = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><path d="M0 0h1v1H0z"/></svg>\n';

test('SvelteKit', async (t) => {
  const folder = await project(t, {
    tools: {
      '@sveltejs/adapter-node': '5.5.7',
      '@sveltejs/kit': '2.70.4',
      '@sveltejs/vite-plugin-svelte': '6.2.3',
      svelte: '5.57.3',
      vite: '7.3.8',
    },
    files: {
      'vite.config.js': `import { sveltekit } from '@sveltejs/kit/vite';\nexport default { plugins: [sveltekit()] };\n`,
      'svelte.config.js': `import adapter from '@sveltejs/adapter-node';\nexport default { kit: { adapter: adapter() } };\n`,
      'src/app.html': `<!doctype html><link rel="icon" href="data:,">%sveltekit.head%<body>%sveltekit.body%</body>`,
      'src/routes/+page.svelte': `<script>
  import { onMount } from 'svelte';
  import { outcome, throughVideo } from '../../segment.js';
  onMount(() => { globalThis.outcome = Promise.all([outcome(), throughVideo()]); });
</script>
`,
      'src/routes/api/run/+server.js': ROUTE.replace('../../../', '../../../../').replace(/^.*dynamic.*\n/m, ''),
    },
  });
  await tool(folder, 'vite', 'build');
  const url = await running(t, folder, [join('build', 'index.js')]);
  assert.deepEqual(await (await fetch(`${url}api/run`)).json(), expected);
  await gives(t, site.browser, url, expected);
});

/** Starts a server of Node on a free port, which is the last argument and in the environment; waits for its answer. */
async function running(t, folder, args) {
  const port = await freePort();
  const last = args.at(-1) === '--port' ? [String(port)] : [];
  const env = { ...process.env, PORT: String(port), HOST: '127.0.0.1', NEXT_TELEMETRY_DISABLED: '1' };
  const child = spawn(process.execPath, [...args, ...last], { cwd: folder, env, stdio: 'ignore' });
  t.after(() => child.kill());
  const url = `http://127.0.0.1:${port}/`;
  for (let k = 0; k < 600; k += 1) {
    const answer = await fetch(url).catch(() => null);
    if (answer?.ok) return url;
    await new Promise((done) => setTimeout(done, 100));
  }
  throw new Error('the server does not answer');
}
