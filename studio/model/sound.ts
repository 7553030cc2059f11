// Plays the sound of the clip in step with the frames on screen.

import type { State, Store } from './store.js';

/** An audio element of the browser, or as much of it. */
export interface SoundPlayer {
  currentTime: number;
  readonly paused: boolean;
  play: () => Promise<void>;
  pause: () => void;
}

interface SoundPlatform {
  hasSound: (file: File) => Promise<boolean>;
  open: (file: File) => SoundPlayer & { close: () => void };
  /** Returns whether the user has just pressed a button or key. */
  isUserActive: () => boolean;
}

/** Distance between sound and picture that is not heard, in seconds. */
const MAX_DRIFT_S = 0.15;

/** Distance at which the picture has jumped, in seconds. */
const JUMP_S = 0.5;

/** Shortest time between two corrections of the drift, in milliseconds, as seeking is heard. */
const CORRECTION_INTERVAL_MS = 1000;

export class Sound {
  player: ReturnType<SoundPlatform['open']> | null = null;
  isPlaying = false;
  /** False while the page plays by itself, after a run. */
  isWanted = false;
  correctedAt = -Infinity;

  constructor(
    readonly store: Store,
    readonly platform: SoundPlatform,
  ) {
    store.watch(['source'], ({ source }) => this.open(source));
    store.watch(['isPlaying', 'isMuted', 'hasSound', 'frame', 'timeline'], (state) => this.follow(state));
  }

  async open(source: State['source']) {
    this.player?.close();
    this.player = null;
    this.store.set({ hasSound: false });
    if (source?.kind !== 'video' || !source.file) return;
    const hasSound = await this.platform.hasSound(source.file).catch(() => false);
    if (source === this.store.state.source) this.store.set({ hasSound });
  }

  follow({ isPlaying, isMuted, hasSound, source, frame, timeline }: Readonly<State>) {
    if (isPlaying && !this.isPlaying) this.isWanted = this.platform.isUserActive();
    this.isPlaying = isPlaying;
    const time = timeline.times.seconds?.[frame];
    const isHeard = isPlaying && this.isWanted && hasSound && !isMuted;
    if (!isHeard || time === undefined || !source?.file) return this.player?.pause();
    this.player ??= this.platform.open(source.file);
    this.correct(this.player, time);
    if (this.player.paused) this.player.play().catch((error) => this.giveUp(error));
  }

  /** Seeks if sound and picture are apart. */
  correct(player: SoundPlayer, time: number) {
    const drift = Math.abs(player.currentTime - time);
    const now = performance.now();
    const isDue = player.paused || drift > JUMP_S || now - this.correctedAt > CORRECTION_INTERVAL_MS;
    if (drift <= MAX_DRIFT_S || !isDue) return;
    player.currentTime = time;
    this.correctedAt = now;
  }

  /** Offers no sound that the browser cannot decode. It may also forbid to play. */
  giveUp({ name }: { name?: unknown }) {
    if (name === 'NotSupportedError') this.store.set({ hasSound: false });
  }

  /** Pauses until the next frame is shown. */
  pause() {
    this.player?.pause();
  }

  toggle() {
    // The button is also an answer to silent playback.
    const isSilent = this.store.state.isPlaying && !this.isWanted;
    this.isWanted = true;
    this.store.set({ isMuted: !isSilent && !this.store.state.isMuted });
    this.follow(this.store.state);
  }
}
