// A button that counts `press` up when it is pressed by pointer, space bar or enter key, and `beat`, ten times a second,
// while it is held down.
function render({ model, el }) {
  const button = document.createElement("button");
  button.className = "jupyter-widgets jupyter-button widget-button" + (model.get("plain") ? "" : " mod-primary");
  button.style.cssText = "width:auto;padding:0 18px;touch-action:none;user-select:none";
  button.textContent = model.get("label");
  let timer = null;
  const send = (held) => {
    model.set({ held, beat: model.get("beat") + 1 });
    model.save_changes();
  };
  const press = () => { model.set("press", model.get("press") + 1); send(true); };
  const start = () => { if (timer === null) { press(); timer = setInterval(() => send(true), 100); } };
  const end = () => { if (timer !== null) { clearInterval(timer); timer = null; send(false); } };
  const key = (event) => event.key === " " || event.key === "Enter";
  button.addEventListener("pointerdown", (event) => { button.setPointerCapture(event.pointerId); start(); });
  const ends = ["pointerup", "pointercancel", "lostpointercapture", "blur"];
  for (const name of ends) button.addEventListener(name, end);
  button.addEventListener("keydown", (event) => { if (key(event)) { event.preventDefault(); start(); } });
  button.addEventListener("keyup", (event) => { if (key(event)) end(); });
  const hidden = () => { if (document.hidden) end(); };
  document.addEventListener("visibilitychange", hidden);
  el.appendChild(button);
  return () => { end(); document.removeEventListener("visibilitychange", hidden); };
}
export default { render };
