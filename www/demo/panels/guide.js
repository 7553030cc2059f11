/** The first steps in three sentences, on the first visit; afterwards from the help. @module */

import { byId } from '../dom.js';

/** Under which it is kept that they were read. */
const KEY = 'tracecut-guide';

export function guidePanel() {
  const guide = byId('guide');
  guide.hidden = wasRead();
  byId('guide-close').addEventListener('click', () => {
    guide.hidden = true;
    keepRead();
    byId('help-open').focus();
  });
  byId('guide-open').addEventListener('click', () => {
    /** @type {HTMLDialogElement} */ (byId('help')).close();
    guide.hidden = false;
    byId('guide-close').focus();
  });
}

/** A browser may refuse to keep anything: then they are shown each time. */
function wasRead() {
  try {
    return localStorage.getItem(KEY) !== null;
  } catch {
    return false;
  }
}

function keepRead() {
  try {
    localStorage.setItem(KEY, 'read');
  } catch {
    // Shown again next time.
  }
}
