// What the page begins with, and its address: all that is seen is in the fragment, so that a reload or a link restores it.
import { batch, effect, untracked } from "../vendor/preact.js";
import { askJson, askText, goOffline, lookForNews } from "./api.js";
import { parsed, unpacked } from "./link.js";
import { lookAt } from "./looking.js";
import { openExample, openSoon, opened } from "./scenes.js";
import { seen } from "./share.js";
import { connection, key, limits, panel, pixel, say, settings, status, text, view } from "./state.js";

const FIRST = "whitted/whitted";
/** Milliseconds of rest before the address follows. */
const REST = 400;
/** Characters of an address that every browser takes. */
const LONGEST = 30_000;

/** Where the texts of this tab are that are too long for their addresses, each by the name of its scene. */
const KEPT = "strahl-text-";
/** Characters that a browser keeps for a tab. */
const LARGEST = 5 << 20;

let own = "";
let stepped = "";

/** @param {string} words */
async function restore(words) {
  const of = parsed(words);
  try {
    const isOpen = of.kept ? await openSoon(keptText(of.kept), "the scene of this tab", of.type, of.kept)
      : of.packed ? await openSoon(unpacked(of.packed), "a scene from a link", of.type)
      : of.scene ? await openSoon(askText(`v1/scenes/${of.scene}`), of.scene)
      : await openExample(of.example ?? FIRST);
    if (!isOpen) return;
  } catch (error) {
    if (text.peek() === "") await openExample(FIRST).catch((failure) => (status.value = { word: "failed", detail: failure.message }));
    say(`This link cannot be opened: ${/** @type {Error} */ (error).message}`, { label: "Try again", run: () => void restore(words) });
  }
  batch(() => {
    settings.value = of.settings ?? {};
    if (of.pixel) pixel.value = of.pixel;
    if (of.panel) panel.value = of.panel;
    if (of.frame) lookAt(of.frame);
  });
}

/** The text of a scene whose address has only its name. @param {string} name */
async function keptText(name) {
  const kept = sessionStorage.getItem(KEPT + name);
  if (kept === null) throw new Error("its scene is too long for an address, and this tab does not have it any more");
  return kept;
}

/** Keeps the text, for a reload and for Back. The oldest ones make room. @param {string} name */
function keepText(name) {
  try {
    // An older state of the scene must not come back if this one cannot be kept.
    sessionStorage.removeItem(KEPT + name);
    const older = Object.keys(sessionStorage).filter((place) => place.startsWith(KEPT)).sort();
    while (text.peek().length <= LARGEST && !isKept(KEPT + name)) {
      const oldest = older.shift();
      if (oldest === undefined) break;
      sessionStorage.removeItem(oldest);
    }
  } catch {
    // A browser without storage: a reload begins anew.
  }
}

/** Whether there was room for the text. @param {string} place */
function isKept(place) {
  try {
    sessionStorage.setItem(place, text.peek());
    return true;
  } catch {
    return false;
  }
}

/** Starts with what the address says, and lets it follow from then on. */
export async function start() {
  try {
    key.value = sessionStorage.getItem("strahl-key") ?? "";
  } catch {
    // Without storage there is no key yet.
  }
  const show = (/** @type {string} */ words) => restore((own = words)).then(() => void (stepped = opened.peek()));
  await show(location.hash);
  if (location.hash === "") say(matchMedia("(pointer: coarse)").matches ? "Change the text, tap a pixel, or pinch the picture." : "Change the text, hold Alt and drag a number, or click a pixel.");
  askJson("v1/limits").then((found) => (limits.value = found), () => {});
  addEventListener("hashchange", () => location.hash !== own && show(location.hash));
  // A page that has nothing yet begins when the service is back.
  let wasOnline = connection.peek().online;
  effect(() => {
    const { online } = connection.value;
    if (online && !wasOnline && text.peek() === "") untracked(() => show(own));
    wasOnline = online;
  });
  document.addEventListener("visibilitychange", () => document.hidden || lookForNews().catch(goOffline));
  let timer = 0;
  effect(() => {
    void [text.value, settings.value, panel.value, pixel.value, view.value];
    untracked(() => {
      clearTimeout(timer);
      // The address of a scene that did not come stays.
      if (text.peek() === "") return;
      timer = window.setTimeout(async () => {
        const before = [location.hash, opened.peek()];
        const next = `#${await seen(LONGEST)}`;
        // Somebody has gone to another address or opened another scene meanwhile.
        if (location.hash !== before[0] || opened.peek() !== before[1]) return;
        const { kept } = parsed(next);
        if (kept) keepText(kept);
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

