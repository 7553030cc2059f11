// Options of exports: size, video quality and sound.

import { estimateVideoSize, soundInfo } from '../../model/library.js';
import { byId, h } from '../dom.js';
import { fitSize } from '../../model/library.js';
import { MIN_SIDE_PX, computeDuration, exportSizes } from '../../model/export-size.js';
import { formatBytes, formatPlural } from '../../model/messages.js';
import type { Subject } from '../../model/export.js';
import type { SoundInfo, SoundOptions, VideoQuality } from '../../model/library.js';

type SizedSource = Pick<Subject, 'masks' | 'source' | 'fps'>;

const FORMATS = { webm: 'WebM', mp4: 'MP4' } as const;

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
  customSide = byId<HTMLInputElement>('export-side');
  quality = byId<HTMLSelectElement>('export-quality');
  withSound = byId<HTMLInputElement>('export-sound');
  source: SizedSource | null = null;
  sizes: ReturnType<typeof exportSizes> = [];
  onChange = () => {};
  /** Soundtrack of the source. */
  sound: SoundInfo | null = null;

  constructor() {
    for (const control of [this.size, this.customSide, this.quality, this.withSound])
      control.addEventListener('input', () => this.show());
  }

  /** Shows the options of a source; keeps the chosen ones if it is the same. */
  async open(source: SizedSource) {
    const isSame = source.source === this.source?.source;
    this.source = source;
    this.sizes = exportSizes(source.source, source.masks);
    const before = this.size.value;
    this.size.replaceChildren(...this.sizes.map(({ name, label }) => h('option', { value: name }, label)));
    this.size.value = isSame && this.sizes.some(({ name }) => name === before) ? before : this.sizes[0].name;
    if (!isSame) {
      this.sound = null;
      this.customSide.max = String(Math.max(source.source.width, source.source.height));
      this.customSide.value = String(Math.max(source.masks.width, source.masks.height));
    }
    this.show();
    if (isSame || !source.source.file) return;
    const sound = await soundInfo(source.source.file).catch(() => null);
    if (this.source !== source) return;
    this.sound = sound;
    this.show();
  }

  /** Long side of the export, in pixels. */
  get side() {
    const preset = this.sizes.find(({ name }) => name === this.size.value);
    if (preset?.name !== 'own') return preset?.side ?? 0;
    const typed = Math.round(Number(this.customSide.value));
    return Math.min(preset.side, Math.max(MIN_SIDE_PX, Number.isFinite(typed) ? typed : MIN_SIDE_PX));
  }

  get values() {
    return { side: this.side, quality: this.quality.value as VideoQuality };
  }

  /** Returns the options of the soundtrack; null for none. */
  soundFor(format: SoundInfo['formats'][number]): SoundOptions | null {
    const { source, sound, withSound } = this;
    if (!source?.source.file || !source.masks.times || !withSound.checked || !sound?.formats.includes(format))
      return null;
    const start = source.masks.times[0];
    return { source: source.source.file, start, end: start + computeDuration(source.masks, source.fps) };
  }

  /** Describes the size and the length of what is saved; of videos its bytes too. */
  describe(areImages: boolean): string {
    const { source } = this;
    if (!source) return '';
    const { numFrames } = source.masks;
    const { width, height } = fitSize(source.source, this.side);
    if (areImages) return `${width} × ${height}, ${formatPlural(numFrames, 'frame')}`;
    const size = estimateVideoSize({ width, height, numFrames, quality: this.values.quality });
    const seconds = `${computeDuration(source.masks, source.fps).toFixed(1)}\u00a0s`;
    return `${width} × ${height}, ${seconds}, about ${formatBytes(size)}`;
  }

  show() {
    this.onChange();
    byId('export-custom').hidden = this.size.value !== 'own';
    byId('export-with-sound').hidden = !this.sound;
    byId('export-sound-facts').textContent = this.soundText;
  }

  /** Describes the formats that can hold the sound. */
  get soundText(): string {
    const { sound } = this;
    if (!sound) return '';
    const name = CODECS[sound.codec] ?? sound.codec;
    const without = Object.keys(FORMATS).filter((format) => !sound.formats.includes(format as 'mp4'));
    const names = (without.length > 0 ? without : sound.converted).map((format) => FORMATS[format as 'mp4']);
    if (names.length === 0) return `${name}, unchanged.`;
    const formats = names.length > 1 ? `${names[0]} and ${names[1]}` : String(names[0]);
    if (without.length === 0) return `${name}, unchanged; Opus in ${formats}.`;
    return `${name}, unchanged; no sound in ${formats}.`;
  }
}
