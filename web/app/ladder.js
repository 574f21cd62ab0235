// What is rendered when: a state machine without effects. `next` takes an event and gives actions; `picture.js` carries them out.
//
// Rung 0 answers at once, with one sample a pixel and as many pixels as 20 ms allow, by what the last one took; where not even few are
// that quick it has a ceiling. It is never aborted. Rung 1 is the full size with one sample, after 140 ms of quiet. Rung 2 is what the
// scene asks for. Newer texts abort both.

/** @typedef {0 | 1 | 2} Rung */
/**
 * @typedef {{ type: "edit", now: number }
 *   | { type: "known", now: number }
 *   | { type: "answer", rung: Rung, version: number, now: number, outcome: "picture" | "invalid" | "failed" | "aborted", base?: number, perPixel?: number }
 *   | { type: "busy", rung: Rung, version: number, now: number, seconds: number }
 *   | { type: "predicted", version: number, now: number, ms: number }
 *   | { type: "live", now: number, on: boolean }
 *   | { type: "force", now: number }
 *   | { type: "again", now: number }
 *   | { type: "size", now: number, width: number, height: number }
 *   | { type: "tick", now: number }} Event
 * `base`: milliseconds before the first ray; `perPixel`: milliseconds for a pixel after that, of a picture without a ceiling
 */
/**
 * @typedef {{ type: "send", rung: Rung, version: number, width: number, height: number, ceiling: number }
 *   | { type: "abort", rung: Rung }
 *   | { type: "ask", version: number }
 *   | { type: "offer", version: number, ms: number }
 *   | { type: "show", rung: Rung, version: number }
 *   | { type: "drop", rung: Rung, version: number }
 *   | { type: "wake", at: number }} Action
 * `ceiling`: milliseconds for `accuracy=time:`, or 0; `ask`: for the plan
 */

/** Widths of rung 0. `accuracy=time:25` would take its 25 ms also for scenes that need 5, so it is the last resort. */
const WIDTHS = [960, 640, 480, 320, 240, 160];
const WIDTH_WITH_CEILING = 240;
/** Milliseconds that rung 0 may take: less than a frame and a half. */
const QUICK = 20;
const CEILING = 25;
/** Milliseconds for a pixel that are assumed at first: those of a picture 160 wide in 20 ms. */
const FIRST = 20 / (160 * 90);
/** An answer with a ceiling tells nothing, so a machine that was busy is tried again. */
const FORGET = 0.85;
/** Milliseconds of quiet before rung 1. With 60, most edits began full pictures that nobody saw. */
const QUIET = 140;
/** Predicted milliseconds above which rung 2 is offered, not sent. */
const LONGEST = 2000;

export class Ladder {
  version = 0;
  /** The highest rung that the newest text has reached; -1 is none. */
  done = -1;
  /** Whether the service has refused the newest text. */
  refused = false;
  live = true;
  forced = false;
  /** Time of the last edit. */
  edited = 0;
  /** Predicted milliseconds of rung 2; undefined: not asked for; null: asked for. */
  predicted = /** @type {number | null | undefined} */ (undefined);
  offered = false;
  /** Not before this time, since the service is busy. */
  notBefore = 0;
  /** Requests on their way: the version, or 0. */
  quick = 0;
  slow = /** @type {{ rung: Rung, version: number } | null} */ (null);
  shown = { version: 0, rung: -1 };
  size = { width: 960, height: 540 };
  /** What pictures with one sample a pixel and without a ceiling take, or null. */
  rate = /** @type {{ base: number, perPixel: number } | null} */ (null);
  actions = /** @type {Action[]} */ ([]);

  /** @param {Event} event @returns {Action[]} */
  next(event) {
    this.actions = [];
    switch (event.type) {
      case "edit":
        this.#begin(event.now);
        break;
      case "known":
        // The page still has the picture of this text.
        this.#begin(event.now);
        this.done = 2;
        this.shown = { version: this.version, rung: 2 };
        this.#askOnce();
        break;
      case "answer":
        this.#answer(event);
        break;
      case "busy":
        this.#landed(event.rung, event.version);
        this.notBefore = event.now + event.seconds * 1000;
        break;
      case "predicted":
        if (event.version === this.version) this.predicted = event.ms;
        break;
      case "live":
        this.live = event.on;
        break;
      case "force":
        this.forced = true;
        this.refused = false;
        // Who asks by hand need not wait: the service may say again when.
        this.notBefore = 0;
        break;
      case "again":
        // The service is back. What takes long is still offered only.
        this.refused = false;
        if (this.predicted === null) this.predicted = undefined;
        break;
      case "size":
        this.size = { width: event.width, height: event.height };
        break;
    }
    this.#advance(event.now);
    return this.actions;
  }

