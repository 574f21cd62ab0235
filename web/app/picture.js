// Carries out what the ladder says: sends, aborts, shows. Keeps the last pictures, so that undo is at once.
import { batch, effect, untracked } from "../vendor/preact.js";
import { Problem, Unreachable, askJson, patiently, render } from "./api.js";
import { LARGE, isForgotten, sentFor } from "./base.js";
import { sized } from "./framing.js";
import { Ladder } from "./ladder.js";
import { wordsOf } from "./problems.js";
import { bitmaps, connection, key, live, moved, offer, origin, plan, problems, rendered, scene, settings, shown, size, status, version } from "./state.js";

/** @typedef {import("./ladder.js").Action} Action */
/** @typedef {import("./state.js").Shown} Shown */
/** @typedef {{ text: string, type: string, settings: import("./state.js").Settings, version: number, patch: import("./base.js").Patch | null }} Asked */

const KEPT = 16;
const ladder = new Ladder();
/** What each version of the ladder asks for, as long as an answer may come. */
const asked = /** @type {Map<number, Asked>} */ (new Map());
/** Finished pictures by what they show; the last is the newest. */
const kept = /** @type {Map<string, Shown>} */ (new Map());
const answers = /** @type {Map<string, Shown>} */ (new Map());
let slow = new AbortController();
let explaining = new AbortController();
let wakes = 0;
let trouble = 0;
/** Milliseconds after typing before a mistake is shown: halfway through a word the text is wrong, too. */
const PATIENCE = { syntax: 400, other: 120 };

/** Limits that jobs do not have. */
const TOO_MUCH = new Set(["max_pixels", "max_samples_total", "timeout"]);

/** What a picture is kept by. A large text would be hashed for each move of the camera: its number does. @param {Asked} of */
const nameOf = (of) => `${JSON.stringify([of.type, of.settings, of.patch])}\n${of.text.length < LARGE ? of.text : of.version}`;

/** @param {Shown | null} picture */
function letGo(picture) {
  if (!picture || picture === shown.peek() || [...kept.values()].includes(picture)) return;
  picture.bitmap.close();
  bitmaps.closed += 1;
}

/** @param {Shown} picture */
function show(picture) {
  const before = shown.peek();
  shown.value = picture;
  if (picture.rung > 0 && !scene.peek()) size.value = { width: picture.width, height: picture.height };
  if (before !== picture) letGo(before);
}

/** @param {import("./ladder.js").Event} event */
function tell(event) {
  for (const action of ladder.next(event)) act(action);
  const { word } = status.peek();
  if (ladder.done === 2 && (word === "tracing" || word === "starting")) status.value = { word: "live", detail: "" };
}

/** @param {Action} action */
function act(action) {
  switch (action.type) {
    case "send":
      send(action);
      break;
    case "abort":
      slow.abort();
      break;
    case "ask":
      explain(action.version);
      break;
    case "offer":
      batch(() => ((offer.value = action.ms), (status.value = { word: "live", detail: "a quick picture" })));
      break;
    case "show":
    case "drop": {
      const name = `${action.version}/${action.rung}`;
      const picture = answers.get(name);
      answers.delete(name);
      if (picture && action.type === "show") show(picture);
      else if (picture) letGo(picture);
      break;
    }
    case "wake": {
      const wake = (wakes += 1);
      setTimeout(() => wake === wakes && tell({ type: "tick", now: performance.now() }), Math.max(0, action.at - performance.now()));
      break;
    }
  }
}

/** @param {Extract<Action, { type: "send" }>} action */
async function send({ rung, version: number, width, height, ceiling }) {
  const of = /** @type {Asked} */ (asked.get(number));
  if (rung > 0) slow = new AbortController();
  const signal = rung > 0 ? slow.signal : undefined;
  const plainly = { accuracy: ceiling > 0 ? `time:${ceiling}` : "fixed", antialias: "false", samples: "1" };
  const full = rung === 2 ? of.settings : { ...of.settings, ...plainly };
  const all = rung === 0 ? sized(full, { width, height }) : full;
  if (rung > 0) status.value = { word: "tracing", detail: rung === 2 ? "as the scene says" : "full size" };
  const base = { rung, version: number };
  try {
    const { body, type } = await sentFor(of, signal);
    const { bitmap, report } = await render({ text: body, type, settings: all, signal, priority: rung === 0 ? "high" : "auto" });
    bitmaps.made += 1;
    const picture = { bitmap, width: bitmap.width, height: bitmap.height, rung, version: of.version, text: of.text, settings: all, report };
    answers.set(`${number}/${rung}`, picture);
    if (rung === 2) keep(nameOf(of), picture);
    const trace = report.phases.filter(({ name }) => name === "trace" || name === "png").reduce((sum, { ms }) => sum + ms, 0);
    const rate = report.hit || ceiling > 0 || rung === 2 ? {} : { base: report.ms - trace, perPixel: trace / (width * height) };
    batch(() => {
      if (number === ladder.version) problems.value = [];
      tell({ type: "answer", ...base, outcome: "picture", now: performance.now(), ...rate });
    });
  } catch (error) {
    fail(error, base, signal);
  }
}

