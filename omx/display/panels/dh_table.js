// A DH table that tells at which of its rows the reader points: `lit`, 1 for the first, 0 for none.
function render({ model, el }) {
  el.innerHTML = model.get("html");
  const light = (row) => () => { model.set("lit", row); model.save_changes(); };
  el.querySelectorAll("tbody tr").forEach((row, i) => {
    row.tabIndex = 0;
    for (const name of ["pointerenter", "focus"]) row.addEventListener(name, light(i + 1));
    for (const name of ["pointerleave", "blur"]) row.addEventListener(name, light(0));
  });
}
export default { render };
