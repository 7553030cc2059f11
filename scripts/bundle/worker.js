// The worker in one file: sessions, masks enlarged, and what is done aside.

import { performTask, serveAside } from '../../dist/worker/aside-here.js';
import { serve } from '../../dist/worker/serve.js';

// What has a task is not the session's.
serve({
  addEventListener: (type, listen) => addEventListener(type, (event) => 'task' in event.data || listen(event)),
  postMessage: (...message) => postMessage(...message),
});
serveAside(globalThis, performTask);
