// EXPLAIN ANALYZE: renders the scene once and says beside each estimate what it really took. Asked for by hand only.
import { effect, signal, untracked } from "../../vendor/preact.js";
import { Problem, askJson, patiently } from "../api.js";
import { origin, say, settings, text, version } from "../state.js";

/** The last measurement, and which text and settings it is about. */
export const measured = signal(/** @type {{ plan: any, version: number, settings: string } | null} */ (null));
export const measuring = signal(/** @type {{ since: number, waiting: number } | null} */ (null));
export const failure = signal("");

let running = new AbortController();

/** Whether the measurement is about the text of now. */
export const isCurrent = () => measured.value !== null && measured.value.version === version.value && measured.value.settings === JSON.stringify(settings.value);

export async function measure() {
  running.abort();
  running = new AbortController();
  const { signal } = running;
  const of = { version: version.peek(), settings: JSON.stringify(settings.peek()) };
  const question = { body: text.peek(), type: origin.peek().type, query: { ...settings.peek(), analyze: "1" }, signal };
  measuring.value = { since: performance.now(), waiting: 0 };
  failure.value = "";
  try {
    const plan = await patiently(() => askJson("v1/explain", question), signal, (waiting) => (measuring.value = { since: performance.now(), waiting }));
    if (signal.aborted) return;
    measured.value = { plan, ...of };
    say("The picture was measured.");
  } catch (error) {
    if (signal.aborted) return;
    failure.value = error instanceof Problem && error.errors.length > 0 ? error.errors[0].detail : error instanceof Error ? error.message : String(error);
  } finally {
    if (!signal.aborted) measuring.value = null;
  }
}

/** Stops a measurement: the service stops the render. */
export function stop() {
  running.abort();
  measuring.value = null;
}

export function start() {
  // Another text is another scene: nobody waits for the figures of the old one.
  effect(() => {
    void version.value, settings.value;
    untracked(() => {
      if (measuring.peek()) stop();
      failure.value = "";
    });
  });
}
