// The documentation's pages as the site has them: every link and picture leads somewhere, nothing comes from elsewhere,
// and the search finds what is there.

import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { runInNewContext } from 'node:vm';
import { excerpt, find, wordsOf } from '../../scripts/documents/find.mjs';
import { lex, linkFrom, render } from '../../scripts/documents/markdown.mjs';
import { writeSite } from '../../scripts/site.mjs';
import { root } from '../../scripts/tools.mjs';

const site = mkdtempSync(join(tmpdir(), 'tracecut-site-'));
let listed, pages, index;

before(async () => {
  listed = await writeSite(site);
  pages = filesIn(join(site, 'docs')).filter((file) => file.endsWith('.html'));
  const context = {};
  runInNewContext(readFileSync(join(site, 'docs', 'search-index.js'), 'utf8'), context);
  index = JSON.parse(JSON.stringify(context.tracecutDocs));
});
after(() => rmSync(site, { recursive: true }));

const filesIn = (folder) =>
  readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => join(entry.parentPath ?? entry.path, entry.name));
const read = (file) => readFileSync(file, 'utf8');
const attributes = (html, name) =>
  [...html.matchAll(new RegExp(`\\s${name}="([^"]*)"`, 'g'))].map(([, value]) => value);

/** What is wrong with a link from a page, or null. */
function fault(page, target) {
  const [path, anchor] = decodeURI(target).split('#');
  const file = path ? resolve(dirname(page), path) : page;
  const where = `${page.slice(site.length + 1)}: ${target}`;
  if (!file.startsWith(site)) return `${where} leads out of the site`;
  if (!existsSync(file)) return `${where} leads nowhere`;
  return !anchor || attributes(read(file), 'id').includes(anchor) ? null : `${where} names no place there`;
}

test('each Markdown file of docs/ has a page, and so have README, examples and changes', () => {
  const names = pages.map((file) => file.slice(join(site, 'docs').length + 1).replaceAll('\\', '/'));
  for (const name of ['index', 'guide', 'method', 'reference', 'results', 'limits', 'examples', 'changes'])
    assert.ok(names.includes(`${name}.html`), name);
  const sources = readdirSync(join(root, 'docs'), { recursive: true }).filter((name) => name.endsWith('.md'));
  assert.equal(names.length, sources.length + 4);
});

test('every link, picture, style and script of the site leads to a file and a place that are there', () => {
  const all = [...pages, join(site, 'index.html')];
  const links = all.flatMap((page) =>
    [...attributes(read(page), 'href'), ...attributes(read(page), 'src')]
      .filter((target) => !/^[a-z][a-z+.-]*:/i.test(target))
      .map((target) => ({ page, target })),
  );
  assert.ok(links.length > 500, `${links.length} links`);
  assert.deepEqual(links.map(({ page, target }) => fault(page, target)).filter(Boolean), []);
  assert.match(fault(pages[0], 'nothing.html'), /leads nowhere/);
  assert.match(fault(pages[0], '#nothing'), /names no place/);
  assert.match(fault(pages[0], '../../nothing.html'), /out of the site/);
});

test('no name of a place is there twice on a page', () => {
  for (const page of pages) {
    const ids = attributes(read(page), 'id');
    assert.deepEqual(
      ids.filter((id, k) => ids.indexOf(id) !== k),
      [],
      page,
    );
  }
});

