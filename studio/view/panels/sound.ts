// Sound of the clip, and the button that mutes it.

import { byId } from '../dom.js';
import { soundInfo } from '../../model/library.js';
import { Sound } from '../../model/sound.js';
import { closeMedia } from '../clip-player.js';
import type { Page } from '../page.js';

const STORAGE_KEY = 'tracecut.muted';

export function soundPanel({ store }: Pick<Page, 'store'>) {
  store.set({ isMuted: readMuted() });
  const sound = new Sound(store, {
    hasSound: async (file) => (await soundInfo(file)) !== null,
    open: openAudio,
    // Browsers that cannot tell forbid what is not wanted.
    isUserActive: () => navigator.userActivation?.isActive ?? true,
  });
  const button = byId('mute');
  button.addEventListener('click', () => sound.toggle());
  store.watch(['hasSound'], ({ hasSound }) => (button.hidden = !hasSound));
  store.watch(['isMuted'], ({ isMuted }) => {
    const label = isMuted ? 'Unmute' : 'Mute';
    button.setAttribute('aria-label', label);
    button.title = label;
    button.querySelector('use')!.setAttribute('href', isMuted ? '#icon-muted' : '#icon-sound');
    storeMuted(isMuted);
  });
  // The page does not draw in the background.
  document.addEventListener('visibilitychange', () => document.hidden && sound.pause());
}

function openAudio(file: File) {
  const audio = new Audio(URL.createObjectURL(file));
  return Object.assign(audio, { close: () => closeMedia(audio) });
}

function readMuted(): boolean {
  try {
    return localStorage.getItem(STORAGE_KEY) !== null;
  } catch {
    return false;
  }
}

function storeMuted(isMuted: boolean) {
  try {
    if (isMuted) localStorage.setItem(STORAGE_KEY, '1');
    else localStorage.removeItem(STORAGE_KEY);
  } catch {
    // Without storage it is forgotten.
  }
}
