// The parts of mediabunny that the package uses: demuxing and muxing; the browser decodes and encodes.
export {
  ALL_FORMATS,
  BlobSource,
  BufferTarget,
  EncodedAudioPacketSource,
  EncodedPacket,
  EncodedPacketSink,
  EncodedVideoPacketSource,
  HLS,
  Input,
  MP4,
  MPEG_TS,
  Mp4OutputFormat,
  Output,
  QTFF,
  Quality,
  UrlSource,
  VideoSample,
  VideoSampleSink,
  VideoSampleSource,
  WebMOutputFormat,
  getFirstEncodableVideoCodec,
} from 'mediabunny';

import { LogLevel, Logging } from 'mediabunny';

// Faults of files are reported by the caller's error, not on the console; unclosed frames still are.
Logging.level = LogLevel.Errors;
