// The package's entries as one module. Its paths lead to the same files on disk and on the server, where nothing lies
// above `/`.

export * from '../../dist/index.js';
export * from '../../dist/draw.js';
export * from '../../dist/edit.js';
export * from '../../dist/export.js';
export * from '../../dist/stages.js';
// Pauses and ends of work.
export { untilAborted, yieldThread } from '../../dist/worker/pause.js';
// Estimates of progress of runs and exports.
export { CLIP_STAGES, ClipWork, StageClock, type StagePlan, countStep } from '../../dist/session/progress.js';
