"""A chapter opened in the built JupyterLite, in a browser that reaches nothing but this machine."""

import json
from contextlib import contextmanager

from book.chapters import normalise
from tests.browser.conftest import FLAGS

PATIENCE_MS = 300_000

IDLE = """() => {
  const panel = window.jupyterapp?.shell.currentWidget;
  return panel?.sessionContext?.session?.kernel?.status === "idle" && panel.content.model.cells.length > 3;
}"""
SHOWN = "jupyterapp.shell.currentWidget.content.model.toJSON()"
RUN_ALL = f"""async () => {{
  await jupyterapp.commands.execute("notebook:run-all-cells");
  return {SHOWN};
}}"""


@contextmanager
def chapter(playwright, chromium, home, name):
    """The tab with the chapter, its kernel idle; `outside` lists what it asked of others, `complaints` its errors."""
    browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
    context = browser.new_context(viewport={"width": 1300, "height": 1000})
    tab = context.new_page()
    tab.set_default_timeout(PATIENCE_MS)
    tab.outside, tab.complaints = [], []
    local = (home, "data:", "blob:", "about:")
    context.on("request", lambda request: request.url.startswith(local) or tab.outside.append(request.url))
    tab.on("pageerror", lambda error: tab.complaints.append(str(error)))
    tab.on("console", lambda message: message.type == "error" and tab.complaints.append(message.text))
    tab.goto(f"{home}lab/index.html?path={name}")
    tab.wait_for_function(IDLE, polling=250)
    tab.ready_s = tab.evaluate("performance.now() / 1e3")
    try:
        yield tab
    finally:
        browser.close()


def run_all(tab):
    """Run every cell; the cells with their outputs, and how long it took, s."""
    cells = tab.evaluate(RUN_ALL)["cells"]
    return cells, tab.evaluate("performance.now() / 1e3") - tab.ready_s


def texts(cell):
    """What of a cell's outputs is stored, without the numbers of cells."""
    kept = normalise.clean_outputs(json.loads(json.dumps(cell["outputs"])))
    return [{key: value for key, value in output.items() if key != "execution_count"} for output in kept]


def python(tab, code):
    """Run `code` in the tab's Python; what it prints. An error of it is one here."""
    said, failed = tab.evaluate(
        """async (code) => {
          const kernel = jupyterapp.shell.currentWidget.sessionContext.session.kernel;
          const asked = kernel.requestExecute({ code });
          let said = "", failed = "";
          asked.onIOPub = ({ header, content }) => {
            if (header.msg_type === "stream") said += content.text;
            if (header.msg_type === "error") failed = content.traceback.join("\\n");
          };
          await asked.done;
          return [said, failed];
        }""",
        code,
    )
    assert not failed, said + failed
    return said
