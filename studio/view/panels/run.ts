// Buttons and files that open, start and cancel runs.

import { TOUCH, byId, connectDialog } from '../dom.js';
import type { Keys } from '../keyboard.js';
import type { Page } from '../page.js';

export function runPanel({ app, store, keys }: Pick<Page, 'app' | 'store' | 'keys'>) {
  const buttons: [ids: string[], act: () => unknown][] = [
    [['sample', 'error-sample'], () => app.openSample()],
    [['again'], () => app.rerun()],
    [['restore'], () => app.restore()],
    [['resume'], () => app.resume()],
    [['cancel'], () => app.cancel()],
  ];
  for (const [ids, act] of buttons) for (const id of ids) byId(id).addEventListener('click', act);
  keys.on('Escape', () => app.cancel());
  const hasPrevious = () => store.state.previousJob !== null;
  keys.on('Ctrl+z', () => app.restore(), hasPrevious);
  store.watch(['previousJob'], () => (byId('restore').hidden = !hasPrevious()));
  store.watch(['phase'], ({ phase, job, announcement }) => {
    if (phase !== 'done' || !job?.droppedCorrections) return;
    // The notice is at the top of the panel.
    byId('restore').scrollIntoView({ block: 'nearest' });
    if (!announcement.includes(job.droppedCorrections))
      store.set({ announcement: `${announcement}. ${job.droppedCorrections}` });
  });
  app.confirmRerun = connectQuestion();
  const open: Open = (files) => {
    const list = [...(files ?? [])];
    if (list.length > 0) app.openFiles(list);
  };
  connectPicker(open, keys);
  connectDrop(open);
  addEventListener('paste', (event) => open(event.clipboardData?.files));
}

/** Connects the dialog that confirms another run. */
function connectQuestion(): () => Promise<boolean> {
  const dialog = byId<HTMLDialogElement>('confirm');
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
  for (const id of ['open', 'error-open', 'welcome-open']) byId(id).addEventListener('click', pick);
  keys.on('o', pick);
  // Desktops ignore `capture` and show a file picker.
  byId('camera-open').hidden = !TOUCH;
  byId('camera-open').addEventListener('click', connectInput('camera', open));
}

/**
 * @param id of a file input
 * @returns opens its file picker or the camera
 */
function connectInput(id: string, open: Open): () => void {
  const input = byId<HTMLInputElement>(id);
  input.addEventListener('change', () => {
    const files = [...(input.files ?? [])];
    // Allows picking the same file again.
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