/** @param {any} error @param {{ rung: import("./ladder.js").Rung, version: number }} base @param {AbortSignal} [signal] */
function fail(error, base, signal) {
  const now = performance.now();
  if (signal?.aborted) return tell({ type: "answer", ...base, outcome: "aborted", now });
  const isNewest = base.version === ladder.version;
  if (isForgotten(error)) return tell({ type: "busy", ...base, now, seconds: 0 });
  if (error instanceof Problem && error.retryAfter > 0) {
    if (isNewest) status.value = { word: "waiting", detail: error.message };
    return tell({ type: "busy", ...base, now, seconds: error.retryAfter });
  }
  if (error instanceof Problem && error.errors.length > 0) {
    if (isNewest) {
      const told = () => batch(() => ((problems.value = error.errors), (status.value = { word: "invalid", detail: wordsOf(error.errors[0]) })));
      clearTimeout(trouble);
      trouble = window.setTimeout(told, error.errors[0].code === "invalid-json" ? PATIENCE.syntax : PATIENCE.other);
    }
    return tell({ type: "answer", ...base, outcome: "invalid", now });
  }
  if (isNewest) {
    const isRefused = error instanceof Problem;
    batch(() => {
      if (isRefused) problems.value = [];
      status.value = error instanceof Unreachable ? { word: "offline", detail: "looking for the service" }
        : isRefused && TOO_MUCH.has(error.limit) ? { word: "failed", detail: "Too much for one answer; a job may be larger.", job: true }
        : { word: "failed", detail: error.message };
    });
  }
  tell({ type: "answer", ...base, outcome: "failed", now });
}

/** @param {string} name @param {Shown} picture */
function keep(name, picture) {
  kept.delete(name);
  kept.set(name, picture);
  for (const [oldest, old] of kept) {
    if (kept.size <= KEPT) break;
    kept.delete(oldest);
    letGo(old);
  }
}

/** @param {number} number */
async function explain(number) {
  const of = /** @type {Asked} */ (asked.get(number));
  explaining.abort();
  explaining = new AbortController();
  const { signal } = explaining;
  let ms = 0;
  try {
    const answer = await patiently(async () => askJson("v1/explain", { ...(await sentFor(of)), query: of.settings, signal }), signal);
    if (number !== ladder.version) return;
    plan.value = answer;
    ms = answer.estimate.ms;
  } catch (error) {
    // It is asked for again when the service is back.
    if (signal.aborted || number !== ladder.version || error instanceof Unreachable) return;
    // Without a plan the picture is not held back: the service has limits of its own.
  }
  tell({ type: "predicted", version: number, now: performance.now(), ms });
}

/** Renders the scene as it is, however long it takes. */
export const renderNow = () => (status.value = { word: "tracing", detail: "" }, offer.value = null, tell({ type: "force", now: performance.now() }));

/** Asks again for what has failed. What waits for somebody goes on waiting. */
function again() {
  if (ladder.version === 0) return;
  if (["offline", "failed"].includes(status.peek().word)) status.value = live.peek() || ladder.forced ? { word: "tracing", detail: "" } : { word: "paused", detail: "Ctrl-Enter renders" };
  tell({ type: "again", now: performance.now() });
}

/** Watches the text and the settings from now on. */
export function start() {
  effect(() => {
    const { width, height } = size.value;
    untracked(() => tell({ type: "size", now: performance.now(), width, height }));
  });
  effect(() => {
    const of = { text: rendered.value, type: origin.value.type, settings: settings.value, patch: moved.value };
    untracked(() => {
      if (of.text === "" && ladder.version === 0) return;
      const whole = { ...of, version: version.peek() };
      const known = kept.get(nameOf(whole));
      asked.set(ladder.version + 1, whole);
      for (const number of asked.keys()) if (number < ladder.version - 3 && number !== ladder.quick) asked.delete(number);
      clearTimeout(trouble);
      batch(() => {
        offer.value = null;
        if (known) {
          keep(nameOf(whole), known);
          show(known);
          problems.value = [];
          status.value = { word: "live", detail: "" };
        } else if (!live.peek()) status.value = { word: "paused", detail: "Ctrl-Enter renders" };
        tell({ type: known ? "known" : "edit", now: performance.now() });
      });
    });
  });
  effect(() => {
    const on = live.value;
    untracked(() => {
      if (!on) status.value = { word: "paused", detail: "Ctrl-Enter renders" };
      else if (status.peek().word === "paused") status.value = { word: "live", detail: "" };
      tell({ type: "live", on, now: performance.now() });
    });
  });
  // What failed for want of the service or of a key is asked for again.
  let had = { online: true, key: key.peek() };
  effect(() => {
    const has = { online: connection.value.online, key: key.value };
    const isTime = (has.online && !had.online) || (has.key !== had.key && has.key !== "" && status.peek().word === "failed");
    had = has;
    if (isTime) untracked(again);
  });
}
