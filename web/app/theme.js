// Light, dark, or as the system has it. The choice is kept in this browser; it is no secret.
import { effect, signal } from "../vendor/preact.js";

/** @typedef {"system" | "light" | "dark"} Theme */

const NAME = "strahl-theme";
/** @returns {Theme} */
function stored() {
  try {
    const found = localStorage.getItem(NAME);
    return found === "light" || found === "dark" ? found : "system";
  } catch {
    return "system";
  }
}

export const theme = signal(stored());

/** @type {Record<Theme, Theme>} */
const NEXT = { system: "dark", dark: "light", light: "system" };

export const turnTheme = () => (theme.value = NEXT[theme.peek()]);

effect(() => {
  if (theme.value === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme.value;
  try {
    localStorage.setItem(NAME, theme.value);
  } catch {
    // Without storage the choice lasts as long as the page.
  }
});
