// What the page begins with, and its address: all that is seen is in the fragment, so that a reload or a link restores it.
import { batch, effect, untracked } from "../vendor/preact.js";
import { ask, askJson } from "./api.js";
import { parsed, unpacked } from "./link.js";
import { lookAt } from "./looking.js";
import { panels } from "./panels/registry.js";
import { open, openExample } from "./scenes.js";
import { seen } from "./share.js";
import { key, limits, panel, pixel, say, settings, status, text, view } from "./state.js";

const FIRST = "whitted/whitted";
/** Milliseconds of rest before the address follows. */
const REST = 400;
/** Characters of an address that every browser takes. */
const LONGEST = 30_000;

let own = "";

/** Shows what a fragment says. @param {string} words */
async function restore(words) {
  const of = parsed(words);
  try {
    if (of.packed) open(await unpacked(of.packed), "a scene from a link", of.type);
    else if (of.scene) open(await (await ask(`v1/scenes/${of.scene}`)).text(), of.scene);
    else await openExample(of.example ?? FIRST);
  } catch (error) {
    say(`This link cannot be opened: ${/** @type {Error} */ (error).message}`);
    if (text.peek() === "") await openExample(FIRST).catch((failure) => (status.value = { word: "failed", detail: failure.message }));
  }
  batch(() => {
    settings.value = of.settings ?? {};
    if (of.pixel) pixel.value = of.pixel;
    if (of.panel && panels.some(({ id }) => id === of.panel)) panel.value = of.panel;
    if (of.frame) lookAt(of.frame);
  });
}

/** Starts with what the address says, and lets it follow from then on. */
export async function start() {
  try {
    key.value = sessionStorage.getItem("strahl-key") ?? "";
  } catch {
    // Without storage there is no key yet.
  }
  own = location.hash;
  await restore(location.hash);
  if (location.hash === "") say("Change the text, hold Alt and drag a number, or click a pixel.");
  askJson("v1/limits").then((found) => (limits.value = found), () => {});
  addEventListener("hashchange", () => location.hash !== own && restore((own = location.hash)));
  let timer = 0;
  effect(() => {
    void [text.value, settings.value, panel.value, pixel.value, view.value];
    untracked(() => {
      clearTimeout(timer);
      timer = window.setTimeout(async () => {
        const words = await seen();
        if (words.length > LONGEST) return;
        own = `#${words}`;
        history.replaceState(null, "", own);
      }, REST);
    });
  });
}

