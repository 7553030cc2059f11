// Writes dist/parameters.js and its types from the parameters that the wasm module itself lists, so that the option
// tree of the package is typed, documented and never out of step with Rust.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const types = { number: 'number', integer: 'number', boolean: 'boolean' };

/** Writes `parameters.js` and `parameters.d.ts` into `dist` from the wasm module there. */
export async function writeParameters(dist) {
  const glue = await import(`${pathToFileURL(join(dist, 'tracecut.js')).href}?${Date.now()}`);
  glue.initSync({ module: readFileSync(join(dist, 'tracecut_bg.wasm')) });
  const list = glue.parameters().map(plain);
  writeFileSync(
    join(dist, 'parameters.js'),
    [
      '// Written by the build from the Rust declarations of the parameters.',
      `export const VERSION = ${JSON.stringify(glue.version())};`,
      `export const PARAMETERS = ${JSON.stringify(list, null, 2)};`,
      '',
    ].join('\n'),
  );
  writeFileSync(join(dist, 'parameters.d.ts'), declarations(list));
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
  /** The names of all values, for a choice. */
  choices?: readonly string[];
}
/** The parameter tree; every value is optional. */
export interface ParameterOptions {
${tree}}
export declare const VERSION: string;
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
