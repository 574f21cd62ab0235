// What the page begins with, and its address: all that is seen is in the fragment, so that a reload or a link restores it.
import { batch, effect, untracked } from "../vendor/preact.js";
import { ask, askJson, goOffline, lookForNews } from "./api.js";
import { parsed, unpacked } from "./link.js";
import { lookAt } from "./looking.js";
import { open, openExample, opened } from "./scenes.js";
import { seen } from "./share.js";
import { key, limits, panel, pixel, say, settings, status, text, view } from "./state.js";

const FIRST = "whitted/whitted";
/** Milliseconds of rest before the address follows. */
const REST = 400;
/** Characters of an address that every browser takes. */
const LONGEST = 30_000;

/** Where the text of this tab is, if it is too long for its address. */
const KEPT = "strahl-text";

let own = "";
let stepped = 0;

/** Shows what a fragment says. @param {string} words */
async function restore(words) {
  const of = parsed(words);
  try {
    const kept = of.kept ? sessionStorage.getItem(KEPT) : null;
    if (kept !== null) open(kept, "the scene of this tab", of.type);
    else if (of.packed) open(await unpacked(of.packed), "a scene from a link", of.type);
    else if (of.scene) open(await (await ask(`v1/scenes/${of.scene}`)).text(), of.scene);
    else await openExample(of.example ?? FIRST);
  } catch (error) {
    say(`This link cannot be opened: ${/** @type {Error} */ (error).message}`);
    if (text.peek() === "") await openExample(FIRST).catch((failure) => (status.value = { word: "failed", detail: failure.message }));
  }
  batch(() => {
    settings.value = of.settings ?? {};
    if (of.pixel) pixel.value = of.pixel;
    if (of.panel) panel.value = of.panel;
    if (of.frame) lookAt(of.frame);
  });
}

function keepText() {
  try {
    sessionStorage.setItem(KEPT, text.peek());
  } catch {
    // It is larger than what browsers keep: a reload begins anew.
  }
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
  if (location.hash === "") say(matchMedia("(pointer: coarse)").matches ? "Change the text, tap a pixel, or pinch the picture." : "Change the text, hold Alt and drag a number, or click a pixel.");
  askJson("v1/limits").then((found) => (limits.value = found), () => {});
  stepped = opened.peek();
  addEventListener("hashchange", () => location.hash !== own && restore((own = location.hash)).then(() => (stepped = opened.peek())));
  document.addEventListener("visibilitychange", () => document.hidden || lookForNews().catch(goOffline));
  let timer = 0;
  effect(() => {
    void [text.value, settings.value, panel.value, pixel.value, view.value];
    untracked(() => {
      clearTimeout(timer);
      timer = window.setTimeout(async () => {
        const before = location.hash;
        const next = `#${await seen(LONGEST)}`;
        // Somebody has gone to another address meanwhile.
        if (location.hash !== before) return;
        if (next.includes("k=1")) keepText();
        if (next === own) return;
        own = next;
        // Another scene is a step to go back from; a change is none.
        if (opened.peek() !== stepped && location.hash !== "") history.pushState(null, "", own);
        else history.replaceState(null, "", own);
        stepped = opened.peek();
      }, REST);
    });
  });
}

