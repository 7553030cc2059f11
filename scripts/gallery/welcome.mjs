// Makes what the page shows before anything is computed, in a browser, from a project of the gallery whose camera stands still:
// the scene without its objects, and two of these as they were cut out in one frame.

/** Where an object is whole, and how many pixels its box is wider than the mask. */
const MARGIN = 2;

/** Width of the scene, in pixels: it fades away. */
const SCENE = 64;

/** How good the pictures are, 0 to 1. */
const QUALITY = { scene: 0.4, object: 0.2 };

/** @param {{project: string, frame: number, objects: Record<string, number>}} clip as Base64; the labels of the objects by their names */
export async function makeWelcome({ project, frame, objects }) {
  const { openProject } = await import('/dist/edit.js');
  const { videoFrames } = await import('/dist/index.js');
  const { masks, files } = await openProject(Uint8Array.from(atob(project), (letter) => letter.charCodeAt(0)));
  const frames = [];
  for await (const one of videoFrames(new Blob(Object.values(files)))) frames.push(one.frame);
  const size = { width: masks.width, height: masks.height };
  const made = { 'scene.webp': await picture(scene(frames, masks), SCENE / size.width, QUALITY.scene) };
  const boxes = {};
  for (const [name, label] of Object.entries(objects)) {
    const { pixels, box } = cutOut(frames[frame], masks.labels(frame), label);
    made[`${name}.webp`] = await picture(pixels, 1, QUALITY.object);
    boxes[name] = box;
  }
  return { size, boxes, files: made };
}

/** The median over all frames of what is no object's, nor right beside one. */
function scene(frames, masks) {
  const { width, height } = masks;
  const labels = frames.map((_, t) => masks.labels(t));
  const picture = new ImageData(width, height);
  const isFree = (t, x, y) => {
    for (let v = Math.max(0, y - 3); v <= Math.min(height - 1, y + 3); v += 1)
      for (let u = Math.max(0, x - 3); u <= Math.min(width - 1, x + 3); u += 1)
        if (labels[t][v * width + u] > 0) return false;
    return true;
  };
  for (let p = 0; p < width * height; p += 1) {
    const free = frames.filter((_, t) => isFree(t, p % width, Math.floor(p / width)));
    for (let c = 0; c < 3; c += 1)
      picture.data[4 * p + c] = free.map(({ data }) => data[4 * p + c]).sort((a, b) => a - b)[free.length >> 1];
    picture.data[4 * p + 3] = 255;
  }
  return picture;
}

/** An object's largest connected part, on nothing, in its box. */
function cutOut(frame, labels, label) {
  const { width, height } = frame;
  const part = largest(labels, label, width);
  const [xs, ys] = [part.map((p) => p % width), part.map((p) => Math.floor(p / width))];
  const [left, top] = [Math.min(...xs) - MARGIN, Math.min(...ys) - MARGIN];
  const box = { left, top, width: Math.max(...xs) + MARGIN + 1 - left, height: Math.max(...ys) + MARGIN + 1 - top };
  const alone = new ImageData(width, height);
  for (const p of part) alone.data.set(frame.data.slice(4 * p, 4 * p + 4), 4 * p);
  const canvas = new OffscreenCanvas(box.width, box.height);
  canvas.getContext('2d').putImageData(alone, -left, -top);
  return { pixels: canvas.getContext('2d').getImageData(0, 0, box.width, box.height), box };
}

/** The pixels of the largest part of a label. */
function largest(labels, label, width) {
  const seen = new Uint8Array(labels.length);
  let best = [];
  for (let p = 0; p < labels.length; p += 1) {
    if (seen[p] || labels[p] !== label) continue;
    const part = [p];
    seen[p] = 1;
    for (const q of part)
      for (const next of [q - 1, q + 1, q - width, q + width])
        if (labels[next] === label && !seen[next] && Math.abs((next % width) - (q % width)) <= 1) {
          seen[next] = 1;
          part.push(next);
        }
    if (part.length > best.length) best = part;
  }
  return best;
}

/** A picture as WebP, in Base64. */
async function picture(pixels, scale, quality) {
  const whole = new OffscreenCanvas(pixels.width, pixels.height);
  whole.getContext('2d').putImageData(pixels, 0, 0);
  const canvas = new OffscreenCanvas(Math.round(scale * pixels.width), Math.round(scale * pixels.height));
  const context = canvas.getContext('2d');
  context.imageSmoothingQuality = 'high';
  context.drawImage(whole, 0, 0, canvas.width, canvas.height);
  const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: 'image/webp', quality })).arrayBuffer());
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
}
