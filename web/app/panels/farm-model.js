// What the farm does, from two of its answers: rates, sentences, rows. Pure.

/**
 * @typedef {object} Node
 * @property {string} id @property {string} name @property {string} version @property {boolean} same_renderer
 * @property {"ready" | "draining" | "excluded"} state @property {string | null} reason
 * @property {number} slots @property {number} busy @property {number} started_s @property {number} pieces @property {number} tiles @property {number} failures
 *
 * @typedef {object} Farm
 * @property {boolean} connected @property {number} slots @property {number} busy
 * @property {{ ready: number, draining: number, excluded: number }} nodes
 * @property {{ hi: number, norm: number, bulk: number }} backlog_seconds
 * @property {{ pieces: number, tiles: number, failures: number }} done
 * @property {{ sent_again: number, rendered_twice: number, dead_letters: number, determinism_alarms: number, queue_full: number, broker_errors: number }} trouble
 * @property {Node[] | null} each
 */

/** Tiles a second between two answers, or null before there are two. @param {{ at: number, farm: Farm } | null} before @param {{ at: number, farm: Farm }} now */
export function tilesPerSecond(before, now) {
  const seconds = before === null ? 0 : (now.at - before.at) / 1000;
  // A node that went takes its count along.
  return before === null || seconds <= 0 ? null : Math.max(0, now.farm.done.tiles - before.farm.done.tiles) / seconds;
}

/** @param {number} count @param {string} one @param {string} many */
const counted = (count, one, many) => `${count} ${count === 1 ? one : many}`;

/** What goes on, in a sentence. @param {Farm} farm */
export function sentenceOf({ nodes, slots, busy }) {
  if (nodes.ready === 0) return "No node takes work.";
  return `${busy} of ${counted(slots, "slot", "slots")} ${busy === 1 ? "is" : "are"} busy, on ${counted(nodes.ready, "node", "nodes")}.`;
}

/** What somebody should look after, the worst first. @param {Farm} farm @returns {string[]} */
export function alarmsOf({ connected, nodes, backlog_seconds: backlog, trouble }) {
  const waits = backlog.hi + backlog.norm + backlog.bulk > 0;
  return [
    connected ? "" : "The service has lost the broker. Jobs wait until it is back.",
    trouble.determinism_alarms > 0 ? `Nodes have made different pixels of ${counted(trouble.determinism_alarms, "tile", "tiles")}: a machine or a build is wrong.` : "",
    nodes.ready === 0 && waits ? "Work waits, and no node takes it." : "",
    nodes.excluded > 0 ? `${counted(nodes.excluded, "node does", "nodes do")} not trust itself and takes no work.` : "",
    trouble.dead_letters > 0 ? `${counted(trouble.dead_letters, "piece was", "pieces were")} given up since the start.` : "",
  ].filter((alarm) => alarm !== "");
}

/** Seconds in the largest unit that is at least one. @param {number} seconds */
export function age(seconds) {
  for (const [unit, name] of /** @type {[number, string][]} */ ([[86_400, "d"], [3_600, "h"], [60, "min"]])) if (seconds >= unit) return `${Math.floor(seconds / unit)} ${name}`;
  return `${Math.round(seconds)} s`;
}
