// `tracecut/edit` in Node.

import './platform.js';

export * from '../edit.js';
