// Writes dist/parameters.js and its types from the parameters that the wasm module itself lists, so that the option
// tree of the package is typed, documented and never out of step with Rust.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const types = { number: 'number', integer: 'number', boolean: 'boolean' };

/**
 * Writes `parameters.js` and `parameters.d.ts` into `dist` from the wasm module there, which then does without the
 * descriptions: `parameters.js` has them, and no visitor of a page needs them twice.
 */
export async function writeParameters(dist) {
  const glue = await import(`${pathToFileURL(join(dist, 'tracecut.js')).href}?${Date.now()}`);
  const wasm = readFileSync(join(dist, 'tracecut_bg.wasm'));
  glue.initSync({ module: wasm });
  const list = glue.parameters().map(plain);
  const [frames, most, overlap] = glue.windows();
  writeFileSync(
    join(dist, 'parameters.js'),
    [
      '// Written by the build from the Rust declarations of the parameters.',
      `export const VERSION = ${JSON.stringify(glue.version())};`,
      `export const WINDOWS = ${JSON.stringify({ frames, most, overlap })};`,
      `const ROWS = [\n${list.map((parameter) => `  ${JSON.stringify(row(parameter))},\n`).join('')}];`,
      'const parameter = ([name, doc, kind, min, max, value, expert, choices]) =>',
      '  ({ name, doc, kind, min, max, default: value, expert: !!expert, ...(choices && { choices }) });',
      'export const PARAMETERS = /* @__PURE__ */ ROWS.map(parameter);',
      '',
    ].join('\n'),
  );
  writeFileSync(join(dist, 'parameters.d.ts'), declarations(list));
  list.forEach(({ doc }) => blank(wasm, doc));
  writeFileSync(join(dist, 'tracecut_bg.wasm'), wasm);
}

/** Spaces in place of a text, which lies in the module's data once or, where the linker took it apart, not at all. */
function blank(wasm, text) {
  const at = wasm.indexOf(text);
  if (text.length > 20 && at >= 0) wasm.fill(' ', at, at + Buffer.byteLength(text));
}

/** A parameter without the names of its properties, which would be there a hundred times. */
function row({ name, doc, kind, min, max, default: value, expert, choices }) {
  return [name, doc.replace(/\s*\n\s*/g, ' '), kind, min, max, value, Number(expert), ...(choices ? [choices] : [])];
}

/** A parameter with its default as options have it: true or false, or the name of a choice. */
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
