// Gives the declarations that the compiler wrote what it leaves out: a type's description, which it drops or leaves
// apart from the type, so that an editor shows it and the reference can quote it.

import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

/** Rewrites the declarations in `dist` of the modules in `lib`. */
export function describeTypes(lib, dist) {
  for (const name of readdirSync(lib, { recursive: true }).filter((file) => file.endsWith('.js'))) {
    const file = join(dist, name.replace(/\.js$/, '.d.ts'));
    writeFileSync(file, described(readFileSync(file, 'utf8'), descriptions(readFileSync(join(lib, name), 'utf8'))));
  }
}

/** What the comments of a module's types say before their tags, by the types' names. */
export function descriptions(source) {
  const found = new Map();
  for (const [comment] of source.matchAll(/^\/\*\*[^]*?\*\//gm)) {
    const text = comment
      .slice(3, -2)
      .split('\n')
      .map((line) => line.replace(/^\s*\*? ?/, '').trimEnd())
      .join('\n');
    const [before, after] = text.split('@typedef');
    const words = before.split(/^@/m)[0].trim();
    if (after && words) found.set(/^\w+/.exec(withoutType(after.trim()))?.[0], words);
  }
  return found;
}

/** What follows a tag's `{type}`. */
export function withoutType(text) {
  if (!text.startsWith('{')) return text;
  let depth = 0;
  for (let at = 0; at < text.length; at += 1) {
    depth += text[at] === '{' ? 1 : text[at] === '}' ? -1 : 0;
    if (depth === 0) return text.slice(at + 1).trim();
  }
  return '';
}

function described(declarations, words) {
  const bare = declarations.replace(/^\/\*\*(?:(?!\*\/)[^])*@typedef[^]*?\*\/\n/gm, '');
  // A name that is only passed on keeps its description so; one that the file uses itself has to stay an alias.
  const used = (name) => bare.match(new RegExp(`\\b${name}\\b`, 'g')).length > 2;
  return bare
    .replace(/^export type (\w+) = import\('([^']+)'\)\.\1;$/gm, (line, name, from) =>
      used(name) ? line : `export type { ${name} } from '${from}';`,
    )
    .replace(/^export type (\w+)(?=[ <])/gm, (line, name) =>
      words.has(name) ? `/**\n${commented(words.get(name))} */\n${line}` : line,
    );
}

function commented(words) {
  return words
    .split('\n')
    .map((line) => ` * ${line}`.trimEnd() + '\n')
    .join('');
}
