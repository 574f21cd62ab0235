// Links between picture and text: what lights up in the text is outlined in the picture, also the object of the caret, which glows
// where it shows in mirrors and through glass.
import { computed, effect, untracked } from "../../vendor/preact.js";
import { objectOf } from "../pointers.js";
import { caret, draft, hover, lit, pixel, putLayer, removeLayer, revealed, view } from "../state.js";
import { answer, isStale, pointed } from "./pixel-asked.js";
import { objects, outlineOf, start as startObjects } from "./pixel-objects.js";
import { glow, start as startGlow, topOf } from "./pixel-glow.js";
import { overlayHit } from "./pixel-overlay.js";

/** The object that is outlined: the one that lights up in the text, else that of the caret. Not while the camera moves. */
const outlined = computed(() => {
  if (draft.value !== null) return null;
  if (lit.value.length > 0) return { pointer: lit.value[0], strong: true };
  const own = objectOf(caret.value);
  return own === null ? null : { pointer: own, strong: false };
});

/** How much of each pixel comes from the object of the caret, also in mirrors and through glass. */
const glowing = computed(() => {
  const [of, light] = [outlined.value, glow.value];
  return of && !of.strong && light?.pointer === topOf(of.pointer) ? light : null;
});

const lines = computed(() => (outlined.value && objects.value ? outlineOf(objects.value, outlined.value.pointer) : []));

/** @param {CanvasRenderingContext2D} context @param {import("../state.js").View} of */
function draw(context, of) {
  const isStrong = outlined.peek()?.strong === true;
  context.save();
  const light = glowing.peek();
  if (light) {
    const side = light.step * of.scale;
    context.imageSmoothingEnabled = true;
    context.drawImage(light.canvas, of.left, of.top, light.canvas.width * side, light.canvas.height * side);
  }
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
  startGlow();
  effect(() => {
    const isSeen = lines.value.length > 0 || glowing.value !== null;
    void lines.value, glowing.value;
    untracked(() => (isSeen ? putLayer({ id: "object", order: 10, draw: (context, of) => draw(context, of) }) : removeLayer("object")));
  });
  // Over one of the drawn rays its row lights up.
  let byHover = false;
  effect(() => {
    const at = hover.value;
    untracked(() => {
      const ray = at ? overlayHit(at, 7 / view.peek().scale) : null;
      if (ray !== null || byHover) pointed.value = ray === null ? "" : String(ray);
      byHover = ray !== null;
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
      // The editor takes the focus with what it shows; whoever has pressed into the picture goes on there.
      const focused = /** @type {HTMLElement | null} */ (document.activeElement);
      revealed.value = { pointer: first.hit.body ?? first.hit.object, count: (revealed.peek()?.count ?? 0) + 1 };
      setTimeout(() => focused?.focus({ preventScroll: true }));
    });
  });
}
