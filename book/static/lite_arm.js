// "Connect the arm": the reader's own act, without which no Python in this page gets a port. One arm at a time.
(() => {
  if (!navigator.serial) return;
  const FILTERS = {{adapters}};
  const WORDS = "Connect the arm";
  const REFUSED = { // by the error's name; whoever has chosen nothing is told nothing
    NotFoundError: "",
    SecurityError: "This page may not ask for an adapter: the site's administrator, or its place inside another page, forbids it.",
  };
  const button = document.createElement("button"), said = document.createElement("span");
  let connected = null;

  function show() {
    button.textContent = connected ? "Arm connected, to be read" : WORDS;
    button.title = connected
      ? 'Robot("auto") reads it. Its motors stay off, and nothing moves. Press to choose another one.'
      : "Choose the adapter of a real arm. It is only read here: its motors stay off, and nothing moves.";
  }

  async function connect() {
    try {
      connected = await navigator.serial.requestPort({ filters: FILTERS });
    } catch (error) {
      said.textContent = REFUSED[error.name] ?? `The browser could not ask for an adapter (${error.message}): load this page again.`;
      return;
    }
    said.textContent = "";
    for (const port of await navigator.serial.getPorts()) if (port !== connected) await port.forget();
    show();
  }

  const channel = new BroadcastChannel("omx-arm");
  channel.onmessage = ({ data }) => {
    if (data === "is an arm connected?" && connected) channel.postMessage("connected");
  };
  button.style = "flex: none; margin: 1px 8px 1px auto; font: 12px system-ui, sans-serif";
  said.style = "flex: none; align-self: center; margin-left: 8px; font: 12px system-ui, sans-serif";
  said.setAttribute("role", "status");
  button.addEventListener("click", connect);
  show();
  const placing = setInterval(() => {  // JupyterLab makes its bar of menus when it is ready
    const bar = document.getElementById("jp-top-panel");
    if (!bar) return;
    clearInterval(placing);
    bar.append(said, button);
  }, 200);
})();
