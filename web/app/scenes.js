// Where scenes come from: examples, files, links. Of a model, the service makes a scene.
import { batch, signal } from "../vendor/preact.js";
import { ask, askJson, askText, whole } from "./api.js";
import { plain, written } from "./pointers.js";
import { limits, pixel, say, setText, settings, text, origin } from "./state.js";
import { fit } from "./looking.js";

/** @typedef {{ id: string, title: string, about: string, href: string }} Example */

export const examples = signal(/** @type {Example[]} */ ([]));
/** The example that the text is, as long as it is unchanged, so that links stay short. */
export const example = signal(/** @type {{ id: string, text: string } | null} */ (null));

/** The name of the scene that was opened last: another one is a step to go back from. */
export const opened = signal("");
let last = 0;
/** A name that no scene of this tab has had, also before a reload. Later ones come later in their order. */
const fresh = () => (last = Math.max(last + 1, Date.now())).toString(36);

export async function loadExamples() {
  if (examples.peek().length === 0) examples.value = (await askJson("v1/examples")).examples;
}

/** Replaces the scene. Undo brings the old one back. @param {string} said @param {string} name @param {string} [type] @param {string} [as] its name among the opened ones */
export function open(said, name, type = "application/json", as = fresh()) {
  // The editor has one kind of line ends, and places are those in its text.
  const next = said.replace(/\r\n?/g, "\n");
  const before = { text: text.peek(), origin: origin.peek() };
  batch(() => {
    settings.value = {};
    pixel.value = null;
    opened.value = as;
    setText(next, { name, type });
  });
  fit();
  if (before.text !== "") say(`${name} is open.`, { label: "Back", run: () => setText(before.text, before.origin) });
}

let asked = 0;
/** Replaces the scene once its text is there, unless another one was asked for meanwhile. @param {Promise<string>} coming @param {string} name @param {string} [type] @param {string} [as] */
export async function openSoon(coming, name, type, as) {
  const mine = (asked += 1);
  const next = await coming;
  if (mine !== asked) return false;
  open(next, name, type, as);
  return true;
}

/** @param {string} id */
export async function openExample(id) {
  const isOpen = await openSoon(askText(`v1/examples/${id}`), examples.peek().find((of) => of.id === id)?.title ?? id);
  if (isOpen) example.value = { id, text: text.peek() };
  return isOpen;
}

/** Media types of models by the ends of their names. */
const TYPES = /** @type {Record<string, string>} */ ({ glb: "model/gltf-binary", gltf: "model/gltf+json", obj: "model/obj", stl: "model/stl", ply: "model/ply" });
const ANY = "application/octet-stream";
/** Characters of a scene that holds the shapes of a model itself: as many as a tab keeps. */
const LONGEST = 5 << 20;

