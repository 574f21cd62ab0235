// Links: what is seen as the fragment of an address, and the same request as a command line. No effects.
// A fragment is not sent to any server, so a scene in a link reaches no log.

/** Characters of a scene that fit into a link. */
export const LONGEST_LINK = 8_000;
/** Characters that a link may unpack to: it comes from strangers. */
export const LONGEST_TEXT = 1 << 20;

/** @param {Uint8Array} bytes */
const base64 = (bytes) => btoa(Array.from(bytes, (of) => String.fromCharCode(of)).join("")).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
/** @param {string} text */
const bytesOf = (text) => Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (of) => of.charCodeAt(0));

/** @param {string} text @returns {Promise<string>} */
export async function packed(text) {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  return base64(new Uint8Array(await new Response(stream).arrayBuffer()));
}

/** @param {string} word @returns {Promise<string>} */
export async function unpacked(word) {
  const stream = new Blob([bytesOf(word)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const parts = [];
  let length = 0;
  for (const reader = stream.getReader(); ; ) {
    const { value, done } = await reader.read();
    if (done) break;
    length += value.length;
    if (length > LONGEST_TEXT) {
      await reader.cancel();
      throw new Error("the scene in this link is larger than 1 MB");
    }
    parts.push(value);
  }
  return new TextDecoder().decode(await new Blob(parts).arrayBuffer());
}

/** @typedef {{ kept?: string, packed?: string, scene?: string, example?: string, type?: string, settings?: Record<string, string>, panel?: string, pixel?: { x: number, y: number }, frame?: { x: number, y: number, scale: number } }} Seen */

/** @param {Seen} seen */
export function fragment({ kept, packed: z, scene, example, type, settings = {}, panel, pixel, frame }) {
  const words = [];
  if (z) words.push(`z=${z}`);
  if (kept) words.push(`k=${kept}`);
  if (scene) words.push(`s=${scene}`);
  if (example) words.push(`e=${example}`);
  if (type && type !== "application/json") words.push(`t=${encodeURIComponent(type)}`);
  for (const [name, value] of Object.entries(settings)) words.push(`q.${encodeURIComponent(name)}=${encodeURIComponent(value)}`);
  if (panel) words.push(`p=${encodeURIComponent(panel)}`);
  if (pixel) words.push(`x=${pixel.x},${pixel.y}`);
  if (frame) words.push(`v=${[frame.x, frame.y, frame.scale].map((of) => Number(of.toPrecision(8))).join(",")}`);
  return words.join("&");
}

/** What a fragment says; nonsense in it is left out. @param {string} text @returns {Seen} */
export function parsed(text) {
  const seen = /** @type {Seen} */ ({ settings: {} });
  for (const word of text.replace(/^#/, "").split("&")) {
    const [name, raw = ""] = word.split(/=(.*)/s);
    let value = "";
    try {
      value = decodeURIComponent(raw);
    } catch {
      continue;
    }
    const parts = value.split(",");
    const numbers = parts.map(Number);
    const isSound = parts.every((of) => of.trim() !== "" && Number.isFinite(Number(of)));
    if (name === "z" && /^[\w-]+$/.test(value)) seen.packed = value;
    else if (name === "k" && /^\w{1,20}$/.test(value)) seen.kept = value;
    else if (name === "s" && /^[\w-]{1,80}$/.test(value)) seen.scene = value;
    else if (name === "e" && /^[\w-]+\/[\w-]+$/.test(value)) seen.example = value;
    else if (name === "t" && /^[\w.+-]+\/[\w.+-]+$/.test(value)) seen.type = value;
    else if (name === "p" && /^\w+$/.test(value)) seen.panel = value;
    else if (name === "x" && isSound && numbers.length === 2) seen.pixel = { x: Math.trunc(numbers[0]), y: Math.trunc(numbers[1]) };
    else if (name === "v" && isSound && numbers.length === 3 && numbers[2] > 0) seen.frame = { x: numbers[0], y: numbers[1], scale: numbers[2] };
    else if (/^q\.\w+$/.test(name) && value.length <= 40) /** @type {Record<string, string>} */ (seen.settings)[name.slice(2)] = value;
  }
  return seen;
}

/** @param {string} text */
const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** The request of a picture for curl, with the scene in a file. @param {string} base @param {Record<string, string>} settings @param {boolean} hasKey @param {string} type */
export function curlLine(base, settings, hasKey, type) {
  const query = new URLSearchParams(settings).toString();
  const key = hasKey ? ' -H "Authorization: Bearer $STRAHL_KEY"' : "";
  const media = type === "application/json" ? "" : ` -H 'Content-Type: ${type}'`;
  return `curl -sS${key}${media} --data-binary @${fileName(type)} ${quoted(`${base}/v1/render${query ? `?${query}` : ""}`)} -o picture.png`;
}

/** The same for the program on the command line. @param {Record<string, string>} settings @param {string} type */
export function programLine(settings, type) {
  const flags = Object.entries(settings).map(([name, value]) => ` --${name.replaceAll("_", "-")} ${/^[\w.:,+-]+$/.test(value) ? value : quoted(value)}`);
  return `strahl render ${fileName(type)}${flags.join("")} -o picture.png`;
}

/** Text within an attribute of HTML. @param {string} text */
const attribute = (text) => text.replaceAll("&", "&amp;").replaceAll('"', "&quot;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");

/** What shows a picture in another page: an element that zooms, or a plain picture. @param {string} base @param {string} location @param {string} name @param {{ width: number, height: number }} size */
export function tags(base, location, name, { width, height }) {
  const image = /\/v1\/images\/([\w-]+)/.exec(location)?.[1] ?? "";
  const about = `alt="${attribute(name)}" width="${width}" height="${height}"`;
  return {
    element: `<script type="module" src="${base}/embed.js"></script>\n<strahl-picture image="${image}" ${about} zoom controls></strahl-picture>`,
    picture: `<img src="${base}${location}" ${about}>`,
  };
}

/** @param {string} type */
export const fileName = (type) => (type === "text/x-nff" ? "scene.nff" : "scene.json");
