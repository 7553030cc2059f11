// The names of the platform that the declarations mention. Where the project's libraries know one (the browser's, a
// worker's, Node's own), it is that; where they do not, it is what this package needs of it, so that nothing becomes
// `any`. The build puts an import of these before each declaration file that mentions them.

declare global {
  // Added to what the libraries say of them, or alone. As @types/node has them, in projects for older targets.
  interface SymbolConstructor {
    readonly dispose: unique symbol;
  }
  interface ReadableStream<R = any> {}
}

/** The type of what a global class of this name makes; `Otherwise` where there is no such class. */
type Global<Name extends string, Otherwise> = typeof globalThis extends { [N in Name]: { prototype: infer T } }
  ? T
  : Otherwise;

/** A file in memory, as far as it is read. */
interface BlobLike {
  readonly size: number;
  readonly type: string;
  arrayBuffer(): Promise<ArrayBuffer>;
  slice(start?: number, end?: number, type?: string): BlobLike;
}

/** A canvas of any make. */
interface CanvasLike {
  width: number;
  height: number;
  getContext(type: '2d'): object | null;
}

interface ImageDataLike {
  readonly data: Uint8ClampedArray;
  readonly width: number;
  readonly height: number;
}

interface ImageBitmapLike {
  readonly width: number;
  readonly height: number;
  close(): void;
}

interface ImageElementLike {
  readonly naturalWidth: number;
  readonly naturalHeight: number;
}

interface VideoElementLike {
  readonly videoWidth: number;
  readonly videoHeight: number;
  readonly currentSrc: string;
}

interface VideoFrameLike {
  readonly displayWidth: number;
  readonly displayHeight: number;
  readonly timestamp: number;
  copyTo(destination: Uint8Array, options?: object): Promise<unknown>;
  close(): void;
}

interface MediaStreamLike {
  readonly id: string;
  readonly active: boolean;
  getVideoTracks(): object[];
}

interface MediaStreamTrackLike {
  readonly kind: string;
  readonly readyState: string;
  getSettings(): object;
}

interface UrlLike {
  readonly href: string;
  readonly protocol: string;
  readonly origin: string;
  toString(): string;
}

interface ResponseLike {
  readonly ok: boolean;
  readonly status: number;
  arrayBuffer(): Promise<ArrayBuffer>;
}

interface AbortSignalLike {
  readonly aborted: boolean;
  readonly reason: unknown;
  throwIfAborted(): void;
  addEventListener(type: 'abort', listener: () => void): void;
  removeEventListener(type: 'abort', listener: () => void): void;
}

interface PortLike {
  postMessage(message: unknown, transfer?: readonly object[]): void;
  close(): void;
}

interface WorkerLike {
  postMessage(message: unknown, transfer?: readonly object[]): void;
  terminate(): unknown;
}

interface StreamLike<R> {
  getReader(): {
    read(): Promise<{ done: boolean; value?: R | undefined }>;
    cancel(reason?: unknown): Promise<unknown>;
    releaseLock(): void;
  };
}

/** What drawing needs of a context. */
interface ContextLike {
  fillStyle: unknown;
  strokeStyle: unknown;
  lineWidth: number;
  lineCap: string;
  globalAlpha: number;
  globalCompositeOperation: string;
  imageSmoothingEnabled: boolean;
  save(): void;
  restore(): void;
  translate(x: number, y: number): void;
  scale(x: number, y: number): void;
  setTransform(a: number, b: number, c: number, d: number, e: number, f: number): void;
  beginPath(): void;
  closePath(): void;
  moveTo(x: number, y: number): void;
  lineTo(x: number, y: number): void;
  rect(x: number, y: number, width: number, height: number): void;
  arc(x: number, y: number, radius: number, start: number, end: number): void;
  fill(): void;
  fillRect(x: number, y: number, width: number, height: number): void;
  stroke(): void;
  drawImage(image: never, x: number, y: number, width: number, height: number): void;
  createImageData(width: number, height: number): ImageDataLike;
  putImageData(image: never, x: number, y: number): void;
  getImageData(x: number, y: number, width: number, height: number): ImageDataLike;
}

export type AbortSignal = Global<'AbortSignal', AbortSignalLike>;
export type Blob = Global<'Blob', BlobLike>;
export type File = Global<'File', BlobLike & { readonly name: string }>;
export type HTMLCanvasElement = Global<'HTMLCanvasElement', CanvasLike>;
export type HTMLVideoElement = Global<'HTMLVideoElement', VideoElementLike>;
export type ImageBitmap = Global<'ImageBitmap', ImageBitmapLike>;
export type ImageData = Global<'ImageData', ImageDataLike>;
export type MediaStream = Global<'MediaStream', MediaStreamLike>;
export type MediaStreamTrack = Global<'MediaStreamTrack', MediaStreamTrackLike>;
export type MessagePort = Global<'MessagePort', PortLike>;
export type OffscreenCanvas = Global<'OffscreenCanvas', CanvasLike>;
export type Response = Global<'Response', ResponseLike>;
export type URL = Global<'URL', UrlLike>;
export type VideoFrame = Global<'VideoFrame', VideoFrameLike>;
export type Worker = Global<'Worker', WorkerLike>;

export type OffscreenCanvasRenderingContext2D = Global<'OffscreenCanvasRenderingContext2D', ContextLike>;
/** A worker has only the context of an `OffscreenCanvas`. */
export type CanvasRenderingContext2D = Global<'CanvasRenderingContext2D', OffscreenCanvasRenderingContext2D>;

export type CanvasImageSource =
  | Global<'HTMLImageElement', ImageElementLike>
  | Global<'SVGImageElement', never>
  | HTMLVideoElement
  | HTMLCanvasElement
  | ImageBitmap
  | OffscreenCanvas
  | VideoFrame;

export type ReadableStream<R> = globalThis.ReadableStream<R> & StreamLike<R>;
export type BufferSource = ArrayBufferView | ArrayBuffer;
export type RequestInfo = string | Global<'Request', { readonly url: string }>;
export type Transferable = ArrayBuffer | MessagePort | ImageBitmap | VideoFrame | OffscreenCanvas;
export interface MessageEvent<T> {
  readonly data: T;
}

interface WasmModuleLike {
  readonly [Symbol.toStringTag]: 'WebAssembly.Module';
}

interface WasmTableLike {
  readonly length: number;
}

interface WasmMemoryLike {
  readonly buffer: ArrayBuffer;
  grow(pages: number): number;
}

export declare namespace WebAssembly {
  // The browser's declaration of a module has no members, so that a number would do.
  type Module = object &
    (typeof globalThis extends { WebAssembly: { Module: { prototype: infer T } } } ? T : WasmModuleLike);
  type Table = typeof globalThis extends { WebAssembly: { Table: { prototype: infer T } } } ? T : WasmTableLike;
  type Memory = typeof globalThis extends { WebAssembly: { Memory: { prototype: infer T } } } ? T : WasmMemoryLike;
}
