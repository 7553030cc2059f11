// Turns clicked objects of a clip into background, and saves the masks as a ZIP archive. The project needs no
// configuration: Vite finds the package's wasm files and its worker.

import { createSession, drawLabels, masksZip, synthClip } from 'tracecut';

const status = document.querySelector('[role=status]');
const canvas = document.querySelector('canvas');
const [undo, save] = document.querySelectorAll('button');
const context = canvas.getContext('2d');

const clip = await synthClip({ width: 480, height: 270, frames: 10, seed: 1 });
const session = await createSession();
for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));

/** The result on the canvas. */
let result;
show(await session.run());

canvas.addEventListener('click', async ({ offsetX, offsetY }) => {
  const [x, y] = [
    Math.floor((offsetX * canvas.width) / canvas.clientWidth),
    Math.floor((offsetY * canvas.height) / canvas.clientHeight),
  ];
  const label = result.labels(0)[y * result.width + x];
  if (label > 0) show(await session.merge(0, label));
});
undo.addEventListener('click', async () => show(await session.undo()));
save.addEventListener('click', async () => {
  const archive = new Blob([await masksZip(result)], { type: 'application/zip' });
  const link = Object.assign(document.createElement('a'), {
    href: URL.createObjectURL(archive),
    download: 'masks.zip',
  });
  link.click();
  URL.revokeObjectURL(link.href);
});

function show(next) {
  result = next;
  const { data, width, height } = clip.frame(0);
  Object.assign(canvas, { width, height });
  context.putImageData(new ImageData(data, width, height), 0, 0);
  drawLabels(context, result, 0);
  status.textContent = `${result.objects.length} objects`;
  undo.disabled = session.corrections === 0;
  save.disabled = false;
}
