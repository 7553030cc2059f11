// The page under attack: names and links that are markup, and whatever code in it might try: nothing runs that is not its
// own, and nothing goes anywhere.

import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import { after, before, describe, test } from 'node:test';
import { ended, inPhase, openSample, plainFrame, pngFile, useSite } from './support.mjs';

const MARKUP = '<img src=x onerror="globalThis.broken=1"><script>globalThis.broken=1</scr' + 'ipt>"\'';
const pixels = (k) => plainFrame(48, 32, (x, y) => [(x * 5 + k * 9) % 256, y * 7, 0]);

/** What code in the page tries, one thing each; `foreign` is another host, which counts what it is asked. */
const ATTEMPTS = {
  eval: () => globalThis.eval('globalThis.broken = 1'),
  function: () => new Function('globalThis.broken = 1')(),
  timer: () => setTimeout('globalThis.broken = 1'),
  inline: () =>
    document.body.append(Object.assign(document.createElement('script'), { text: 'globalThis.broken = 1' })),
  handler: () => document.body.insertAdjacentHTML('beforeend', '<img src="./x" onerror="globalThis.broken = 1">'),
  link: () => {
    document.body.insertAdjacentHTML('beforeend', '<a id="bad" href="javascript:globalThis.broken=1">x</a>');
    document.querySelector('#bad').click();
  },
  blobScript: () => {
    const src = URL.createObjectURL(new Blob(['globalThis.broken = 1'], { type: 'text/javascript' }));
    document.body.append(Object.assign(document.createElement('script'), { src }));
  },
  dataModule: () => import(/* @vite-ignore */ `data:text/javascript,${'globalThis.broken = 1'}`),
  blobWorker: (foreign) => {
    const code = new Blob([`fetch(${JSON.stringify(foreign)})`], { type: 'text/javascript' });
    new Worker(URL.createObjectURL(code));
  },
  frame: (src) => document.body.append(Object.assign(document.createElement('iframe'), { src })),
  frameOfText: async () => {
    const srcdoc = '<script>parent.broken = 1</scr' + 'ipt>';
    const frame = Object.assign(document.createElement('iframe'), { srcdoc });
    const loaded = new Promise((done) => (frame.onload = done));
    document.body.append(frame);
    await loaded;
    // Its own document is told of it, not this one.
    if (globalThis.broken !== 1) throw new Error('nothing ran');
  },
  script: (src) => document.body.append(Object.assign(document.createElement('script'), { src })),
  image: (src) => document.body.append(Object.assign(new Image(), { src })),
  media: (src) => document.body.append(Object.assign(document.createElement('video'), { src })),
  style: (href) => document.head.append(Object.assign(document.createElement('link'), { rel: 'stylesheet', href })),
  inlineStyle: (at) => document.body.insertAdjacentHTML('beforeend', `<p style="background:url(${at})">x</p>`),
  object: (data) => document.body.append(Object.assign(document.createElement('object'), { data })),
  fetch: (foreign) => fetch(foreign, { mode: 'no-cors' }),
  request: (foreign) => {
    const request = new XMLHttpRequest();
    request.open('POST', foreign);
    request.send('frames');
  },
  beacon: (foreign) => navigator.sendBeacon(foreign, 'frames'),
  events: (foreign) => new EventSource(foreign),
  socket: (foreign) => new WebSocket(foreign.replace('http', 'ws')),
  base: (href) => {
    document.head.append(Object.assign(document.createElement('base'), { href }));
    return fetch('./x');
  },
  form: (action) => {
    const form = Object.assign(document.createElement('form'), { action, method: 'post' });
    document.body.append(form);
    form.submit();
  },
};

describe('the policy of the page', () => {
  const site = useSite({ sample: 'tiny' });
  const asked = [];
  let server, foreign;
  before(async () => {
    server = createServer(({ url }, response) => {
      asked.push(url);
      response.writeHead(200, { 'access-control-allow-origin': '*', 'content-type': 'text/javascript' });
      response.end('globalThis.broken = 1');
    });
    await new Promise((done) => server.listen(0, '127.0.0.1', done));
    foreign = `http://127.0.0.1:${server.address().port}`;
  });
  after(() => {
    server?.closeAllConnections();
    server?.close();
  });

  test('lets no code run and nothing go out, however it is tried', async () => {
    const { page } = await openSample(site);
    await page.evaluate(() => {
      globalThis.violations = [];
      document.addEventListener('securitypolicyviolation', (event) => {
        globalThis.violations.push(event.effectiveDirective);
      });
    });
    for (const [name, attempt] of Object.entries(ATTEMPTS)) {
      // As a function of the page, which no policy is asked about: what it does is.
      await page.evaluate(`globalThis.attempt = ${attempt}`);
      const refused = await page.evaluate(refusal, `${foreign}/${name}`);
      assert.ok(refused, `${name} was not refused`);
      assert.equal(await page.evaluate(() => globalThis.broken), undefined, name);
    }
    assert.deepEqual(asked, []);
    assert.equal(await page.evaluate(() => document.body.dataset.state), 'done');
  });

  test('has nothing to do where names of files and words of links are markup: they are shown as words', async () => {
    const { page, faults } = await openSample(site, { query: `?${encodeURIComponent(MARKUP)}=1#${MARKUP}` });
    const name = MARKUP.replaceAll('/', '');
    await page.setInputFiles(
      '#file',
      [0, 1, 2].map((k) => pngFile(`${name}${k}.png`, pixels(k))),
    );
    await inPhase(page, 'done');
    const shown = await page.evaluate(() => document.querySelector('#clip-name').textContent);
    assert.ok(shown.includes('<img src=x'), shown);
    await page.setInputFiles('#file', [{ name: `${name}.xyz`, mimeType: 'x/y', buffer: Buffer.from('nothing') }]);
    assert.equal(await ended(page), 'done');
    assert.ok((await page.locator('#notice').innerText()).includes('<img src=x'));
    assert.equal(await page.locator('img[src="x"]').count(), 0);
    assert.equal(await page.evaluate(() => globalThis.broken), undefined);
    assert.deepEqual(faults, []);
  });
});

/** Runs in the page: whether the attempt was refused, by an error or with a report of the policy. */
async function refusal(at) {
  const before = globalThis.violations.length;
  // In a task of the page: in one of the browser's driver `eval` is allowed.
  await new Promise((done) => setTimeout(done));
  let thrown = false;
  (async () => globalThis.attempt(at))().catch(() => (thrown = true));
  for (let k = 0; k < 40 && !thrown && globalThis.violations.length === before; k += 1)
    await new Promise((done) => setTimeout(done, 50));
  return thrown || globalThis.violations.length > before;
}
