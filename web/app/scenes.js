// Where scenes come from: examples, files, links.
import { batch, signal } from "../vendor/preact.js";
import { ask, askJson } from "./api.js";
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

/** Replaces the scene. Undo brings the old one back. @param {string} next @param {string} name @param {string} [type] @param {string} [as] its name among the opened ones */
export function open(next, name, type = "application/json", as = fresh()) {
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

/** @param {string} id */
export async function openExample(id) {
  const body = await (await ask(`v1/examples/${id}`)).text();
  open(body, examples.peek().find((of) => of.id === id)?.title ?? id);
  example.value = { id, text: body };
}

/** @param {File} file */
export async function openFile(file) {
  const most = limits.peek()?.scene?.scene_bytes ?? 256 << 20;
  if (file.size > most) return say(`${file.name} is larger than the ${most} bytes that the service reads.`);
  const isPacked = file.name.endsWith(".gz");
  const stream = isPacked ? file.stream().pipeThrough(new DecompressionStream("gzip")) : file.stream();
  let body;
  try {
    body = await new Response(stream).text();
  } catch {
    return say(`${file.name} cannot be unpacked.`);
  }
  const name = file.name.replace(/\.gz$/, "");
  open(body, name, name.endsWith(".nff") ? "text/x-nff" : "application/json");
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
