// The package as the page takes it: all of its entries as one, which is what the built site serves.

export * from '../dist/index.js';
export * from '../dist/draw.js';
export * from '../dist/edit.js';
export * from '../dist/export.js';
export * from '../dist/stages.js';
