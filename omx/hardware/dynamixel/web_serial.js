// The end of a serial line where a browser's Python runs. What Python waits for is a promise that never fails: it says
// what went wrong, "" for nothing, because a failure is thrown into Python twice, the second time out of nowhere.
(() => {
  const ANSWER_MS = 1000;
  const told = (promise) => promise.then(() => "", (error) => `${error.name}: ${error.message}`);

  // Has a reader of this book, in a page that is open now, connected an arm? What the browser remembers does not count.
  async function connected() {
    if (!navigator.serial) return false;
    const channel = new BroadcastChannel("omx-arm");
    const said = await new Promise((resolve) => {
      channel.onmessage = ({ data }) => { if (data === "connected") resolve(true); };
      setTimeout(resolve, ANSWER_MS, false);
      channel.postMessage("is an arm connected?");
    });
    channel.close();
    return said && (await navigator.serial.getPorts()).length === 1;
  }

  class Line {
    bytes = [];
    lost = "";
    #wake = () => {};
    #closing = false;

    open(baudRate) { return told(this.#open(baudRate)); }

    async #open(baudRate) {
      [this.port] = await navigator.serial.getPorts();
      if (!this.port) throw new DOMException("the port has gone", "NotFoundError");
      await this.port.open({ baudRate, bufferSize: 4096 });
      this.writer = this.port.writable.getWriter();
      this.pumping = this.#pump();
    }

    // A byte that came damaged ends a stream, and the next one begins; a plug that was pulled leaves none.
    async #pump() {
      let why = "the device has been lost";
      while (this.port.readable && !this.#closing) {
        this.reader = this.port.readable.getReader();
        try {
          for (let got = await this.reader.read(); !got.done; got = await this.reader.read()) {
            this.bytes.push(...got.value);
            this.#wake();
          }
        } catch (error) {
          why = error.message;
        } finally {
          this.reader.releaseLock();
        }
      }
      this.lost = why;
      this.#wake();
    }

    // Until something comes, the line is lost, or `ms` have passed.
    wait(ms) {
      return new Promise((resolve) => {
        this.#wake = resolve;
        setTimeout(resolve, ms);
      });
    }

    take(size) { return Uint8Array.from(this.bytes.splice(0, size)); }

    drop() { this.bytes.length = 0; }

    write(data) { return told(this.writer.write(data)); }

    close() { return told(this.#close()); }

    async #close() {
      this.#closing = true;
      await this.reader?.cancel().catch(() => {});
      await this.pumping;
      this.writer?.releaseLock();
      await this.port?.close();
    }
  }

  return { connected, line: () => new Line() };
})();
