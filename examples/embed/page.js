// What a page does with the events of its pictures.
const told = document.getElementById("told");

document.addEventListener("strahl-progress", ({ target, detail: { state, fraction } }) => {
  if (target.id === "scene") told.textContent = `${state} ${fraction === undefined ? "" : `${Math.round(100 * fraction)} %`}`;
});
document.addEventListener("strahl-done", ({ target, detail: { error, rays } }) => {
  if (target.id !== "scene") return;
  const all = Object.values(rays).reduce((sum, one) => sum + one, 0);
  const proved = error.proved === false ? "nothing is proved" : `at most ${error.proved} of 255 codes off`;
  told.textContent = `${all.toLocaleString("en")} rays; ${proved}`;
});
document.addEventListener("strahl-error", ({ detail: { error } }) => {
  told.textContent = error.message;
});

document.getElementById("form").addEventListener("submit", (event) => {
  event.preventDefault();
  const picture = document.createElement("strahl-picture");
  for (const [name, value] of new FormData(event.target)) if (value) picture.setAttribute(name, value);
  picture.setAttribute("alt", "The picture of the job");
  picture.setAttribute("zoom", "");
  document.getElementById("place").replaceChildren(picture);
});
