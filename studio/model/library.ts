// The package as the page takes it: its entries as one, which is what the built site serves. Paths lead to the same files
// on disk and on the server, where nothing lies above `/`.

export * from '../../dist/index.js';
export * from '../../dist/draw.js';
export * from '../../dist/edit.js';
export * from '../../dist/export.js';
export * from '../../dist/stages.js';
