"""From a key on a slider to the drawn scene: what is pressed and what is timed, in a notebook's page."""

import statistics

PANEL = "from omx.display.panels import JointPanel\nJointPanel()"

#: A widget that answers bare messages, and a slider without an arm: what the round trip itself costs.
PROBE = """
import anywidget
import ipywidgets

class Echo(anywidget.AnyWidget):
    _esm = '''
    export default { render({ model, el }) {
      let done;
      model.on("msg:custom", () => done(performance.now()));
      window.omxAnswer = () => new Promise((resolve) => { done = resolve; });
      window.omxAsk = () => model.send({});
      el.textContent = "echo";
    } };
    '''

echo = Echo()
echo.on_msg(lambda widget, content, buffers: widget.send({}))
plain = ipywidgets.FloatSlider(min=-100, max=100, step=1)
plain.observe(lambda change: echo.send({}), "value")
ipywidgets.VBox([echo, plain])
"""

MEASURE = """async (presses) => {
  const scene = document.querySelector(".omx-scene[data-ready] iframe").contentWindow.omxScene;
  const handles = [...document.querySelectorAll(".noUi-handle")];
  const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const press = (handle, k) => handle.dispatchEvent(
    new KeyboardEvent("keydown", { key: k % 2 ? "ArrowLeft" : "ArrowRight", bubbles: true, cancelable: true }));
  const drawn = () => new Promise((resolve) => {
    const node = scene.viewer.scene_tree.find(["meshcat", "arm", "4"]).object;
    const pose = () => node.position.toArray().concat(node.quaternion.toArray()).join();
    const before = pose(), render = scene.viewer.render;
    scene.viewer.render = function () {
      render.call(this);
      if (pose() === before) return;
      scene.viewer.render = render;
      resolve(performance.now());
    };
  });
  const timed = async (answer, act) => {
    const start = performance.now();
    act();
    const late = new Promise((_, refuse) => setTimeout(() => refuse(new Error(`no answer to ${act}`)), 60e3));
    const time = (await Promise.race([answer, late])) - start;
    await pause(100);
    return time;
  };
  const out = { message: [], slider: [], arm: [] };
  for (let k = 0; k < presses; k++) {
    out.message.push(await timed(omxAnswer(), omxAsk));
    out.slider.push(await timed(omxAnswer(), () => press(handles.at(-1), k)));
    out.arm.push(await timed(drawn(), () => press(handles[0], k)));
  }
  return out;
}"""

#: Presses that come first and are not counted.
WARM = 5


def latencies(page, presses=45):
    """Times (ms) of the bare round trip, `message`, of a plain `slider`, and from a key to the drawn `arm`.

    `page` shows a notebook of the two cells `PANEL` and `PROBE`, which have been run.
    """
    assert page.panel() is not None
    page.page.wait_for_function("window.omxAsk && document.querySelector('.omx-scene[data-ready] iframe')")
    page.settle()
    times = page.page.evaluate(MEASURE, presses + WARM)
    return {name: values[WARM:] for name, values in times.items()}


def summary(times):
    """The median and the 95th percentile, in words."""
    return f"median {statistics.median(times):.0f} ms, p95 {percentile(times):.0f} ms"


def percentile(times):
    """The 95th."""
    return sorted(times)[int(0.95 * len(times))]
