// The page of a project that has installed the package: computes the results that the test reads.

import { outcome, throughVideo } from './segment.js';

globalThis.outcome = Promise.all([outcome(), throughVideo()]);
