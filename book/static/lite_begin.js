// How Python begins in the browser edition, told in words. One file, twice: where Python runs, it stands before Pyodide and
// counts what is fetched; in JupyterLab's page it says how far that is, and shows the chapter's page of the site meanwhile, if
// the site lies around this folder. Nothing here loads or decides anything.
(() => {
  "use strict";
  const NEWS = new BroadcastChannel("omx-python");
  const FILES = {{files}}, BYTES = {{bytes}};
  const OWN = { "pyodide.asm.wasm": "Python itself", "python_stdlib.zip": "its library", "pyodide-lock.json": "its list" };
  const STYLE = `
    #omx-begins { position: fixed; left: 50%; bottom: 34px; transform: translateX(-50%); box-sizing: border-box; z-index: 10001;
      width: min(34rem, calc(100vw - 24px)); padding: 10px 16px 12px; border-radius: 8px; border: 1px solid #8a939c;
      font: 14px/1.45 system-ui, "Segoe UI", "Noto Sans", sans-serif; color: #1b1f24; background: #fff;
      box-shadow: 0 3px 14px rgb(0 0 0 / 25%); }
    #omx-begins[hidden], #omx-page[hidden] { display: none; }
    #omx-begins p { margin: 0; }
    #omx-begins .omx-detail { color: #4a535c; font-variant-numeric: tabular-nums; min-height: 1.45em; }
    #omx-begins progress { display: block; width: 100%; height: 8px; margin: 6px 0; accent-color: #0067a3; }
    #omx-begins button { font: inherit; font-weight: 600; color: #fff; background: #0067a3; border: 0; border-radius: 99px;
      padding: 5px 14px; margin-top: 6px; cursor: pointer; }
    #omx-page { position: fixed; inset: 0; width: 100%; height: 100%; border: 0; z-index: 10000; background: #fff; }
    @media (prefers-color-scheme: dark) {
      #omx-begins { color: #e0e5ea; background: #22282f; } #omx-begins .omx-detail { color: #b3bcc5; }
      #omx-begins progress { accent-color: #79c0ff; } #omx-begins button { color: #14181d; background: #79c0ff; }
    }`;
  if (typeof document === "undefined") inTheWorker();
  else inThePage(document.currentScript.dataset.pages);

  // ---- where Python runs ------------------------------------------------------------------------------------------------

  function inTheWorker() {
    const whose = crypto.getRandomValues(new Uint32Array(1))[0], tell = (news) => NEWS.postMessage({ whose, ...news });
    self.loadPyodide = async (options) => {
      const { fetch } = self;
      let files = 0, bytes = 0;
      self.fetch = async (what, how) => {
        const name = String(what.url ?? what).replace(options.indexURL, "");
        if (name.includes("/")) return fetch(what, how); // not one of these
        try {
          const answer = await fetch(what, how);
          if (!answer.ok) throw new Error(`status ${answer.status}`);
          const counted = new TransformStream({
            transform(chunk, out) { bytes += chunk.byteLength; tell({ name, files, bytes }); out.enqueue(chunk); },
            flush() { files += 1; tell({ name, files, bytes }); },
          });
          return new Response(answer.body.pipeThrough(counted), answer);
        } catch (error) {
          tell({ failed: `${name} could not be had (${error.message})` });
          throw error;
        }
      };
      tell({ files, bytes });
      try {
        importScripts(`${options.indexURL}pyodide.js`); // with the true loadPyodide
        return await self.loadPyodide(options);
      } catch (error) {
        tell({ failed: String(error.message ?? error).trim().split("\n").at(-1) });
        throw error;
      } finally {
        self.fetch = fetch;
      }
    };
  }

  // ---- in the page ------------------------------------------------------------------------------------------------------

  function inThePage(pages) {
    const LOOK_MS = 300, GOODBYE_MS = 6000, LONG_S = 90, NARROW_PX = 760;
    const LAST = "omx-python-took-s", CLOSED = "omx-page-closed";
    const chapter = new URLSearchParams(location.search).get("path") ?? "";
    const [page] = (pages && chapter.match(/^\d\d-[a-z-]+?(?=(-Copy\d+|-brought-back-\d+)?\.ipynb$)/)) || [];
    const box = element("div", { id: "omx-begins" }), frame = element("iframe", { id: "omx-page", title: "The chapter's page" });
    const words = element("p", { role: "status" }), bar = element("progress", { max: BYTES, "aria-label": "Python, as fetched" });
    const detail = element("p", { class: "omx-detail" }), toggle = element("button", { type: "button" });
    let news = null, began = performance.now(), ready = false, roomy = false;

    function element(tag, attributes, ...children) {
      const node = document.createElement(tag);
      for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
      node.append(...children);
      return node;
    }

    const say = (text, more = "") => {
      if (words.textContent !== text) words.textContent = text; // what has not changed is not announced again
      detail.textContent = more;
    };
    const mega = (bytes) => (bytes / 1e6).toFixed(0);
    const usual = () => {
      const last = Number(localStorage.getItem(LAST));
      return last ? `Here it took ${last} s the last time.` : "That takes 10 to 60 seconds, the first time the longest.";
    };
    const status = () => window.jupyterapp?.shell?.currentWidget?.sessionContext?.session?.kernel?.status;

    NEWS.onmessage = ({ data }) => {
      if (news && news.whose !== data.whose && !ready) return; // another window's
      if (ready && ["idle", "busy"].includes(status())) return;
      if (ready || !news) began = performance.now();
      ready = false;
      news = data.failed || !news?.failed ? data : news;
    };

    // The chapter's page lies over JupyterLab until its reader goes on to the notebook.
    function showPage(shown) {
      if (shown && !frame.src) frame.src = `${pages}${page}.html`;
      frame.hidden = !shown;
      toggle.textContent = shown ? "To the notebook" : "Read the chapter's page";
    }

    // On a phone the list of files would leave no room for the chapter; its button stays at the edge.
    function makeRoom({ shell, commands }) {
      roomy = true;
      if (innerWidth >= NARROW_PX) return;
      shell.collapseLeft();
      if (shell.isSideTabBarVisible("right")) commands.execute("application:toggle-side-tabbar", { side: "right" });
    }

    function look() {
      const seconds = Math.round((performance.now() - began) / 1e3), there = document.getElementById("jp-top-panel");
      const known = status();
      if (!roomy && known) makeRoom(window.jupyterapp);
      for (const other of document.body.children) if (other !== box && other !== frame) other.inert = !frame.hidden;
      if (news?.failed) {
        box.hidden = false;
        say(`Python did not start: ${news.failed}. Load this page again; if it stays so, the folder on the server is not whole, ` +
          "or this browser cannot run it: Chrome, Edge and Chromium can.");
      } else if (news && ["idle", "busy"].includes(known)) {
        if (!ready) localStorage.setItem(LAST, seconds);
        ready = true;
        say("Python is ready: run the cells from the top, each with Shift and Enter, or with \u25b6 above.");
        bar.value = BYTES;
        setTimeout(() => { if (ready && frame.hidden) box.hidden = true; }, GOODBYE_MS);
        if (frame.hidden) toggle.hidden = true;
      } else if (news) {
        box.hidden = false;
        toggle.hidden = !page;
        bar.value = news.bytes ?? BYTES;
        const all = news.files >= FILES;
        say(seconds > LONG_S ? "Python takes longer than usual. If nothing comes, load this page again."
          : all ? "Python is here and sets itself up \u2026" : `Python is fetched while you read. ${usual()}`,
          all ? `${seconds} s` : `${news.files} of ${FILES} files, ${mega(news.bytes)} of ${mega(BYTES)} MB` +
            (news.name ? `: ${OWN[news.name] ?? news.name.split("-").slice(0, 2).join(" ")}` : ""));
      } else if (there) {
        box.hidden = frame.hidden; // a window without a chapter
      } else {
        say("JupyterLab is loaded; the chapter comes in a few seconds, and then Python.", `${seconds} s`);
      }
    }

    document.addEventListener("DOMContentLoaded", () => {
      document.head.append(element("style", {}, STYLE));
      box.append(words, bar, detail, toggle);
      document.body.prepend(box, frame);
      toggle.addEventListener("click", () => {
        showPage(frame.hidden);
        if (frame.hidden) localStorage.setItem(CLOSED, "yes");
        if (frame.hidden && ready) box.hidden = true;
      });
      toggle.hidden = !page;
      showPage(Boolean(page) && !localStorage.getItem(CLOSED) && !document.referrer.includes(`/${page}.html`));
      look();
      setInterval(look, LOOK_MS);
    });
  }
})();
