// Short texts of results, to compare two runs, Node and browsers, wasm and native code. Runs in Node and in pages.

/** Everything of a result that must not differ between two runs, as one text. */
export function fingerprint(result) {
  const { trajectories, clusters, embedding, objects, saliency, components } = result;
  const edges = Array.from({ length: result.numFrames }, (_, t) => Object.values(result.edges(t)).map((a) => [...a]));
  const lists = [
    trajectories.startFrame,
    trajectories.offset,
    trajectories.x,
    trajectories.y,
    clusters.label,
    embedding.eigenvalues,
    embedding.vectors,
    ...Object.values(saliency),
    ...Object.values(components),
  ];
  const masks = Array.from({ length: result.masks.length > 0 ? result.numFrames : 0 }, (_, t) =>
    fnv1a(result.labels(t)),
  );
  return JSON.stringify([
    clusters.count,
    lists.map((list) => [...list]),
    edges,
    Math.max(0, ...objects.map(({ label }) => label)),
    [...clusters.object],
    masks,
  ]);
}

/** FNV-1a of bytes, in eight hexadecimal digits: what the golden files hold of a mask. */
export function fnv1a(bytes) {
  let hash = 0x811c9dc5;
  for (const byte of bytes) hash = Math.imul(hash ^ byte, 0x01000193);
  return (hash >>> 0).toString(16).padStart(8, '0');
}
