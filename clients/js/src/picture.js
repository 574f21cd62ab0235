import { foreign, kindOf } from "./connection.js";
import { DamagedError } from "./problems.js";

/**
 * How far a picture may be from recursion without end, in codes: steps of an 8-bit channel.
 * @typedef {object} PictureError
 * @property {number | null} proved It is proved that no pixel is further off. Null: nothing is proved, and `why` says why.
 * @property {number | null} identical Share of the pixels that are proved to be identical.
 * @property {number | null} depth The depth of the recursion that it was compared with; null for recursion without end.
 * @property {number | null} estimated Estimated error of sampling.
 * @property {string | null} why
 */

/** A picture as the service sent it. */
export class Picture {
  /**
   * @param {Uint8Array<ArrayBuffer>} bytes
   * @param {Headers} headers
   */
  constructor(bytes, headers) {
    const timing = headers.get("server-timing") ?? "";
    /** The file. */
    this.bytes = bytes;
    this.mediaType = (headers.get("content-type") ?? "").split(";")[0] ?? "";
    /** @type {PictureError} */
    this.error = errorOf(headers.get("render-error") ?? "");
    /** Rays by kind. @type {Record<string, number>} */
    this.rays = Object.fromEntries([...members(headers.get("render-rays"))].map(([name, value]) => [name, Number(value)]));
    /** Milliseconds of each phase; empty if the picture existed already. @type {Record<string, number>} */
    this.timing = Object.fromEntries([...timing.matchAll(/([\w-]+);dur=([\d.]+)/g)].map(([, name, ms]) => [name, Number(ms)]));
    /** The effects that were simulated. */
    this.effects = (headers.get("render-plan") ?? "").split(/[,\s]+/).filter(Boolean);
    this.warnings = [...(headers.get("render-warnings") ?? "").matchAll(/"((?:[^"\\]|\\.)*)"/g)].map(([, text = ""]) => textIn(text));
    this.etag = headers.get("etag");
    /** Its id, by which `Client.image` gets it again. */
    this.imageId = headers.get("content-location")?.match(/\/v1\/images\/(i_\w+)/)?.[1] ?? null;
    /** Whether the service had it already. */
    this.cached = timing.includes("picture;desc=hit");
  }

  /** The file for a page: `URL.createObjectURL(picture.blob())`. */
  blob() {
    return new Blob([this.bytes], { type: this.mediaType });
  }

  /**
   * The linear light of a PFM, rows from the top. Other formats are for `createImageBitmap(picture.blob())`.
   * @returns {{ width: number, height: number, channels: number, data: Float32Array }}
   */
  floats() {
    const head = new TextDecoder("latin1").decode(this.bytes.subarray(0, 64)).match(/^(PF|Pf)\n(\d+) (\d+)\n(-?[\d.]+)\n/);
    if (!head) throw new TypeError(`${this.mediaType} has no linear light: ask for format: "pfm"`);
    const [all, kind, across, down, scale] = head;
    const [width, height, channels] = [Number(across), Number(down), kind === "PF" ? 3 : 1];
    const view = new DataView(this.bytes.buffer, this.bytes.byteOffset + all.length);
    const row = width * channels, data = new Float32Array(row * height);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < row; x++) data[(height - 1 - y) * row + x] = view.getFloat32(4 * (y * row + x), Number(scale) < 0);
    }
    return { width, height, channels, data };
  }
}

/**
 * The picture of an answer. What is none is refused, and a file that was damaged on its way, where the platform can tell.
 * @param {Response} answer
 */
export async function pictureOf(answer) {
  if (!kindOf(answer).startsWith("image/")) {
    await answer.body?.cancel();
    throw foreign(answer, "a picture");
  }
  const bytes = new Uint8Array(await answer.arrayBuffer());
  await checkDigest(bytes, answer.headers.get("repr-digest"));
  return new Picture(bytes, answer.headers);
}

/**
 * Refuses an empty file, and compares with a `Repr-Digest` (RFC 9530), if there is one.
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @param {string | null | undefined} header
 */
export async function checkDigest(bytes, header) {
  if (!bytes.length) throw new DamagedError("the picture is empty: check that the URL is that of the service");
  const wanted = header?.match(/sha-256=:([A-Za-z0-9+/=]+):/)?.[1];
  // Pages without TLS have no `subtle`.
  if (!wanted || !globalThis.crypto?.subtle) return;
  const digest = String.fromCharCode(...new Uint8Array(await crypto.subtle.digest("SHA-256", bytes)));
  if (btoa(digest) !== wanted) throw new DamagedError("the picture was damaged on its way: its SHA-256 is not that of Repr-Digest");
}

/**
 * @param {string} header
 * @returns {PictureError}
 */
function errorOf(header) {
  const known = members(header);
  const number = (/** @type {string} */ name) => {
    const value = Number.parseFloat(known.get(name) ?? "");
    return Number.isNaN(value) ? null : value;
  };
  return {
    proved: number("proved"), identical: number("identical"), depth: number("depth"), estimated: number("estimated"),
    why: known.get("why") ?? null,
  };
}

/**
 * Members of a dictionary (RFC 9651).
 * @param {string | null} header
 * @returns {Map<string, string>}
 */
function members(header) {
  const found = (header ?? "").matchAll(/([\w-]+)=(?:"((?:[^"\\]|\\.)*)"|([^,;\s]*))/g);
  return new Map([...found].map(([, name = "", text, value]) => [name, text === undefined ? value ?? "" : textIn(text)]));
}

/**
 * The text of what is inside the quotes of a string (RFC 9651): quotes and backslashes have a backslash before them.
 * @param {string} inside
 */
const textIn = (inside) => inside.replace(/\\(.)/g, "$1");
