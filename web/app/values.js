// Numbers and colors as text. No effects.

/** A number some steps of its last digit but one further on. @param {string} text @param {number} steps */
export function scrubbed(text, steps) {
  const value = Number(text);
  if (!Number.isFinite(value)) return text;
  const decimals = /e/i.test(text) ? 6 : (text.split(".")[1]?.length ?? 0);
  // A whole number below 10 may want decimals (a radius of 1); one of 540 does not.
  const isWhole = decimals === 0;
  const digits = isWhole ? (Math.abs(value) < 10 ? 1 : 0) : Math.min(8, decimals);
  const step = isWhole && Math.abs(value) >= 10 ? Math.max(1, 10 ** (Math.floor(Math.log10(Math.abs(value))) - 2)) : 10 ** -digits;
  const next = value + steps * step;
  return steps === 0 ? text : String(Number(next.toFixed(digits)) || 0);
}

/** A linear value from 0 to 1 as sRGB (IEC 61966-2-1). @param {number} linear */
export const encoded = (linear) => (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055);
/** @param {number} code */
const decoded = (code) => (code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4);

/** A color of a scene as #rrggbb; brighter than white is white. @param {any} value @returns {string | null} */
export function toHex(value) {
  if (typeof value === "string") return /^#[0-9a-f]{6}$/i.test(value) ? value.toLowerCase() : null;
  const channels = typeof value === "number" ? [value, value, value] : value;
  if (!Array.isArray(channels) || channels.length !== 3 || !channels.every((of) => typeof of === "number" && of >= 0)) return null;
  return `#${channels.map((of) => Math.round(encoded(Math.min(1, of)) * 255).toString(16).padStart(2, "0")).join("")}`;
}

/** Linear channels with three digits. @param {string} hex */
export const fromHex = (hex) => [1, 3, 5].map((at) => Number(decoded(parseInt(hex.slice(at, at + 2), 16) / 255).toFixed(3)));
