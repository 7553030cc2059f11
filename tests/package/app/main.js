import { outcome } from './segment.js';

globalThis.outcome = outcome();
