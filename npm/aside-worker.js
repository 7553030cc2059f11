// A module worker for what takes long beside sessions: PNG files, archives, large pictures; one for all.

import { doHere, serveAside } from './worker/aside-here.js';

const port = /** @type {Worker} */ (/** @type {unknown} */ (globalThis));
serveAside(port, doHere);
