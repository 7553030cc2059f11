// How results are saved: their size, how fine videos are, whether they have the sound; and what that comes to.

import { estimateVideoSize, soundInfo } from '../../model/library.js';
import { byId, h } from '../dom.js';
import { fitSize } from '../../model/library.js';
import { LEAST_SIDE, durationOf, sizesOf } from '../../model/export-size.js';
import { bytes, plural } from '../../model/words.js';
import type { Subject } from '../../model/export.js';
import type { SoundInfo, SoundOptions, VideoQuality } from '../../model/library.js';

type Known = Pick<Subject, 'masks' | 'source' | 'fps'>;

const FORMATS = { webm: 'WebM', mp4: 'MP4' } as const;

/** The names of codecs as people know them. */
const CODECS: Record<string, string> = {
  aac: 'AAC',
  opus: 'Opus',
  mp3: 'MP3',
  vorbis: 'Vorbis',
  flac: 'FLAC',
  ac3: 'AC-3',
  eac3: 'E-AC-3',
};

export class ExportOptions {
  size = byId<HTMLSelectElement>('export-size');
  own = byId<HTMLInputElement>('export-side');
  quality = byId<HTMLSelectElement>('export-quality');
  withSound = byId<HTMLInputElement>('export-sound');
  known: Known | null = null;
  sizes: ReturnType<typeof sizesOf> = [];
  /** That of the source. */
  sound: SoundInfo | null = null;

  constructor() {
    for (const control of [this.size, this.own, this.quality, this.withSound])
      control.addEventListener('input', () => this.show());
  }

  /** What is to be saved; what was chosen for the same source stays. */
  async open(known: Known) {
    const isSame = known.source === this.known?.source;
    this.known = known;
    this.sizes = sizesOf(known.source, known.masks);
    const before = this.size.value;
    this.size.replaceChildren(...this.sizes.map(({ name, label }) => h('option', { value: name }, label)));
    this.size.value = isSame && this.sizes.some(({ name }) => name === before) ? before : this.sizes[0].name;
    if (!isSame) {
      this.sound = null;
      this.own.max = String(Math.max(known.source.width, known.source.height));
      this.own.value = String(Math.max(known.masks.width, known.masks.height));
    }
    this.show();
    if (isSame || !known.source.file) return;
    const found = await soundInfo(known.source.file).catch(() => null);
    if (this.known !== known) return;
    this.sound = found;
    this.show();
  }

  /** The longer side of what is saved, in pixels. */
  get side() {
    const chosen = this.sizes.find(({ name }) => name === this.size.value);
    if (chosen?.name !== 'own') return chosen?.side ?? 0;
    const typed = Math.round(Number(this.own.value));
    return Math.min(chosen.side, Math.max(LEAST_SIDE, Number.isFinite(typed) ? typed : LEAST_SIDE));
  }

  get chosen() {
    return { side: this.side, quality: this.quality.value as VideoQuality };
  }

  /** Returns what is kept of the sound; null for nothing. */
  soundFor(format: 'webm' | 'mp4'): SoundOptions | null {
    const { known, sound, withSound } = this;
    if (!known?.source.file || !known.masks.times || !withSound.checked || !sound?.formats.includes(format))
      return null;
    const start = known.masks.times[0];
    return { source: known.source.file, start, end: start + durationOf(known.masks, known.fps) };
  }

  show() {
    const { known } = this;
    byId('export-own').hidden = this.size.value !== 'own';
    byId('export-with-sound').hidden = !this.sound;
    byId('export-sound-facts').textContent = this.soundWords;
    if (!known) return;
    const { numFrames } = known.masks;
    const { width, height } = fitSize(known.source, this.side);
    const size = estimateVideoSize({ width, height, numFrames, quality: this.chosen.quality });
    const facts = [
      `${width} × ${height}`,
      plural(numFrames, 'frame'),
      `${durationOf(known.masks, known.fps).toFixed(1)}\u00a0s`,
      `a video takes roughly ${bytes(size)}`,
    ];
    byId('export-facts').textContent = `${facts.join(', ')}.`;
  }

  /** Returns which files can have the sound, in words. */
  get soundWords(): string {
    const { sound } = this;
    if (!sound) return '';
    const name = CODECS[sound.codec] ?? sound.codec;
    const without = Object.keys(FORMATS).filter((format) => !sound.formats.includes(format as 'mp4'));
    const names = (without.length > 0 ? without : sound.converted).map((format) => FORMATS[format as 'mp4']);
    if (names.length === 0) return `${name}, as it is.`;
    const said = names.length > 1 ? `${names[0]} and ${names[1]}` : String(names[0]);
    if (without.length === 0) return `${name}, as it is; in ${said} as Opus.`;
    return `${name}, as it is. ${said} cannot hold it: such files are silent.`;
  }
}
