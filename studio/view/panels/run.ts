// Opening, starting and cancelling, by buttons and files; how far a run is.

import { TOUCH, byId, connectDialog } from '../dom.js';
import type { Keys } from '../keyboard.js';
import type { Page } from '../page.js';

export function runPanel({ app, store, keys }: Pick<Page, 'app' | 'store' | 'keys'>) {
  const buttons: [ids: string[], act: () => unknown][] = [
    [['sample', 'error-sample'], () => app.openSample()],
    [['again', 'pending-run'], () => app.again()],
    [['restore'], () => app.restore()],
    [['resume'], () => app.resume()],
    [['cancel'], () => app.cancel()],
  ];
  for (const [ids, act] of buttons) for (const id of ids) byId(id).addEventListener('click', act);
  keys.on('Escape', () => app.cancel());
  const isKept = () => store.state.before !== null;
  keys.on('Ctrl+z', () => app.restore(), isKept);
  store.watch(['before'], () => (byId('restore').hidden = !isKept()));
  store.watch(['phase'], ({ phase, job, live }) => {
    if (phase !== 'done' || !job?.lost) return;
    // It is said above the panel, which may be elsewhere.
    byId('restore').scrollIntoView({ block: 'nearest' });
    if (!live.includes(job.lost)) store.set({ live: `${live}. ${job.lost}` });
  });
  app.asks = connectQuestion();
  const open: Open = (files) => {
    const all = [...(files ?? [])];
    if (all.length > 0) app.openFiles(all);
  };
  connectPicker(open, keys);
  connectDrop(open);
  addEventListener('paste', (event) => open(event.clipboardData?.files));
}

/** Connects the dialog that asks whether to run again, without the corrections. */
function connectQuestion(): () => Promise<boolean> {
  const dialog = byId<HTMLDialogElement>('ask');
  connectDialog(dialog);
  return () => {
    dialog.returnValue = '';
    dialog.showModal();
    return new Promise((answer) => (dialog.onclose = () => answer(dialog.returnValue === 'yes')));
  };
}

type Open = (files: Iterable<File> | null | undefined) => void;

function connectPicker(open: Open, keys: Keys) {
  const pick = connectInput('file', open);
  for (const id of ['open', 'error-open']) byId(id).addEventListener('click', pick);
  keys.on('o', pick);
  // Computers ignore `capture` and show the files again.
  byId('camera-open').hidden = !TOUCH;
  byId('camera-open').addEventListener('click', connectInput('camera', open));
}

/**
 * @param id of a file input
 * @returns shows its files, or the camera
 */
function connectInput(id: string, open: Open): () => void {
  const input = byId<HTMLInputElement>(id);
  input.addEventListener('change', () => {
    const files = [...(input.files ?? [])];
    // The same file may be picked again.
    input.value = '';
    open(files);
  });
  return () => input.click();
}

function connectDrop(open: Open) {
  let depth = 0;
  const hover = (by: number) => {
    depth = Math.max(0, depth + by);
    document.body.classList.toggle('is-dropping', depth > 0);
  };
  addEventListener('dragenter', () => hover(1));
  addEventListener('dragleave', () => hover(-1));
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    hover(-depth);
    open(event.dataTransfer?.files);
  });
}
