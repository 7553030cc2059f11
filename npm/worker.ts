// The module worker of a session; started by `createSession` in browsers.

import { serve } from './worker/serve.js';
import type { Port } from './worker/protocol.js';

serve(globalThis as Port);