test('the pages ask for nothing from elsewhere, and a first visit for none of them', () => {
  for (const page of pages) {
    const html = read(page);
    const asked = [...html.matchAll(/<(?:img|script|link)[^>]*\s(?:src|href)="([^"]*)"/g)].map(([, target]) => target);
    assert.ok(asked.length >= 3);
    assert.deepEqual(
      asked.filter((target) => /^([a-z]+:|\/)/i.test(target)),
      [],
    );
    assert.match(html, /default-src 'none'/);
  }
  assert.doesNotMatch(read(join(site, 'docs', 'docs.css')), /url\(|@import/);
  assert.deepEqual(
    listed.filter((name) => name.includes('/docs/')),
    [],
  );
});

test('the search finds a function at its place in the reference, first', () => {
  assert.equal(find(index, 'segmentVideo')[0].url, 'reference.html#segmentvideo');
  assert.equal(find(index, 'SEGMENTVIDEO')[0].url, 'reference.html#segmentvideo');
  assert.ok(find(index, 'content security policy').some(({ url }) => url === 'guide.html#bundlers'));
  assert.ok(find(index, 'trajectory.gridStep').length > 0);
  assert.deepEqual(find(index, 'segmentVideo nosuchword'), []);
  assert.deepEqual(find(index, '  '), []);
  assert.equal(find(index, 'the', 3).length, 3);
});

test('what the search knows are places of the pages', () => {
  assert.ok(index.length > 250, `${index.length} sections`);
  const page = join(site, 'docs', 'index.html');
  assert.deepEqual(index.map(({ url }) => fault(page, url)).filter(Boolean), []);
});

test('an excerpt is around the first of the words', () => {
  const text = `${'before '.repeat(40)}needle ${'after '.repeat(40)}`;
  assert.match(excerpt(text, 'Needle'), /^….*needle.*…$/);
  assert.equal(excerpt('short', 'nothing'), 'short');
  assert.deepEqual(wordsOf("segmentVideo('x') flow.patchStride"), ['segmentvideo', 'x', 'flow.patchstride']);
});

test('links lead to pages here, and to the repository where a file has none', () => {
  const page = (path, source, text) => ({ path, source, tokens: lex(text) });
  const all = [page('a.html', 'docs/a.md', '# A\n## One\n## One'), page('r/b.html', 'docs/r/b.md', '# B')];
  const [a, b] = all;
  const outside = 'https://github.com/tracecut/tracecut/blob/HEAD/';
  assert.equal(linkFrom('r/b.md', a, all), 'r/b.html');
  assert.equal(linkFrom('../a.md#one-1', b, all), '../a.html#one-1');
  assert.equal(linkFrom('#one', a, all), '#one');
  assert.equal(linkFrom(`${outside}docs/a.md#one`, b, all), '../a.html#one');
  assert.equal(linkFrom('../ARCHITECTURE.md#data-flow', a, all), `${outside}ARCHITECTURE.md#data-flow`);
  assert.equal(linkFrom('https://example.org/a.md', a, all), 'https://example.org/a.md');
  assert.throws(() => linkFrom('nothing.md', a, all), /docs\/a\.md: the link nothing\.md leads nowhere/);
});

test('code and HTML in the sources are text on the pages', () => {
  const source = '# A\n\n```js\nif (a < b) alert("<b>");\n```\n\n<script>alert(1)</script>\n';
  const { html } = render({ path: 'a.html', title: 'A', source: 'a.md', tokens: lex(source) }, []);
  assert.match(html, /<pre><code class="language-js">if \(a &lt; b\) alert\(&quot;&lt;b&gt;&quot;\);/);
  assert.doesNotMatch(html, /<script/);
});

test('every script of the site has a source map with its sources, and none names a place of this machine', () => {
  const scripts = filesIn(site).filter((file) => file.endsWith('.js') && !file.endsWith('search-index.js'));
  assert.ok(scripts.length > 30, `${scripts.length} scripts`);
  for (const file of scripts) {
    const { sources, sourcesContent } = JSON.parse(read(`${file}.map`));
    assert.equal(sourcesContent.filter(Boolean).length, sources.length, file);
    assert.deepEqual(
      sources.filter((source) => source.startsWith('/') || source.includes(site.slice(1))),
      [],
    );
    const named = /\/\/# sourceMappingURL=(\S+)\s*$/.exec(read(file))?.[1];
    if (named ?? read(file).length >= 4096) assert.ok(named && existsSync(join(dirname(file), named)), file);
  }
  assert.deepEqual(
    listed.filter((name) => name.endsWith('.map')),
    [],
  );
});
