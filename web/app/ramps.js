// Colors for numbers: cividis (Nuñez et al. 2018), made for color blindness, and viridis (van der Walt and Smith 2015). The
// brightness of both rises evenly. Each is 17 samples, mixed in between.

/** @typedef {"cividis" | "viridis"} RampName */
const SAMPLES = {
  cividis: "00224e 002e6a 1a386f 32436d 434e6c 535a6d 61656f 6f7073 7d7c78 8b8778 9a9376 aaa073 bbad6d ccba64 ddc858 efd748 fee838",
  viridis: "440154 48186a 472d7b 424086 3b528b 33638d 2c728e 26828e 21918c 1f9f88 27ad81 3dbc74 5cc863 81d34d aadc32 d5e21a fde725",
};

/** 256 colors, three bytes each. @param {RampName} name */
export function ramp(name) {
  const stops = SAMPLES[name].split(" ").map((hex) => [0, 2, 4].map((at) => Number.parseInt(hex.slice(at, at + 2), 16)));
  const colors = new Uint8Array(256 * 3);
  for (let i = 0; i < 256; i += 1) {
    const along = (i / 255) * (stops.length - 1);
    const below = Math.min(stops.length - 2, Math.floor(along));
    for (let c = 0; c < 3; c += 1) colors[3 * i + c] = Math.round(stops[below][c] + (along - below) * (stops[below + 1][c] - stops[below][c]));
  }
  return colors;
}

/** The ramp for CSS. @param {RampName} name */
export const gradient = (name) => `linear-gradient(90deg, ${SAMPLES[name].split(" ").map((hex) => `#${hex}`).join(", ")})`;

/** @typedef {{ low: number, high: number, isLogarithmic: boolean }} Scale */

/** Where a number lies, from 0 to 1. @param {Scale} scale @param {number} value */
export function along({ low, high, isLogarithmic }, value) {
  const part = isLogarithmic ? Math.log(Math.max(value, low) / low) / Math.log(Math.max(high / low, 1.01)) : (value - low) / Math.max(high - low, 1e-9);
  return Math.min(1, Math.max(0, part));
}

/** The number at a place from 0 to 1. @param {Scale} scale @param {number} part */
export const at = ({ low, high, isLogarithmic }, part) => (isLogarithmic ? low * (Math.max(high / low, 1.01) ** part) : low + part * (high - low));

/**
 * The scale of a map: from the least to the most, or from the 2nd to the 98th of a hundred. A logarithmic one begins above 0.
 * @param {Float32Array} values @param {{ isLogarithmic: boolean, isClipped: boolean }} options @returns {Scale}
 */
export function scaleOf(values, { isLogarithmic, isClipped }) {
  const counted = values.filter((value) => Number.isFinite(value) && (!isLogarithmic || value > 0));
  if (counted.length === 0) return { low: isLogarithmic ? 1 : 0, high: 1, isLogarithmic };
  counted.sort();
  const of = (/** @type {number} */ share) => counted[Math.min(counted.length - 1, Math.floor(share * counted.length))];
  const [low, high] = isClipped ? [of(0.02), of(0.98)] : [counted[0], /** @type {number} */ (counted.at(-1))];
  // Of equal numbers, as of a map that is 0 but in few pixels, the clip leaves nothing.
  return high > low ? { low, high, isLogarithmic } : { low: counted[0], high: Math.max(/** @type {number} */ (counted.at(-1)), counted[0] + 1e-6), isLogarithmic };
}

/** Pixels of each of `bins` equal parts of a scale. @param {Float32Array} values @param {Scale} scale @param {number} bins */
export function histogram(values, scale, bins) {
  const counts = new Array(bins).fill(0);
  for (const value of values) if (Number.isFinite(value) && (!scale.isLogarithmic || value > 0)) counts[Math.min(bins - 1, Math.floor(along(scale, value) * bins))] += 1;
  return /** @type {number[]} */ (counts);
}

/**
 * Pixels in colors, four bytes each. Those without a number, and with `onlyPositive` those that are 0, let the picture through.
 * @param {Float32Array} values @param {Scale} scale @param {RampName} name @param {boolean} onlyPositive
 */
export function colored(values, scale, name, onlyPositive) {
  const colors = ramp(name);
  const pixels = new Uint8ClampedArray(values.length * 4);
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    if (!Number.isFinite(value) || (onlyPositive && value <= 0)) continue;
    const index = 3 * Math.round(255 * along(scale, value));
    pixels[4 * i] = colors[index];
    pixels[4 * i + 1] = colors[index + 1];
    pixels[4 * i + 2] = colors[index + 2];
    pixels[4 * i + 3] = 255;
  }
  return pixels;
}
