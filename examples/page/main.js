// Segments the chosen video, then plays it with each object in its own colour.

import { drawLabels, segmentVideo, videoFrames } from 'tracecut';

const SIZE = 480; // the long side of frames and masks, in pixels

const input = document.querySelector('input');
const status = document.querySelector('[role=status]');
const canvas = document.querySelector('canvas');
const context = canvas.getContext('2d');

input.addEventListener('change', async () => {
  const source = input.files.length > 1 ? [...input.files] : input.files[0];
  input.disabled = true;
  try {
    const masks = await segmentVideo(source, { size: SIZE, onProgress }).collect();
    status.textContent = `${masks.objects.length} objects in ${masks.numFrames} frames`;
    await play(source, masks);
  } catch (error) {
    status.textContent = error.message; // says what is wrong and what is allowed
  }
  input.disabled = false;
});

function onProgress({ stage, frames }) {
  status.textContent = `${stage}, ${frames.done} frames read`;
}

async function play(source, masks) {
  [canvas.width, canvas.height] = [masks.width, masks.height];
  for await (const { frame, index } of videoFrames(source, { size: SIZE })) {
    context.drawImage(frame, 0, 0);
    drawLabels(context, masks, index);
    await new Promise((resolve) => setTimeout(resolve, 40));
  }
}
