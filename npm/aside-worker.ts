// A module worker for what takes long beside sessions: PNG files, archives, large pictures; one for all.

import { performTask, serveAside } from './worker/aside-here.js';

const port = globalThis as unknown as Worker;
serveAside(port, performTask);
