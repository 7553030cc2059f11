// Options of exports: size, video quality and sound.

import { fitSize, soundInfo } from '../../model/library.js';
import { byId, h } from '../dom.js';
import { MIN_SIDE_PX, computeDuration, exportSizes } from '../../model/export-size.js';
import { describeImages, describeSound, describeVideo } from '../../model/export-text.js';
import type { Subject } from '../../model/export.js';
import type { SoundInfo, SoundOptions, VideoQuality } from '../../model/library.js';

type SizedSource = Pick<Subject, 'masks' | 'source' | 'fps'>;

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
    const size = fitSize(source.source, this.side);
    if (areImages) return describeImages(size, source.masks.numFrames);
    return describeVideo(size, source, this.values.quality);
  }

  show() {
    this.onChange();
    byId('export-custom').hidden = this.size.value !== 'own';
    byId('export-with-sound').hidden = !this.sound;
    byId('export-sound-facts').textContent = describeSound(this.sound);
  }
}
