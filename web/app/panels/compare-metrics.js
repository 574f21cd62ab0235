// How far two pictures are apart, in 8-bit codes. Pure, and in slices, so that large pictures do not hold up the page.

import { encoded } from "../values.js";

/** @typedef {{ max: number, p999: number, rms: number, identical: number, worst: { x: number, y: number } }} Metrics */

/** Pixels of a slice: some milliseconds. */
const SLICE = 400_000;

/**
 * Measures two pictures of one size, four bytes for each pixel. The error of a pixel is that of its worst channel.
 * Yields between slices. @param {Uint8ClampedArray} a @param {Uint8ClampedArray} b @param {number} width
 * @returns {Generator<void, Metrics>}
 */
export function* measure(a, b, width) {
  const counts = new Float64Array(256);
  const pixels = a.length / 4;
  let squares = 0;
  let worst = 0;
  let max = 0;
  for (let from = 0; from < pixels; from += SLICE) {
    const to = Math.min(pixels, from + SLICE);
    for (let i = from; i < to; i += 1) {
      const r = Math.abs(a[4 * i] - b[4 * i]);
      const g = Math.abs(a[4 * i + 1] - b[4 * i + 1]);
      const blue = Math.abs(a[4 * i + 2] - b[4 * i + 2]);
      const error = Math.max(r, g, blue);
      counts[error] += 1;
      squares += r * r + g * g + blue * blue;
      if (error > max) [max, worst] = [error, i];
    }
    yield;
  }
  let below = 0;
  const p999 = counts.findIndex((count) => (below += count) >= Math.ceil(0.999 * pixels));
  return { max, p999, rms: Math.sqrt(squares / (3 * pixels)), identical: counts[0] / pixels, worst: { x: worst % width, y: Math.floor(worst / width) } };
}

/**
 * The difference of each channel times a gain, as pixels. @param {Uint8ClampedArray} a @param {Uint8ClampedArray} b @param {number} gain
 */
export function difference(a, b, gain) {
  const pixels = new Uint8ClampedArray(a.length);
  for (let i = 0; i < a.length; i += 1) pixels[i] = i % 4 === 3 ? 255 : gain * Math.abs(a[i] - b[i]);
  return pixels;
}

/** 4,096 codes of linear light from 0 to 1: sRGB (IEC 61966-2-1). */
const CURVE = Uint8ClampedArray.from({ length: 4097 }, (_, i) => Math.floor(255 * encoded(i / 4096) + 0.5));

/** Linear light at an exposure, in stops, as pixels. @param {import("./pfm.js").Floats} floats @param {number} stops */
export function exposed({ values, channels }, stops) {
  const factor = 4096 * 2 ** stops;
  const pixels = new Uint8ClampedArray((values.length / channels) * 4).fill(255);
  for (let i = 0, at = 0; i < values.length; i += channels, at += 4)
    for (let c = 0; c < 3; c += 1) pixels[at + c] = CURVE[Math.max(0, Math.min(4096, Math.round(values[i + Math.min(c, channels - 1)] * factor)))];
  return pixels;
}
