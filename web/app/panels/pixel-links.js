// Links between picture and text: what the pointer is over lights its line and its outline, the caret lights its object.
import { computed, effect, untracked } from "../../vendor/preact.js";
import { objectOf } from "../pointers.js";
import { caret, hover, lit, pixel, putLayer, removeLayer, revealed, size, view } from "../state.js";
import { answer, isStale, pointed } from "./pixel-asked.js";
import { objectAt, objects, outlineOf, start as startObjects } from "./pixel-objects.js";
import { overlayHit } from "./pixel-overlay.js";
import { targetOf } from "./pixel-rays.js";

/** The object that is outlined: the one under the pointer, else that of a row of the outline, else that of the caret. */
const outlined = computed(() => {
  const under = hover.value ? objectAt(hover.value) : null;
  if (under !== null) return { pointer: under, strong: true };
  if (lit.value.length > 0) return { pointer: lit.value[0], strong: true };
  const own = objectOf(caret.value);
  return own === null ? null : { pointer: own, strong: false };
});

const lines = computed(() => (outlined.value && objects.value ? outlineOf(objects.value, outlined.value.pointer, size.value) : []));

/** @param {CanvasRenderingContext2D} context @param {import("../state.js").View} of */
function draw(context, of) {
  const isStrong = outlined.peek()?.strong === true;
  context.save();
  context.beginPath();
  for (const line of lines.peek()) {
    line.forEach(([x, y], at) => {
      const [px, py] = [of.left + x * of.scale, of.top + y * of.scale];
      if (at === 0) context.moveTo(px, py);
      else context.lineTo(px, py);
    });
    context.closePath();
  }
  context.fillStyle = isStrong ? "rgb(255 255 255 / 12%)" : "rgb(255 255 255 / 7%)";
  context.fill("evenodd");
  for (const [color, width] of /** @type {[string, number][]} */ ([["rgb(0 0 0 / 60%)", 3.2], ["#ffffff", 1.5]])) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.setLineDash(isStrong || color !== "#ffffff" ? [] : [5, 3]);
    context.stroke();
  }
  context.restore();
}

export function start() {
  startObjects();
  effect(() => {
    const isSeen = lines.value.length > 0;
    untracked(() => (isSeen ? putLayer({ id: "object", order: 10, draw: (context, of) => draw(context, of) }) : removeLayer("object")));
  });
  let byHover = false;
  effect(() => {
    const at = hover.value;
    const pointer = at ? objectAt(at) : null;
    untracked(() => {
      const ray = at ? overlayHit(at, 7 / view.peek().scale) : null;
      if (ray !== null || byHover) pointed.value = ray === null ? "" : String(ray);
      const next = ray === null ? pointer : targetOf(/** @type {import("./pixel-rays.js").Ray} */ (answer.peek()?.grown.tree.rays[ray])).pointer;
      if (next !== null) lit.value = [next];
      else if (byHover) lit.value = [];
      byHover = at !== null;
    });
  });
  // A click jumps to the line of what the pixel shows first. Moving the pixel by keys does not.
  let last = "";
  effect(() => {
    const [at, of, isOld] = [pixel.value, answer.value, isStale.value];
    untracked(() => {
      const key = at ? `${at.x},${at.y}` : "";
      if (key === last || !at || !of || isOld) return;
      last = key;
      const under = hover.peek();
      const [first] = of.grown.tree.rays;
      if (!under || under.x !== at.x || under.y !== at.y || !first?.hit) return;
      revealed.value = { pointer: first.hit.body ?? first.hit.object, count: (revealed.peek()?.count ?? 0) + 1 };
    });
  });
}
