// A module worker for what takes long beside sessions: PNG files, archives, large pictures; one for all.

import { doHere } from './here.js';
import { serveAside } from './serve.js';

const port = /** @type {Worker} */ (/** @type {unknown} */ (globalThis));
serveAside(port, doHere);
