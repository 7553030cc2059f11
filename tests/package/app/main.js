// The page of a project that has installed the package: what came out, for the test to read.

import { outcome, throughVideo } from './segment.js';

globalThis.outcome = Promise.all([outcome(), throughVideo()]);
