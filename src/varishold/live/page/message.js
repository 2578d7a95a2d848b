/* A picture as the server sends it: the length of the head, the head, 32-bit floats. */
function pictureOf(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  const floats = new Float32Array(buffer, 4 + size);
  for (const pad of head.pads) {
    pad.frame = floats.subarray(pad.at, pad.at + pad.rows * pad.cols);
    for (const contact of pad.contacts) {
      const n = contact.levels, from = contact.curves;
      contact.heights = floats.subarray(from, from + n);
      contact.growths = [floats.subarray(from + n, from + 2 * n), floats.subarray(from + 2 * n, from + 3 * n)];
      contact.usable = Array.from(floats.subarray(from + 3 * n, from + 4 * n), value => value > 0);
      let at = contact.at;
      contact.sections = contact.outlines.map(counts => counts.map(count => {
        const points = floats.subarray(at, at + 2 * count);
        at += 2 * count;
        return points;
      }));
    }
  }
  return head;
}
