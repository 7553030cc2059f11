// Wasm modules with a fault, to test internal errors, or with little memory. Runs in Node and in pages.

/**
 * The bytes of a module in which the exported function `name` is nothing but `unreachable`.
 * @param {Uint8Array} bytes
 * @param {string} name
 */
export function withTrap(bytes, name) {
  const broken = bytes.slice();
  const reader = new Reader(broken);
  reader.at = 8;
  let [imported, functionIndex] = [0, -1];
  while (reader.at < broken.length) {
    const section = reader.byte();
    const end = reader.number() + reader.at;
    if (section === 2) imported = reader.list(() => reader.imports()).filter((kind) => kind === 0).length;
    if (section === 7)
      functionIndex = reader.list(() => reader.export()).find((entry) => entry.name === name)?.index ?? -1;
    if (section === 10) {
      if (functionIndex < imported) throw new Error(`the module exports no function ${name}`);
      reader.list((k) => reader.body(k === functionIndex - imported));
    }
    reader.at = end;
  }
  return broken;
}

/**
 * The bytes of a module whose memory cannot grow beyond `mebibytes`.
 * @param {Uint8Array} bytes
 * @param {number} mebibytes
 */
export function withMemory(bytes, mebibytes) {
  const reader = new Reader(bytes);
  reader.at = 8;
  while (reader.at < bytes.length) {
    const begin = reader.at;
    const section = reader.byte();
    const end = reader.number() + reader.at;
    if (section === 5)
      return Uint8Array.from([...bytes.subarray(0, begin), ...memory(reader, mebibytes), ...bytes.subarray(end)]);
    reader.at = end;
  }
  throw new Error('the module has no memory');
}

/** A section with one memory: a flag that says that there is a most, the pages at first, and the most. */
function memory(reader, mebibytes) {
  const [count, flag] = [reader.number(), reader.byte()];
  if (count !== 1 || flag !== 0) throw new Error('the module has several memories, or one with a most already');
  const body = [1, 1, ...leb128(reader.number()), ...leb128(16 * mebibytes)];
  return [5, ...leb128(body.length), ...body];
}

function leb128(value) {
  return value < 128 ? [value] : [(value & 127) | 128, ...leb128(value >>> 7)];
}

class Reader {
  at = 0;

  constructor(bytes) {
    this.bytes = bytes;
  }

  byte() {
    return this.bytes[this.at++];
  }

  /** An unsigned LEB128. */
  number() {
    let [value, shift, byte] = [0, 0, 0];
    do {
      byte = this.byte();
      value += (byte & 127) * 2 ** shift;
      shift += 7;
    } while (byte & 128);
    return value;
  }

  text() {
    const length = this.number();
    this.at += length;
    return new TextDecoder().decode(this.bytes.subarray(this.at - length, this.at));
  }

  list(item) {
    return Array.from({ length: this.number() }, (_, k) => item(k));
  }

  /** The kind of an import; wasm-bindgen's module imports functions alone. */
  imports() {
    this.text();
    this.text();
    const kind = this.byte();
    if (kind !== 0) throw new Error(`an import of kind ${kind}`);
    this.number();
    return kind;
  }

  export() {
    const name = this.text();
    const kind = this.byte();
    return { name, index: kind === 0 ? this.number() : (this.number(), -1) };
  }

  /** A function's body; a broken one has no locals, `unreachable`, `nop` as often as it takes, and `end`. */
  body(broken) {
    const size = this.number();
    const code = this.bytes.subarray(this.at, this.at + size);
    if (broken) {
      code.fill(1);
      code.set([0, 0]);
      code.set([11], size - 1);
    }
    this.at += size;
  }
}
