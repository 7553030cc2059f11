// The public interface of a crate as lines of text, from what rustdoc's JSON says of it: one line for each item, by its
// full name, and one for the traits of each type.

import { bounded, kindOf, params, path, qualifiers, signature, type, where } from './signature.mjs';

/** Kinds that count as items: what a reader of the documentation meets with a heading of its own. */
const COUNTED = ['mod', 'struct', 'enum', 'union', 'trait', 'fn', 'const', 'static', 'type', 'macro'];

/**
 * All public items, sorted by name, and how many of them count: all but fields, variants, traits implemented and names
 * given a second time.
 * @returns {{lines: string[], count: number}}
 */
export function listApi(json) {
  const list = new Lister(json);
  list.module(json.index[json.root], '');
  for (const use of list.uses) list.use(use.item, use.parent);
  list.implementations();
  const entries = list.entries.sort((a, b) => compare(a.name, b.name) || compare(a.line, b.line));
  return { lines: entries.map(({ line }) => line), count: entries.filter(({ kind }) => COUNTED.includes(kind)).length };
}

const compare = (a, b) => (a < b ? -1 : Number(a > b));

class Lister {
  constructor(json) {
    this.json = json;
    this.entries = [];
    this.uses = [];
    /** @type {Map<number, string>} names of what is listed, by its id */
    this.names = new Map();
  }

  item(id) {
    return this.json.index[id];
  }

  /** Adds a line: the words before the name, the name, the words after it. */
  add(item, kind, name, after = '', before = kind) {
    const closed = item?.attrs.some((attribute) => JSON.stringify(attribute).includes('non_exhaustive'));
    this.entries.push({ name, kind, line: `${closed ? '#[non_exhaustive] ' : ''}${before} ${name}${after}` });
  }

  module(item, parent) {
    const name = parent ? `${parent}::${item.name}` : item.name;
    this.names.set(item.id, name);
    this.add(item, 'mod', name);
    this.all(item.inner.module.items, name);
  }

  all(ids, parent) {
    for (const id of ids) if (this.item(id)) this.visit(this.item(id), parent);
  }

  visit(item, parent, name = `${parent}::${item.name}`) {
    const [kind, inner] = kindOf(item.inner);
    if (kind === 'use') return this.uses.push({ item, parent });
    if (kind === 'module') return this.module(item, parent);
    if (!(kind in this)) throw new Error(`rustdoc's JSON has an item "${kind}" that scripts/api does not know.`);
    this.names.set(item.id, name);
    return this[kind](item, inner, name);
  }

  /** A name from elsewhere: listed as if it were here when it can be reached in no other way. */
  use(item, parent) {
    const { id, name, source, is_glob: glob } = item.inner.use;
    const target = this.item(id);
    if (target && glob) return this.all(target.inner.module.items, parent);
    if (target && !this.names.has(id)) return this.visit(target, parent, `${parent}::${name}`);
    return this.add(item, 'use', `${parent}::${name}`, ` = ${this.names.get(id) ?? source}`);
  }

  struct(item, { kind, generics, impls }, name) {
    const tuple = kind.tuple?.map((id) => (this.item(id) ? type(this.item(id).inner.struct_field) : '_'));
    this.add(
      item,
      'struct',
      name,
      params(generics.params) + (tuple ? `(${tuple.join(', ')})` : '') + clauses(generics),
    );
    this.all(kind.plain?.fields ?? [], name);
    this.inherent(impls, name);
  }

  struct_field(item, inner, name) {
    this.add(item, 'field', name, `: ${type(inner)}`);
  }

  enum(item, { generics, variants, impls }, name) {
    this.add(item, 'enum', name, params(generics.params) + clauses(generics));
    this.all(variants, name);
    this.inherent(impls, name);
  }

  variant(item, { kind, discriminant }, name) {
    const tuple = kind.tuple?.map((id) => (this.item(id) ? type(this.item(id).inner.struct_field) : '_'));
    this.add(
      item,
      'variant',
      name,
      (tuple ? `(${tuple.join(', ')})` : '') + (discriminant ? ` = ${discriminant.expr}` : ''),
    );
    this.all(kind.struct?.fields ?? [], name);
  }

  trait(item, { generics, bounds, items }, name) {
    this.add(item, 'trait', name, params(generics.params) + bounded(bounds) + clauses(generics));
    this.all(items, name);
  }

  function(item, { sig, generics, header }, name) {
    this.add(item, 'fn', name, signature({ sig, generics }), qualifiers(header));
  }

  constant(item, inner, name) {
    this.add(item, 'const', name, `: ${type(inner.type)}`);
  }

  static(item, inner, name) {
    this.add(item, 'static', name, `: ${type(inner.type)}`);
  }

  assoc_const(item, inner, name) {
    this.add(item, 'const', name, `: ${type(inner.type)}`);
  }

  assoc_type(item, { bounds }, name) {
    this.add(item, 'type', name, bounded(bounds));
  }

  type_alias(item, { type: inner, generics }, name) {
    this.add(item, 'type', name, `${params(generics.params)} = ${type(inner)}`);
  }

  macro(item, inner, name) {
    this.add(item, 'macro', name, '!');
  }

  /** What a type has of its own. */
  inherent(impls, name) {
    for (const id of impls) {
      const { trait: of, items } = this.item(id)?.inner.impl ?? { trait: true };
      if (!of) this.all(items, name);
    }
  }

  /** A line for each type: the traits that it was given, the compiler's own left out. */
  implementations() {
    const traits = new Map();
    for (const { inner } of Object.values(this.json.index)) {
      const { trait: of, for: self, generics, is_synthetic: automatic, blanket_impl: blanket } = inner.impl ?? {};
      if (!of || automatic || blanket || path(of) === 'StructuralPartialEq') continue;
      const name = this.names.get(self.resolved_path?.id) ?? type(self);
      const key = name + (self.resolved_path ? path(self.resolved_path).replace(/^[^<]*/, '') : '');
      traits.set(key, [...(traits.get(key) ?? []), path(of) + clauses(generics).replace(/^ (.+)$/, ' ($1)')]);
    }
    for (const [name, all] of traits) this.add(null, 'impl', name, `: ${all.sort().join(' + ')}`);
  }
}

const clauses = ({ where_predicates: predicates }) => where(predicates);
