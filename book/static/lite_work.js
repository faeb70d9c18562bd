// A reader's work in JupyterLite, kept as one file and brought back: its files lie in this browser's IndexedDB.
(() => {
  const NAME = "JupyterLite Storage - " + new URL(".", location.href).pathname, STORE = "files";
  const FORMAT = "openmanipulator-x-work";
  const said = (text) => { document.getElementById("said").textContent = text; };
  const done = (request) => new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });

  async function open(version) {
    const request = indexedDB.open(NAME, version);
    request.onupgradeneeded = () => {
      if (!request.result.objectStoreNames.contains(STORE)) request.result.createObjectStore(STORE);
    };
    request.onblocked = () => said("Close the other tabs of this book, then try again.");
    const db = await done(request);
    if (db.objectStoreNames.contains(STORE)) return db;
    db.close();
    return open(db.version + 1);
  }

  async function withFiles(mode, work) {
    const db = await open();
    try {
      return await work(db.transaction(STORE, mode).objectStore(STORE));
    } finally {
      db.close();
    }
  }

  async function all() {
    return withFiles("readonly", async (files) => {
      const [keys, values] = await Promise.all([done(files.getAllKeys()), done(files.getAll())]);
      return Object.fromEntries(keys.map((key, i) => [key, values[i]]));
    });
  }

  async function keep() {
    const files = await all(), count = Object.keys(files).length;
    if (!count) return said("There is nothing to keep yet: save a chapter first.");
    const day = new Date().toISOString().slice(0, 10);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([JSON.stringify({ format: FORMAT, files })], { type: "application/json" }));
    link.download = `my-work-${day}.json`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
    said(`${count} ${count === 1 ? "file is" : "files are"} in ${link.download}.`);
  }

  const beside = (path, taken) => {
    const [, stem, end] = path.match(/^(.*?)(\.[^./]*)?$/);
    let number = 1;
    while (`${stem}-brought-back-${number}${end ?? ""}` in taken) number += 1;
    return `${stem}-brought-back-${number}${end ?? ""}`;
  };

  async function restore(file) {
    let kept;
    try {
      kept = JSON.parse(await file.text());
    } catch {
      kept = null;
    }
    if (kept?.format !== FORMAT || typeof kept.files !== "object") {
      return said(`${file.name} is not a file that this page has kept.`);
    }
    const here = await all();
    let came = 0, aside = 0;
    await withFiles("readwrite", async (files) => {
      for (const [path, value] of Object.entries(kept.files)) {
        const there = here[path];
        if (there && JSON.stringify(there.content) === JSON.stringify(value.content)) continue;
        const target = there ? beside(path, here) : path;
        here[target] = { ...value, path: target, name: target.split("/").pop() };
        came += 1;
        aside += there ? 1 : 0;
        await done(files.put(here[target], target));
      }
    });
    const same = Object.keys(kept.files).length - came;
    said(`Brought back: ${came}. Here already, the same: ${same}.` +
         (aside ? ` Beside yours, because it differs, as "...-brought-back-1": ${aside}.` : ""));
  }

  const told = (work) => work.catch((error) => said(`That did not work: ${error.message ?? error}.`));
  document.getElementById("keep").addEventListener("click", () => told(keep()));
  document.getElementById("restore").addEventListener("change", (event) => {
    const [file] = event.target.files;
    if (file) told(restore(file));
    event.target.value = "";
  });
})();