  /** @param {number} now */
  #begin(now) {
    this.version += 1;
    this.done = -1;
    this.refused = false;
    this.forced = false;
    this.offered = false;
    this.edited = now;
    this.predicted = undefined;
    if (this.slow) this.actions.push({ type: "abort", rung: this.slow.rung });
    this.slow = null;
  }

  /** @param {Rung} rung @param {number} version */
  #landed(rung, version) {
    if (rung === 0) this.quick = 0;
    else if (this.slow?.rung === rung && this.slow.version === version) this.slow = null;
  }

  /** @param {Extract<Event, { type: "answer" }>} event */
  #answer({ rung, version, outcome, base, perPixel }) {
    this.#landed(rung, version);
    if (outcome === "picture") {
      const isNewer = version > this.shown.version || (version === this.shown.version && rung > this.shown.rung);
      this.actions.push({ type: isNewer ? "show" : "drop", rung, version });
      if (isNewer) this.shown = { version, rung };
      if (version === this.version) this.done = Math.max(this.done, rung);
      if (base !== undefined && perPixel !== undefined) this.#learn(base, perPixel);
      else if (rung === 0 && this.rate) this.rate = { base: this.rate.base * FORGET, perPixel: this.rate.perPixel * FORGET };
    } else if (outcome === "invalid" && version === this.version) this.refused = true;
    else if (outcome === "failed" && version === this.version) this.refused = true;
  }

  /** One slow answer counts at once, fast ones little by little. Rung 1 tells what a picture with a ceiling cannot. @param {number} base @param {number} perPixel */
  #learn(base, perPixel) {
    const mix = (/** @type {number} */ old, /** @type {number} */ seen) => Math.max(seen, (old + seen) / 2);
    this.rate = this.rate ? { base: mix(this.rate.base, base), perPixel: mix(this.rate.perPixel, perPixel) } : { base, perPixel };
  }

  #askOnce() {
    if (this.predicted !== undefined) return;
    this.predicted = null;
    this.actions.push({ type: "ask", version: this.version });
  }

  /** @param {number} now */
  #advance(now) {
    if (this.version === 0 || this.refused || (!this.live && !this.forced)) return;
    if (now < this.notBefore) {
      this.actions.push({ type: "wake", at: this.notBefore });
      return;
    }
    if (this.done < 0) {
      if (this.quick === 0) {
        this.quick = this.version;
        this.actions.push({ type: "send", rung: 0, version: this.version, ...this.#quickly() });
      }
      return;
    }
    if (this.slow) return;
    if (this.done < 2 && now < this.edited + QUIET && !this.forced) {
      this.actions.push({ type: "wake", at: this.edited + QUIET });
    } else if (this.done < 1) {
      this.#askOnce();
      this.#send(1);
    } else if (this.done < 2) {
      this.#askOnce();
      if (this.predicted === null || this.predicted === undefined) return;
      if (this.predicted <= LONGEST || this.forced) this.#send(2);
      else if (!this.offered) {
        this.offered = true;
        this.actions.push({ type: "offer", version: this.version, ms: this.predicted });
      }
    }
  }

  /** @param {1 | 2} rung */
  #send(rung) {
    this.slow = { rung, version: this.version };
    this.actions.push({ type: "send", rung, version: this.version, ...this.size, ceiling: 0 });
  }

  /** The largest picture that is quick. */
  #quickly() {
    const { width, height } = this.size;
    const sized = (/** @type {number} */ wide) => ({ width: Math.min(wide, width), height: Math.max(1, Math.round((Math.min(wide, width) * height) / width)) });
    const rate = this.rate ?? { base: 0, perPixel: FIRST };
    const found = WIDTHS.map(sized).find((of) => rate.base + rate.perPixel * of.width * of.height <= QUICK);
    return found ? { ...found, ceiling: 0 } : { ...sized(WIDTH_WITH_CEILING), ceiling: CEILING };
  }
}
