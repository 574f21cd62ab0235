// The panels in the order of their tabs. Their modules come once the first picture is there, or when one is opened: nobody waits for
// them before.
import { effect, html, signal, untracked } from "../../vendor/preact.js";
import { panel, say, shown } from "../state.js";

/**
 * The module of a panel.
 * @typedef {object} Module
 * @property {() => import("../../vendor/preact.js").ComponentChild} Panel
 * @property {() => void} [start] called once, for effects that go on while the panel is closed
 * @property {() => import("../../vendor/preact.js").ComponentChild} [Overlay] over the viewport, in its coordinates
 */
/** @typedef {{ id: string, title: string, start: () => void, Panel: Module["Panel"], Overlay: Module["Panel"] }} Panel */

/** @param {string} id @param {string} title @param {() => Promise<Module>} load @returns {Panel} */
function later(id, title, load) {
  const module = signal(/** @type {Module | null} */ (null));
  let isComing = false;
  const come = async () => {
    if (isComing) return;
    isComing = true;
    try {
      const found = await load();
      found.start?.();
      module.value = found;
    } catch {
      // The service is away, or has another version by now.
      isComing = false;
      if (panel.peek() === id) say(`${title} cannot be loaded now.`, { label: "Try again", run: come });
    }
  };
  return {
    id,
    title,
    start: () => void effect(() => void ((panel.value === id || shown.value?.rung === 2) && untracked(come))),
    Panel: () => (module.value ? html`<${module.value.Panel} />` : null),
    Overlay: () => (module.value?.Overlay ? html`<${module.value.Overlay} />` : null),
  };
}

export const panels = [
  later("plan", "Plan", () => import("./plan.js")),
  later("accuracy", "Accuracy", () => import("./accuracy.js")),
  later("compare", "Compare", () => import("./compare.js")),
  later("maps", "Maps", () => import("./maps.js")),
  later("jobs", "Jobs", () => import("./jobs.js")),
];
