// `tracecut/stages` in Node.

import './platform.js';

export * from '../stages.js';
