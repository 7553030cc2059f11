// What the package takes of mediabunny: demuxing and muxing; decoding and encoding are the browser's own.
export {
  ALL_FORMATS,
  BlobSource,
  BufferTarget,
  CanvasSource,
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

// What is wrong with a file is said by the error that the caller gets, not on the console; a frame that nobody closed
// still is.
Logging.level = LogLevel.Errors;
