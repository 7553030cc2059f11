// Rust types and signatures as text, from what rustdoc's JSON says of them. A kind that is not known here, as a later
// rustdoc may have it, is an error and never left out.

/** What is inside an item or a type: its kind and its contents. */
export function kindOf(inner) {
  return typeof inner === 'string' ? [inner, null] : Object.entries(inner)[0];
}

/** The entry of `table` for a kind, called with what the kind holds. */
function choose(table, inner) {
  const [kind, contents] = kindOf(inner);
  if (!(kind in table)) throw new Error(`rustdoc's JSON has a kind "${kind}" that scripts/api does not know.`);
  return table[kind](contents);
}

const TYPES = {
  resolved_path: path,
  dyn_trait: ({ traits, lifetime }) => `dyn ${[...traits.map(polyTrait), ...(lifetime ? [lifetime] : [])].join(' + ')}`,
  generic: (name) => name,
  primitive: (name) => (name === 'never' ? '!' : name),
  function_pointer: ({ sig }) => `fn${parameters(sig)}`,
  tuple: (types) => (types.length === 1 ? `(${type(types[0])},)` : `(${types.map(type).join(', ')})`),
  slice: (inner) => `[${type(inner)}]`,
  array: ({ type: inner, len }) => `[${type(inner)}; ${len}]`,
  impl_trait: (bounds) => `impl ${bounds.map(bound).join(' + ')}`,
  infer: () => '_',
  borrowed_ref: ({ lifetime, is_mutable, type: inner }) =>
    `&${lifetime ? `${lifetime} ` : ''}${is_mutable ? 'mut ' : ''}${type(inner)}`,
  qualified_path: ({ name, args, self_type, trait: of }) =>
    of?.path
      ? `<${type(self_type)} as ${path(of)}>::${name}${generic(args)}`
      : `${type(self_type)}::${name}${generic(args)}`,
};

/** A type as it is written, by its own name alone: `Vec<f32>`, `&mut Plane<T>`. */
export function type(inner) {
  return choose(TYPES, inner);
}

/** A path by its last name, with its arguments. */
export function path({ path: words, args }) {
  return words.split('::').at(-1) + generic(args);
}

function generic(args) {
  return args ? choose({ angle_bracketed: angles, parenthesized: parameters }, args) : '';
}

function angles({ args, constraints }) {
  const all = [...args.map(argument), ...constraints.map(constraint)];
  return all.length > 0 ? `<${all.join(', ')}>` : '';
}

function argument(inner) {
  return choose({ lifetime: (name) => name, type, const: constant, infer: () => '_' }, inner);
}

function constraint({ name, args, binding }) {
  const value = choose({ equality: (term) => ` = ${choose({ type, constant }, term)}`, constraint: bounded }, binding);
  return `${name}${generic(args)}${value}`;
}

const constant = ({ expr }) => expr;

function polyTrait({ trait: of, generic_params: lifetimes }) {
  return `${lifetimes.length > 0 ? `for${params(lifetimes)} ` : ''}${path(of)}`;
}

function bound(inner) {
  return choose(
    {
      trait_bound: (of) => `${of.modifier === 'maybe' ? '?' : ''}${polyTrait(of)}`,
      outlives: (lifetime) => lifetime,
      use: (names) => `use<${names.map((name) => kindOf(name)[1] ?? 'Self').join(', ')}>`,
    },
    inner,
  );
}

/** `: A + B`, or nothing. */
export function bounded(bounds) {
  return bounds.length > 0 ? `: ${bounds.map(bound).join(' + ')}` : '';
}

/** Generic parameters in their brackets; those that stand for an `impl` in an argument are left out. */
export function params(list) {
  const written = list.filter(({ kind }) => !kind.type?.is_synthetic).map(param);
  return written.length > 0 ? `<${written.join(', ')}>` : '';
}

function param({ name, kind }) {
  const after = {
    lifetime: ({ outlives }) => (outlives.length > 0 ? `: ${outlives.join(' + ')}` : ''),
    type: ({ bounds, default: initial }) => bounded(bounds) + (initial ? ` = ${type(initial)}` : ''),
    const: ({ type: inner, default: initial }) => `: ${type(inner)}${initial ? ` = ${initial}` : ''}`,
  };
  return `${'const' in kind ? 'const ' : ''}${name}${choose(after, kind)}`;
}

/** `where` and its clauses, or nothing. */
export function where(predicates) {
  const clauses = predicates.map((inner) =>
    choose(
      {
        bound_predicate: ({ type: of, bounds }) => type(of) + bounded(bounds),
        lifetime_predicate: ({ lifetime, outlives }) => `${lifetime}: ${outlives.join(' + ')}`,
      },
      inner,
    ),
  );
  return clauses.length > 0 ? ` where ${clauses.join(', ')}` : '';
}

/** Parameters and result: `(&self, frame: &Frame) -> Result<(), Error>`. */
function parameters({ inputs, output }) {
  const result = output ? ` -> ${type(output)}` : '';
  return `(${inputs.map((input) => (Array.isArray(input) ? named(input) : type(input))).join(', ')})${result}`;
}

function named([name, inner]) {
  const words = type(inner);
  if (name === 'self' && /^&?('\w+ )?(mut )?Self$/.test(words)) return words.replace('Self', 'self');
  return name && name !== '_' ? `${name}: ${words}` : words;
}

/** What stands after the name of a function. */
export function signature({ sig, generics }) {
  return params(generics.params) + parameters(sig) + where(generics.where_predicates);
}

/** What stands before it. */
export function qualifiers({ is_const: constant, is_async: later, is_unsafe: unsafe }) {
  return `${constant ? 'const ' : ''}${later ? 'async ' : ''}${unsafe ? 'unsafe ' : ''}fn`;
}
