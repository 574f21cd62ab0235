import { isObject } from "./connection.js";
import { Picture, checkDigest } from "./picture.js";
import { DamagedError, Problem } from "./problems.js";

const MOST_HEAD = 4_096;

/**
 * A picture on its way. Each of its pixels stands for `scale` x `scale` of those of `region`.
 * @typedef {object} Pass
 * @property {Picture} picture
 * @property {number} scale
 * @property {[x: number, y: number, width: number, height: number] | null} region null for the picture itself
 * @property {boolean} final Whether this is the picture itself, to the bytes of `Client.render`.
 * @property {number | null} etaMs Milliseconds until the end, estimated.
 * @property {import("../types/contract.js").components["schemas"]["CostReport"] | null} report of the picture itself
 */

/**
 * The pictures in an answer of `multipart/mixed` (RFC 2046), until the last one; it may be torn before.
 * @param {AsyncIterable<Uint8Array> | Iterable<Uint8Array>} answer
 * @returns {AsyncGenerator<Pass, void>}
 */
export async function* passes(answer) {
  /** @type {any} */
  let head = {};
  /** @type {{ bytes: Uint8Array<ArrayBuffer>, type: string } | undefined} */
  let file;
  for await (const { bytes, type } of partsOf(answer)) {
    if (type !== "application/json") {
      file = { bytes, type };
      if (!head.final) yield passOf(head, file, null);
      continue;
    }
    const about = read(bytes);
    if (about.problem) throw new Problem(about.problem.status ?? 500, about.problem);
    if (!("report" in about)) {
      head = about;
      continue;
    }
    if (!file) throw new DamagedError("the picture is missing in its answer");
    await checkDigest(file.bytes, head.repr_digest);
    yield passOf(head, file, about.report);
    return;
  }
}

/**
 * @param {any} head
 * @param {{ bytes: Uint8Array<ArrayBuffer>, type: string }} file
 * @param {import("../types/contract.js").components["schemas"]["CostReport"] | null} report
 * @returns {Pass}
 */
function passOf(head, { bytes, type }, report) {
  const picture = new Picture(bytes, new Headers({ "content-type": type }));
  picture.imageId = head.image_id ?? null;
  if (report) {
    const { proved, estimated } = report.error, why = proved.max_codes === undefined ? proved.why : null;
    picture.error = {
      proved: proved.max_codes ?? null, identical: proved.identical_fraction ?? null, depth: proved.max_depth,
      estimated: estimated?.half_width_codes ?? null, why,
    };
    picture.rays = { ...report.cost.rays };
    picture.timing = { ...report.cost.phases_ms };
    picture.effects = report.plan.effects.filter(({ state }) => state === "on").map(({ effect }) => effect);
    // In the words of Render-Warnings.
    picture.warnings = report.plan.warnings.map(({ pointer, detail }) => (pointer ? `${pointer}: ${detail}` : detail));
  }
  const { x, y, w, h, scale, final, eta_ms: etaMs } = head;
  return { picture, scale, region: x === undefined ? null : [x, y, w, h], final, etaMs: etaMs ?? null, report };
}

/** @param {AsyncIterable<Uint8Array> | Iterable<Uint8Array>} answer */
async function* partsOf(answer) {
  // What has come, and how much it takes for the part to be whole: a large picture is put together once.
  /** @type {Uint8Array[]} */
  let chunks = [];
  let size = 0, needed = 0;
  for await (const chunk of answer) {
    chunks.push(chunk);
    size += chunk.length;
    if (size < needed) continue;
    let rest = joined(chunks, size);
    for (needed = 0; ; ) {
      const head = new TextDecoder("latin1").decode(rest.subarray(0, MOST_HEAD)), end = head.indexOf("\r\n\r\n");
      if (end < 0) {
        if (rest.length > MOST_HEAD) throw new DamagedError("a part of the picture does not begin");
        break;
      }
      const field = (/** @type {string} */ name) => head.slice(0, end).match(new RegExp(`^${name}: (.*)$`, "mi"))?.[1]?.trim();
      const length = Number(field("content-length") ?? Number.NaN), start = end + 4;
      if (!(length >= 0)) throw new DamagedError("a part of the picture does not say how long it is");
      if (rest.length < start + length + 2) {
        needed = start + length + 2;
        break;
      }
      yield { type: field("content-type") ?? "", bytes: rest.slice(start, start + length) };
      rest = rest.subarray(start + length + 2);
    }
    chunks = [rest];
    size = rest.length;
  }
}

/**
 * @param {Uint8Array[]} chunks
 * @param {number} size
 */
function joined(chunks, size) {
  const all = new Uint8Array(size);
  let at = 0;
  for (const chunk of chunks) {
    all.set(chunk, at);
    at += chunk.length;
  }
  return all;
}

/** @param {Uint8Array} bytes */
function read(bytes) {
  let about;
  try {
    about = JSON.parse(new TextDecoder().decode(bytes));
  } catch (cause) {
    throw new DamagedError("a part of the picture is not JSON", { cause });
  }
  if (!isObject(about)) throw new DamagedError("a part of the picture is no object");
  return about;
}
