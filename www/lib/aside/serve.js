// The worker's side of what is done aside.

/**
 * Answers the tasks that arrive at `port`; what else arrives there is not for this.
 * @param {Pick<Worker, 'addEventListener' | 'postMessage'>} port
 * @param {(task: import('./here.js').AsideTask) => Promise<Uint8Array<ArrayBuffer>>} doTask
 */
export function serveAside(port, doTask) {
  port.addEventListener('message', async (event) => {
    const { id, task } = /** @type {MessageEvent} */ (event).data;
    if (!task) return;
    try {
      const bytes = await doTask(task);
      port.postMessage({ id, bytes }, [bytes.buffer]);
    } catch (error) {
      port.postMessage({ id, error: String(error) });
    }
  });
}
