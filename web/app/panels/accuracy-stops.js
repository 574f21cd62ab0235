// The stops of the dial, from quick to exact: what each asks the service for, and what it writes into the scene. Pure.

/** @typedef {import("../state.js").Settings} Settings */
/** @typedef {"" | "single" | "double"} Precision */
/**
 * @typedef {object} Stop
 * @property {string} id
 * @property {string} label
 * @property {string} [short] the same within its group
 * @property {string} group
 * @property {Settings} settings
 * @property {string} words what it gives
 * @property {number} rank the higher, the closer to recursion without end; 0: it cannot be held against others
 * @property {number} [budget] milliseconds that it may take
 */

const proved = (/** @type {number} */ codes) => (codes === 0 ? "Each pixel is proved to be that of recursion without end." : `No pixel is proved to be off by more than ${codes === 1 ? "one code" : "two codes"} of 255.`);
/** @type {Stop[]} */
export const STOPS = [
  ...[33, 100, 300].map((ms, i) => ({ id: `time-${ms}`, label: `${ms} ms`, group: "Time", settings: { accuracy: `time:${ms}` }, words: `The best picture within ${ms} ms, from the scene's bytes to the file's.`, rank: [1, 3, 5][i], budget: ms })),
  ...[2, 3, 5, 100].map((depth, i) => ({ id: `depth-${depth}`, label: `depth ${depth}`, short: String(depth), group: "Depth", settings: { accuracy: "fixed", max_depth: String(depth) }, words: `Chains of rays end after ${depth}, whatever they would have brought.`, rank: [2, 4, 6, 7][i] })),
  ...[2, 1, 0].map((codes, i) => ({ id: `proved-${codes}`, label: `proved ${codes}`, short: codes === 0 ? "exact" : `${codes} code${codes === 1 ? "" : "s"}`, group: "Proved", settings: { accuracy: `proved:${codes}` }, words: proved(codes), rank: 8 + i })),
  { id: "proved-0-double", label: "proved 0, double", short: "exact, double", group: "Proved", settings: { accuracy: "proved:0", precision: "double" }, words: "As exact as it gets: also where rays meet surfaces, in double precision.", rank: 11 },
  { id: "statistical-2", label: "statistical 2", short: "± 2 codes", group: "Samples", settings: { accuracy: "statistical:2" }, words: "Samples until 19 of 20 pixels are probably within two codes of endless sampling.", rank: 0 },
];

/** The parameters of a stop over those of the picture. @param {Stop} stop @param {Settings} base @param {Precision} precision @returns {Settings} */
export function settingsOf(stop, base, precision) {
  const { accuracy: _, max_depth: __, min_weight: ___, ...rest } = base;
  return { ...rest, ...(precision ? { precision } : {}), ...stop.settings };
}

/** Parameters as JSON has them: numbers and truth, not words. @param {Settings} settings @returns {Record<string, string | number | boolean>} */
export function typed(settings) {
  const value = (/** @type {string} */ name, /** @type {string} */ word) => (word === "true" ? true : word === "false" ? false : name !== "bits" && word !== "" && Number.isFinite(Number(word)) ? Number(word) : word);
  return Object.fromEntries(Object.entries(settings).map(([name, word]) => [name, value(name, word)]));
}

/** `render.accuracy` for a word of the query. @param {string} word */
export function accuracyOf(word) {
  const [kind, value = ""] = word.split(":");
  const [first, confidence] = value.split(",").map(Number);
  switch (kind) {
    case "proved":
      return { proved: { max_codes: value === "" ? 1 : first } };
    case "time":
      return { time: { ms: first } };
    case "rays":
      return { rays: { count: first } };
    case "statistical":
      return { statistical: confidence === undefined ? { half_width: first } : { half_width: first, confidence } };
    default:
      return { fixed: {} };
  }
}

/**
 * What is to be written into a scene so that it gives a picture with these parameters. Null removes.
 * @param {Settings} settings @returns {[string, any][]} pointers and values
 */
export function edits({ accuracy, max_depth, min_weight, samples, antialias, precision }) {
  const isFixed = accuracy === "fixed";
  /** @type {[string, any][]} */
  const all = [];
  if (accuracy !== undefined) all.push(["/render/accuracy", accuracyOf(accuracy)]);
  if (max_depth !== undefined) all.push(["/render/max_depth", Number(max_depth)]);
  // A weight belongs to the mode fixed alone.
  if (min_weight !== undefined && isFixed) all.push(["/render/min_weight", Number(min_weight)]);
  if (samples !== undefined) all.push(["/render/samples", Number(samples)]);
  if (antialias !== undefined) all.push(["/render/antialias", antialias === "true"]);
  if (precision !== undefined) all.push(["/render/precision", precision]);
  return all;
}

/** The finest of some stops, or null. @param {Iterable<string>} ids */
export function finest(ids) {
  const seen = new Set(ids);
  const ranked = STOPS.filter(({ id, rank }) => rank > 0 && seen.has(id)).sort((a, b) => b.rank - a.rank);
  return ranked[0] ?? null;
}
