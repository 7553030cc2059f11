// The package in one file, with its wasm files and its worker inside. Nothing is unpacked before it is needed.

import { createScriptBlob, places } from '../../dist/platform.js';
import { unzlibSync } from '../../dist/vendor/zip.js';
import { DECODER, ENGINE, WORKER } from 'packed';

/** Unpacks bytes that the build packed: base64 of zlib. */
const unpacked = (text) => unzlibSync(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)));

let address;

function worker() {
  address ??= URL.createObjectURL(createScriptBlob(new TextDecoder().decode(unpacked(WORKER))));
  // Not as a module: a page that was opened as a file starts none.
  return new Worker(address);
}

Object.assign(places, { wasm: () => unpacked(ENGINE), decoder: () => unpacked(DECODER), worker });

export * from '../../dist/index.js';
export * from '../../dist/draw.js';
export * from '../../dist/edit.js';
export * from '../../dist/export.js';
export * from '../../dist/stages.js';
