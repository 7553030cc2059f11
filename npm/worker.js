// The module worker of a session; started by `createSession` in browsers.

import { serve } from './worker/serve.js';

serve(/** @type {import('./worker/protocol.js').Port} */ (/** @type {unknown} */ (globalThis)));
