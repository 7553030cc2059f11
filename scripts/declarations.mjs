// Gives the declarations that the compiler wrote what it leaves out: a type's description, which it drops or leaves
// apart from the type, so that an editor and the reference show it.

import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { dirname, join, posix, relative } from 'node:path';
import { parse } from 'comment-parser';

/** Rewrites the declarations in `dist` of the modules in `lib`. */
export function describeTypes(lib, dist) {
  for (const name of readdirSync(lib, { recursive: true }).filter((file) => file.endsWith('.js'))) {
    const file = join(dist, name.replace(/\.js$/, '.d.ts'));
    writeFileSync(file, described(readFileSync(file, 'utf8'), descriptions(readFileSync(join(lib, name), 'utf8'))));
  }
}

/** The declarations that know the platform's names, below `dist`. */
const DOM = 'dom.d.ts';

/**
 * Puts an import before each declaration file of `dist` that mentions names of the platform, so that it compiles in
 * projects that do not have them.
 */
export function importPlatform(dist) {
  const names = exported(readFileSync(join(dist, DOM), 'utf8'));
  const files = readdirSync(dist, { recursive: true }).map((file) => file.replaceAll('\\', '/'));
  for (const name of files.filter((file) => file.endsWith('.d.ts') && file !== DOM && !file.startsWith('vendor/'))) {
    const file = join(dist, name);
    const text = readFileSync(file, 'utf8').replace(/^import type \{.*\} from '[./]*dom\.js';\n/, '');
    const used = names.filter((one) => mentions(text, one));
    const from = posix.join(relative(dirname(name), '.').replaceAll('\\', '/') || '.', 'dom.js');
    const line = `import type { ${used.join(', ')} } from '${from.startsWith('.') ? from : `./${from}`}';\n`;
    writeFileSync(file, used.length > 0 ? line + text : text);
  }
}

function exported(declarations) {
  return [...declarations.matchAll(/^export (?:declare )?(?:type|interface|namespace) (\w+)/gm)].map(
    ([, name]) => name,
  );
}

/** Whether a name stands outside of comments and strings, alone: not as a property, nor as one of another module. */
function mentions(declarations, name) {
  const code = declarations.replace(/\/\*[^]*?\*\/|\/\/.*$|'[^'\n]*'|"[^"\n]*"/gm, '');
  return new RegExp(`(?<![.\\w])${name}\\b(?!\\??\\s*:)`).test(code);
}

/** What the comments of a module's types say before their tags, by the types' names. */
export function descriptions(source) {
  const found = new Map();
  // A tag begins a line: those of comments in one line too.
  for (const { description, tags } of parse(source.replaceAll(' @typedef', '\n * @typedef'), { spacing: 'preserve' })) {
    const words = description.replace(/^ (?=\S)/gm, '').trim();
    for (const { tag, name } of tags) if (tag === 'typedef' && words) found.set(name, words);
  }
  return found;
}

function described(declarations, words) {
  const bare = declarations.replace(/^\/\*\*(?:(?!\*\/)[^])*@typedef[^]*?\*\/\n/gm, '');
  // A name that is only passed on keeps its description so; one that the file uses itself has to stay an alias.
  const used = (name) => bare.match(new RegExp(`(?<![.\\w])${name}\\b`, 'g')).length > 1;
  return (
    bare
      // A part that is loaded later is declared where it is written, with its description.
      .replace(
        /^(?:\/\*\* @type \{.*\} \*\/\n)?export declare const (\w+): typeof import\(['"]([^'"]+)['"]\)\.\1;$/gm,
        "export { $1 } from '$2';",
      )
      .replace(/^export type (\w+) = import\('([^']+)'\)\.\1;$/gm, (line, name, from) =>
        used(name) ? line : `export type { ${name} } from '${from}';`,
      )
      // The compiler heeds this tag but does not write what it means.
      .replace(/( @readonly \*\/|\n +\* @readonly\n +\*\/)\n( +)(?=\w+:)/g, (_, tag, indent) =>
        tag.startsWith('\n') ? `\n${indent} */\n${indent}readonly ` : ` */\n${indent}readonly `,
      )
      .replace(/^export type (\w+)(?=[ <])/gm, (line, name) =>
        words.has(name) ? `/**\n${commented(words.get(name))} */\n${line}` : line,
      )
  );
}

function commented(words) {
  return words
    .split('\n')
    .map((line) => ` * ${line}`.trimEnd() + '\n')
    .join('');
}
