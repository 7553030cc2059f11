// The parts of mediabunny that the package uses: demuxing and muxing; the browser decodes and encodes. They come from its
// modules, in the order of its entry: the entry itself complains on the console if the page has a mediabunny of its own.
import { LogLevel, Logging } from '../../node_modules/mediabunny/dist/modules/src/logging.js';

export { Output } from '../../node_modules/mediabunny/dist/modules/src/output.js';
export { Mp4OutputFormat, WebMOutputFormat } from '../../node_modules/mediabunny/dist/modules/src/output-format.js';
export {
  EncodedAudioPacketSource,
  EncodedVideoPacketSource,
  VideoSampleSource,
} from '../../node_modules/mediabunny/dist/modules/src/media-source.js';
export { Quality, getFirstEncodableVideoCodec } from '../../node_modules/mediabunny/dist/modules/src/encode.js';
export { BufferTarget } from '../../node_modules/mediabunny/dist/modules/src/target.js';
export { BlobSource, UrlSource } from '../../node_modules/mediabunny/dist/modules/src/source.js';
export { ALL_FORMATS, HLS, MP4, MPEG_TS, QTFF } from '../../node_modules/mediabunny/dist/modules/src/input-format.js';
export { Input } from '../../node_modules/mediabunny/dist/modules/src/input.js';
export { EncodedPacket } from '../../node_modules/mediabunny/dist/modules/src/packet.js';
export { VideoSample } from '../../node_modules/mediabunny/dist/modules/src/sample.js';
export { EncodedPacketSink, VideoSampleSink } from '../../node_modules/mediabunny/dist/modules/src/media-sink.js';

// Faults of files are reported by the caller's error, not on the console; unclosed frames still are.
Logging.level = LogLevel.Errors;
