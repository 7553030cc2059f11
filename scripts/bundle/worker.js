// The worker in one file: sessions, enlarging masks, and side tasks.

import { performTask, serveAside } from '../../dist/worker/aside-here.js';
import { serve } from '../../dist/worker/serve.js';

// Messages with a task are not for the session.
serve({
  addEventListener: (type, listen) => addEventListener(type, (event) => 'task' in event.data || listen(event)),
  postMessage: (...message) => postMessage(...message),
});
serveAside(globalThis, performTask);
