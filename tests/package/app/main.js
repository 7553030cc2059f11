import { outcome, throughVideo } from './segment.js';

globalThis.outcome = Promise.all([outcome(), throughVideo()]);
