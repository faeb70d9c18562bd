"""Show a folder of pages in the browser, for this machine alone: `python start.py`, in the folder or with its name.

A file of its own, with nothing but the standard library: `build/lite` carries a copy, for a USB stick.
"""

import http.server
import sys
import webbrowser
from functools import partial
from pathlib import Path

#: Always the same, if it is free: a browser keeps a reader's work by address.
PORT = 8642


#: What workers and WebAssembly insist on; some systems call these files something else.
TYPES = {".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm", ".json": "application/json"}


class Handler(http.server.SimpleHTTPRequestHandler):
    """Files with their right types, and no log."""

    def guess_type(self, path):
        return TYPES.get(Path(path).suffix.lower()) or super().guess_type(path)

    def log_message(self, *_):
        pass


def serve(folder, port=0, show=False):
    """Serve `folder` on the loopback address until Ctrl-C, and `show` it in the browser. OSError if `port` is taken."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", port), partial(Handler, directory=folder)) as server:
        address = f"http://127.0.0.1:{server.server_port}/"
        print(f"{address}  (Ctrl-C ends it)", flush=True)
        if show:
            webbrowser.open(address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()


if __name__ == "__main__":
    try:
        serve(Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent).resolve(), PORT, show=True)
    except OSError as error:
        sys.exit(
            f"start.py: port {PORT} is taken ({error.strerror}): perhaps by this book, see http://127.0.0.1:{PORT}/"
        )
