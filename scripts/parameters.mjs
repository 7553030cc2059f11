// Writes dist/parameters.js and its types from the parameters that the wasm module lists and their declarations, so that the
// option tree of the package is typed, documented and always in step with Rust.

import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { fail, root } from './tools.mjs';

const types = { number: 'number', integer: 'number', boolean: 'boolean' };

/** The Rust files that declare parameters. */
export function parameterSources() {
  return readdirSync(join(root, 'src'), { recursive: true })
    .filter((name) => name.endsWith('.rs'))
    .map((name) => join(root, 'src', name))
    .sort();
}

/**
 * Writes `parameters.js` and `parameters.d.ts` into `dist`: names, ranges and defaults from the wasm module, which has no
 * descriptions, and the descriptions from the declarations in Rust.
 */
export async function writeParameters(dist) {
  const glue = await import(`${pathToFileURL(join(dist, 'tracecut.js')).href}?${Date.now()}`);
  glue.initSync({ module: readFileSync(join(dist, 'tracecut_bg.wasm')) });
  const docs = readDocs();
  const list = glue.parameters().map((parameter) => plain({ ...parameter, doc: docs.get(parameter.name) }));
  const nameless = list.find(({ doc }) => !doc);
  if (nameless) fail(`${nameless.name} has no description that the build can read.`);
  const [frames, most, overlap] = glue.windows();
  writeFileSync(
    join(dist, 'parameters.js'),
    [
      '// Written by the build from the Rust declarations of the parameters.',
      `export const VERSION = ${JSON.stringify(glue.version())};`,
      `export const WINDOWS = ${JSON.stringify({ frames, most, overlap })};`,
      `export const STAGE_COSTS = ${JSON.stringify(readStageCosts())};`,
      `const ROWS = [\n${list.map((parameter) => `  ${JSON.stringify(row(parameter))},\n`).join('')}];`,
      'const parameter = ([name, doc, kind, min, max, value, expert, choices]) =>',
      '  ({ name, doc, kind, min, max, default: value, expert: !!expert, ...(choices && { choices }) });',
      'export const PARAMETERS = /* @__PURE__ */ ROWS.map(parameter);',
      '',
    ].join('\n'),
  );
  writeFileSync(join(dist, 'parameters.d.ts'), declarations(list));
}

/** Returns the usual time of each stage for a frame, as `stages!` declares it. */
function readStageCosts() {
  const text = readFileSync(join(root, 'src', 'session', 'base', 'stage.rs'), 'utf8');
  const costs = [...text.matchAll(/^ +\w+ = "(\w+)", ([\d.]+);$/gm)].map(([, stage, cost]) => [stage, Number(cost)]);
  return costs.length > 0 ? costs : fail('The build cannot read the costs of stages.');
}

/** Returns the description of each parameter by name: the comment above its field in `params!` or `tree!`. */
function readDocs() {
  const text = parameterSources()
    .map((file) => readFileSync(file, 'utf8'))
    .join('\n');
  const [, tree] = /^tree! \{$(.*?)^\}$/ms.exec(text);
  const docs = new Map();
  for (const [, section, group] of tree.matchAll(/^ +(\w+): (\w+),$/gm)) {
    const [, fields] = new RegExp(`^    pub struct ${group} \\{$(.*?)^    \\}$`, 'ms').exec(text);
    for (const [, comment, field] of fields.matchAll(/((?:^ +\/\/\/.*\n)+) +pub (\w+):/gm)) {
      const name = `${section}.${field.replace(/_(\w)/g, (_, letter) => letter.toUpperCase())}`;
      docs.set(name, comment.replaceAll(/^ +\/\/\/ ?/gm, '').trim());
    }
  }
  return docs;
}

/** Returns a parameter without its property names, which would be repeated a hundred times. */
function row({ name, doc, kind, min, max, default: value, expert, choices }) {
  return [name, doc.replace(/\s*\n\s*/g, ' '), kind, min, max, value, Number(expert), ...(choices ? [choices] : [])];
}

/** Returns a parameter with its default in the form of an option: true or false, or the name of a choice. */
function plain({ choices, ...parameter }) {
  if (parameter.kind === 'boolean') return { ...parameter, min: 0, max: 1, default: parameter.default !== 0 };
  if (parameter.kind === 'choice') return { ...parameter, default: choices[parameter.default], choices };
  return parameter;
}

function declarations(list) {
  const sections = new Map();
  for (const parameter of list) {
    const [section, field] = parameter.name.split('.');
    sections.set(section, [...(sections.get(section) ?? []), { ...parameter, field }]);
  }
  const tree = [...sections]
    .map(([section, fields]) => `  ${section}?: {\n${fields.map(member).join('')}  };\n`)
    .join('');
  return `/** One parameter: its dotted name, meaning, kind, legal range and default. */
export interface Parameter {
  name: string;
  doc: string;
  kind: 'number' | 'integer' | 'boolean' | 'choice';
  min: number;
  max: number;
  default: number | boolean | string;
  /** Whether only research changes it; such parameters are listed apart. */
  expert: boolean;
  /** The names of all values, for a choice. */
  choices?: readonly string[];
}
/** The parameter tree; every value is optional. */
export interface ParameterOptions {
${tree}}
export declare const VERSION: string;
/** Frames of a window where nobody says, the most it may have, and how many neighbours share where nobody says. */
export declare const WINDOWS: { readonly frames: number; readonly most: number; readonly overlap: number };
/** The stages in order, and the usual time of each for a frame; flow and trajectories together are one unit. */
export declare const STAGE_COSTS: readonly (readonly [stage: string, cost: number])[];
export declare const PARAMETERS: readonly Readonly<Parameter>[];
`;
}

function member({ field, doc, kind, min, max, choices, default: initial }) {
  const range = kind === 'boolean' || kind === 'choice' ? '' : ` Range: ${min} to ${max}.`;
  const type = kind === 'choice' ? choices.map((name) => `'${name}'`).join(' | ') : types[kind];
  const text = `${doc}\n${range} Default: ${initial}.`
    .split('\n')
    .map((line) => `     * ${line.trim()}\n`)
    .join('');
  return `    /**\n${text}     */\n    ${field}?: ${type};\n`;
}
