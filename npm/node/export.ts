// `tracecut/export` in Node.

import './platform.js';

export * from '../export.js';