/** The media type of a model, by its name, else by how it begins; what is no text the service knows. @param {string} name @param {string} start */
export function modelType(name, start) {
  const [, end] = /\.(\w+)$/.exec(name.toLowerCase()) ?? [];
  const isModel = /^(?:glTF|ply[\r\n]|\s*solid\s|\s*\{[^]*?"asset"\s*:\s*\{)|\0/i.test(start)
    || /^\s*(?:v[nt]?\s+[-+.\d]|(?:mtllib|usemtl|[og])\s)/.test(start.replace(/^[ \t]*#.*$/gm, ""));
  return Object.hasOwn(TYPES, end) ? TYPES[end] : isModel ? ANY : null;
}

/** JSON with a line for whatever is longer than one. @param {any} value @param {string} [indent] @returns {string} */
export function laidOut(value, indent = "\n") {
  const line = written(value);
  if (line.length < 110 || typeof value !== "object") return line;
  const inside = `${indent}  `;
  if (Array.isArray(value)) return `[${value.map((of) => inside + laidOut(of, inside))}${indent}]`;
  return `{${Object.entries(value).map(([key, of]) => `${inside}${JSON.stringify(key)}: ${laidOut(of, inside)}`)}${indent}}`;
}

/** The scene of a model with an asset in place of its shapes; the floor is no part of it. @param {any} scene @param {string} asset */
export function placed({ version, image, camera, definitions: _, import_warnings: warnings = [], materials, objects, ...rest }, asset) {
  const last = objects.at(-1);
  const floor = last.mesh?.material;
  const hasFloor = materials[floor]?.pbr?.shadow_catcher;
  // What was said of its file is said again wherever that is placed.
  const import_warnings = warnings.filter((/** @type {any} */ { detail }) => /^\w+: (exposure|spot-edge|edges|backs):/.test(detail));
  return {
    version, image, camera, ...rest,
    ...(import_warnings.length > 0 && { import_warnings }),
    ...(hasFloor && { materials: { [floor]: materials[floor] } }),
    objects: [{ model: { asset } }, ...(hasFloor ? [last] : [])],
  };
}

/** Why the service refuses a model, for people: without the media types that it takes, and the words for the command line. @param {any} error @returns {string} */
export function reasonOf({ message, errors: [first, ...more] = [] }) {
  if (!first) return /x-nff/.test(message) ? "it is no scene and no model" : message;
  const [needed] = /^"[^"]*"/.exec(first.detail) ?? [];
  if (first.code === "missing-part") return `it needs ${needed}. Open both together, or make one .glb of them`;
  const place = plain(first.pointer ?? "").slice(1).replaceAll("/", " › ");
  return `${first.detail.replace(/ \(--input[^)]*\)/, "")}${place && `, at ${place}`}${more.length > 0 ? `, and ${more.length} more` : ""}`;
}

/** The text of the scene that the service makes of a model. @param {Blob} body @param {string} name @param {string} type @param {File[]} parts the files beside it */
async function sceneOf(body, name, type, parts) {
  const form = new FormData();
  form.append("file", body, name);
  for (const part of parts) form.append("file", part);
  const isOne = parts.length === 0;
  const answer = await ask("v1/scenes", isOne ? { body, type } : { body: form });
  const { scene_id, warnings } = await whole(answer.json());
  const path = `v1/scenes/${scene_id}`;
  const text = await askText(path);
  // It holds all shapes, and nobody asks for them again.
  if (answer.status === 201) ask(path, { method: "DELETE" }).catch(() => {});
  const scene = JSON.parse(text);
  // An asset is one file, and places a model where that says, even if it had to be moved or scaled.
  if (isOne && !warnings.some((/** @type {any} */ { detail }) => detail.includes(": the scene has it "))) {
    const { asset } = await askJson("v1/assets", { body, type: ANY });
    return laidOut(placed(scene, asset));
  }
  if (text.length > LONGEST) throw new Error("it has too many shapes for a text. Make one .glb of it, near the origin and of a usual size");
  // Of a long text the page reads what stands before the objects.
  const { version, image, camera, objects, ...rest } = scene;
  return laidOut({ version, image, camera, objects, ...rest });
}

/** Opens a scene, or a model with the files that it names. @param {Iterable<File>} files */
export async function openFiles(files) {
  const all = [...files];
  const file = all.find((of) => modelType(of.name, "")) ?? all[0];
  const name = file.name.replace(/\.gz$/i, "");
  const read = async () => {
    try {
      const stream = name === file.name ? file.stream() : file.stream().pipeThrough(new DecompressionStream("gzip"));
      const body = await new Response(stream).blob().catch(() => {
        throw new Error("it cannot be read");
      });
      const most = limits.peek()?.request.max_body_bytes ?? Infinity;
      if (body.size > most) throw new Error(`it has ${body.size.toLocaleString("en")} bytes, and the service takes ${most.toLocaleString("en")}`);
      const type = modelType(name, await body.slice(0, 1 << 16).text());
      return type ? await sceneOf(body, name, type, all.filter((of) => of !== file)) : await body.text();
    } catch (error) {
      throw new Error(`${name} cannot be opened: ${reasonOf(error)}.`);
    }
  };
  say(`${name} is on its way.`);
  await openSoon(read(), name, /\.nff$/i.test(name) ? "text/x-nff" : "application/json").catch((error) => say(error.message));
}

/** Whether a file hangs over the page. */
export const isDropping = signal(false);

/** Takes files that are dropped onto the page. */
export function takeDrops() {
  addEventListener("dragover", (event) => {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    isDropping.value = true;
  });
  addEventListener("dragleave", (event) => event.relatedTarget === null && (isDropping.value = false));
  addEventListener("drop", (event) => {
    isDropping.value = false;
    const files = event.dataTransfer?.files;
    if (!files?.length) return;
    event.preventDefault();
    openFiles(files);
  });
}
