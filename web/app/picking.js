// The object under the pointer lights up its lines in the editor.
import { effect } from "../vendor/preact.js";
import { askJson } from "./api.js";
import { draft, hover, lit, moved, origin, rendered, settings, shown, status } from "./state.js";

/** Milliseconds between two questions. */
const PACE = 40;
/** One ray a pixel, and only its first hit: 0.3 ms in the service for scenes that it has built. */
const FIRST_HIT = { accuracy: "fixed", antialias: "false", samples: "1", max_depth: "1" };

let asking = new AbortController();
let timer = 0;
let last = "";

async function look() {
  const at = hover.peek();
  if (!at || status.peek().word === "invalid" || origin.peek().type !== "application/json" || rendered.peek().length > 1 << 18) return clear();
  const { width, height, size, dpr } = settings.peek();
  const query = { ...FIRST_HIT, width, height, size, dpr, x: at.x, y: at.y };
  try {
    const tree = await askJson("v1/tree", { method: "POST", body: rendered.peek(), type: origin.peek().type, query, signal: asking.signal });
    const object = tree.rays?.[0]?.hit?.object ?? "";
    if (object !== last) (last = object), (lit.value = object === "" ? [] : [object]);
  } catch {
    // The next move asks again.
  }
}

function clear() {
  if (last === "") return;
  last = "";
  lit.value = [];
}

/** Follows the pointer from now on. */
export function start() {
  effect(() => {
    const at = hover.value;
    // While the camera moves nobody reads the text.
    const isStill = draft.value === null && moved.value === null;
    clearTimeout(timer);
    asking.abort();
    asking = new AbortController();
    if (at && isStill && shown.peek()) timer = window.setTimeout(look, PACE);
    else clear();
  });
}
