// The bar at the top: the scene's name, where to begin, undo, live or not, sharing, keys, theme, help.
import { html, useSignal } from "../vendor/preact.js";
import { dialog, editAt, key, live, panelsOpen, scene, steps, title } from "./state.js";
import { theme, turnTheme } from "./theme.js";
import { Button } from "./ui.js";

/** The name of the scene; changing it changes the text. */
function Name() {
  const typed = useSignal(/** @type {string | null} */ (null));
  const name = title.value;
  const take = () => {
    if (typed.value !== null && typed.value !== name) editAt("/name", typed.value);
    typed.value = null;
  };
  return html`<input class="name" aria-label="Name of the scene" maxlength="256" placeholder="no name" value=${typed.value ?? name} disabled=${!scene.value}
    onInput=${(/** @type {any} */ event) => (typed.value = event.currentTarget.value)} onBlur=${take}
    onKeyDown=${(/** @type {any} */ event) => event.key === "Enter" && event.currentTarget.blur()} />`;
}

export function Bar() {
  const open = (/** @type {string} */ name) => () => (dialog.value = name);
  const { undo, redo } = steps.value;
  return html`<header class="bar">
    <h1 class="brand"><svg viewBox="0 0 32 32" aria-hidden="true"><path d="M4 7 16 20 28 7" /><path class="through" d="M16 20v9" /><path class="ground" d="M4 20.5h24" /></svg>strahl</h1>
    <${Name} />
    <div class="bar-group">
      <${Button} icon="images" kind="quiet" press=${open("examples")} title="Scenes to begin with"><span class="bar-word">Examples</span><//>
      <${Button} label="Undo" icon="undo" kind="quiet" keys="Control+Z" disabled=${!undo} press=${() => undo?.()} />
      <${Button} label="Redo" icon="redo" kind="quiet" keys="Control+Shift+Z" disabled=${!redo} press=${() => redo?.()} />
      <${Button} icon=${live.value ? "pause" : "play"} kind="quiet" keys="P" title=${live.value ? "Edits render by themselves; press to pause" : "Edits wait for Ctrl-Enter; press to go live"}
        press=${() => (live.value = !live.value)}><span class="bar-word">${live.value ? "Pause" : "Live"}</span><//>
    </div>
    <div class="bar-group bar-end">
      <${Button} icon="share" kind="main" press=${open("share")}><span class="bar-word">Share</span><//>
      <${Button} label="All commands" icon="search" kind="quiet" keys="Control+K" press=${open("commands")} />
      <${Button} label=${key.value === "" ? "Key for the service" : "Key for the service: set"} icon=${key.value === "" ? "unlock" : "lock"} kind="quiet" press=${open("key")} />
      <${Button} label=${`Theme: ${theme.value}`} icon=${theme.value === "dark" ? "moon" : "sun"} kind="quiet" press=${turnTheme} />
      <${Button} label="Help" icon="help" kind="quiet" keys="?" press=${open("help")} />
      <${Button} label="Panels" icon="panel" kind="quiet" pressed=${panelsOpen.value} press=${() => (panelsOpen.value = !panelsOpen.value)} />
    </div>
  </header>`;
}
