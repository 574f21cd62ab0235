// What the headers of a picture say: what it cost, how accurate it is, what it is called.

/** @typedef {ReturnType<typeof reportOf>} Report */

/** @param {Headers} headers */
export function reportOf(headers) {
  const get = (/** @type {string} */ name) => headers.get(name) ?? "";
  const phases = get("server-timing").split(",").flatMap((part) => {
    const found = /^\s*(\w+);dur=([\d.]+)/.exec(part);
    return found ? [{ name: found[1], ms: Number(found[2]) }] : [];
  });
  const rays = get("render-rays").split(",").flatMap((part) => {
    const [name, count] = part.trim().split("=");
    return count === undefined ? [] : [{ name, rays: Number(count) }];
  });
  const error = get("render-error");
  const number = (/** @type {string} */ name) => {
    const found = new RegExp(`(?:^|[ ,])${name}=([\\d.]+)`).exec(error);
    return found ? Number(found[1]) : null;
  };
  return {
    phases,
    // The time of `refine` is a part of that of `trace`.
    ms: phases.reduce((sum, { name, ms }) => (name === "refine" ? sum : sum + ms), 0),
    rays,
    totalRays: rays.reduce((sum, of) => sum + of.rays, 0),
    // Codes that no pixel is farther off than, and the share of the pixels that are exact.
    proved: number("proved"),
    identical: number("identical"),
    why: /why="([^"]*)"/.exec(error)?.[1] ?? "",
    estimated: number("estimated"),
    plan: get("render-plan").split(",").map((name) => name.trim()).filter((name) => name !== ""),
    digest: hex(/sha-256=:([^:]+):/.exec(get("repr-digest"))?.[1] ?? ""),
    location: get("content-location"),
    hit: get("server-timing").includes("picture;desc=hit"),
  };
}

/** @param {string} base64 */
const hex = (base64) => Array.from(atob(base64), (char) => char.charCodeAt(0).toString(16).padStart(2, "0")).join("");

/** Milliseconds for people: 0.4 ms, 44 ms, 1.3 s, 2 min 5 s. @param {number} ms */
export function duration(ms) {
  if (ms < 9.95) return `${ms.toFixed(1)} ms`;
  if (ms < 999.5) return `${Math.round(ms)} ms`;
  if (ms < 59_950) return `${(ms / 1000).toFixed(ms < 9950 ? 1 : 0)} s`;
  const minutes = Math.floor(ms / 60_000);
  return minutes < 60 ? `${minutes} min ${Math.round((ms % 60_000) / 1000)} s` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** A count for people: 812, 13.4 k, 2.1 M. @param {number} value */
export function count(value) {
  for (const [size, letter] of /** @type {[number, string][]} */ ([[1e12, "T"], [1e9, "G"], [1e6, "M"], [1e4, "k"]])) {
    if (value >= size) {
      const shown = value / (letter === "k" ? 1e3 : size);
      return `${shown.toFixed(shown < 9.95 ? 1 : 0)} ${letter}`;
    }
  }
  return String(Math.round(value));
}
