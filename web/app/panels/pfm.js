// Portable float maps: the numbers behind pictures and maps. `PF` has three channels, `Pf` one; rows go from the bottom up.

/** @typedef {{ width: number, height: number, channels: 1 | 3, values: Float32Array }} Floats rows from the top down */

/** @param {ArrayBuffer} buffer @returns {Floats} */
export function readPfm(buffer) {
  const bytes = new Uint8Array(buffer);
  let at = 0;
  const word = () => {
    const from = at;
    while (at < bytes.length && bytes[at] > 32) at += 1;
    const text = String.fromCharCode(...bytes.subarray(from, Math.min(at, from + 32)));
    at += 1;
    return text;
  };
  const [kind, width, height, scale] = [word(), Number(word()), Number(word()), Number(word())];
  const channels = kind === "PF" ? 3 : kind === "Pf" ? 1 : 0;
  const row = width * channels;
  const isSound = channels > 0 && Number.isInteger(width) && Number.isInteger(height) && width > 0 && height > 0 && scale !== 0;
  if (!isSound || buffer.byteLength - at < row * height * 4) throw new Error("the service's answer is not a whole PFM");
  const data = new DataView(buffer, at);
  const values = new Float32Array(row * height);
  for (let y = 0; y < height; y += 1) {
    const from = (height - 1 - y) * row;
    for (let x = 0; x < row; x += 1) values[y * row + x] = data.getFloat32((from + x) * 4, scale < 0);
  }
  return { width, height, channels: /** @type {1 | 3} */ (channels), values };
}
