// Where scenes come from: examples, files, links.
import { batch, signal } from "../vendor/preact.js";
import { askJson, askText } from "./api.js";
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

/** @param {File} file */
export async function openFile(file) {
  const most = limits.peek()?.scene?.scene_bytes ?? 256 << 20;
  if (file.size > most) return say(`${file.name} is larger than the ${most} bytes that the service reads.`);
  const isPacked = /\.gz$/i.test(file.name);
  const stream = isPacked ? file.stream().pipeThrough(new DecompressionStream("gzip")) : file.stream();
  const name = file.name.replace(/\.gz$/i, "");
  const read = async () => {
    const body = await new Response(stream).text().catch(() => {
      throw new Error(`${file.name} cannot be unpacked.`);
    });
    if (body.includes("\0")) throw new Error(`${name} is no text. Scenes are JSON or NFF; a model is named in one.`);
    return body;
  };
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
    const file = event.dataTransfer?.files[0];
    if (!file) return;
    event.preventDefault();
    openFile(file);
  });
}
