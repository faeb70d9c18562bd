"""`python run.py lab [chapter]`: JupyterLab on the reader's own copies, or with --author on the chapters themselves.

It listens on the loopback address, keeps what it saves clean (`saving`), and ends its start with one line: where the
book is, and how to stop.
"""

import os
import sys
from pathlib import Path
from urllib.parse import quote

from book.reader import folder
from book.setup import names
from book.setup.file_lock import one_at_a_time
from book.setup.paths import ENVIRONMENT, NOTEBOOKS, ROOT, WINDOWS, WORK, Stop, in_a_sentence

#: JupyterLab's short options that say the same as one of ours.
LONG = {
    "--ip": "--ServerApp.ip",
    "--notebook-dir": "--ServerApp.root_dir",
    "--ServerApp.notebook_dir": "--ServerApp.root_dir",
    "--transport": "--KernelManager.transport",
    "--log-level": "--Application.log_level",
    "--debug": "--Application.log_level=DEBUG",
}
#: What JupyterLab says of every copy that has not run yet; nothing in ours needs that trust, and it alarms readers.
UNTRUSTED = "is not trusted"
SOCKET_PATH = 108 - 58  # bytes that a Unix socket's path holds, less what Jupyter puts behind the runtime folder


def options(arguments):
    """JupyterLab's own options: the reader's, and ours where the reader gives none."""
    given = [longer(argument) for argument in arguments]
    ours = [
        "--ServerApp.ip=127.0.0.1",
        f"--ServerApp.root_dir={ROOT}",
        "--Application.log_level=WARN",
        "--LabApp.extension_manager=readonly",  # the other one asks the internet
        "--LanguageServerManager.autodetect=False",  # else the log ends with a list of servers that nobody misses
        "--FileContentsManager.pre_save_hook=book.reader.saving.before_saving",
    ]
    if sys.platform == "linux" and len(os.fsencode(runtime_folder())) <= SOCKET_PATH:
        ours.append("--KernelManager.transport=ipc")  # kernels' TCP ports collide now and then
    if not WINDOWS and os.geteuid() == 0:
        ours.append("--allow-root")  # in a container; JupyterLab refuses root otherwise
    names_given = {argument.split("=")[0] for argument in given}  # JupyterLab takes each option once
    return [option for option in ours if option.split("=")[0] not in names_given] + given


def longer(argument):
    """An option in its long form."""
    name, *value = argument.split("=", 1)
    return "=".join([LONG.get(name, name), *value])


def runtime_folder():
    """Where Jupyter keeps its sockets on Linux."""
    share = os.environ.get("XDG_DATA_HOME") or os.path.expanduser("~/.local/share")
    data = os.environ.get("JUPYTER_DATA_DIR") or os.path.join(share, "jupyter")
    return os.environ.get("JUPYTER_RUNTIME_DIR") or os.path.join(data, "runtime")


def command_line(arguments):
    """(the notebook to open, JupyterLab's options) for the arguments of `run.py lab`. Raises `Stop`."""
    is_author = "--author" in arguments
    arguments = [argument for argument in arguments if argument != "--author"]
    name = arguments.pop(0) if arguments and not arguments[0].startswith("-") else ""
    where = NOTEBOOKS if is_author else WORK
    notebook = names.chapter(name, where) if name else where / names.chapters()[0].name
    taken = options(arguments)
    root = next(option.split("=", 1)[1] for option in taken if option.startswith("--ServerApp.root_dir="))
    root = Path(os.path.expanduser(root)).resolve()
    if root in notebook.resolve().parents:
        way = quote(notebook.resolve().relative_to(root).as_posix())
        return notebook, [*taken, f"--LabApp.default_url=/lab/tree/{way}"]
    if name:
        raise Stop(
            f"{notebook} is not below {root}, which is all that this JupyterLab shows: copy it into "
            f"{WORK}, or add --notebook-dir={notebook.parent}"
        )
    return notebook, taken


def can_keep_files(folder):
    """Raise `Stop` where Jupyter cannot keep the files of its kernels in this folder."""
    try:
        os.makedirs(folder, 0o700, exist_ok=True)
    except OSError as error:
        raise Stop(
            f"Jupyter cannot keep its files in {folder} ({error.strerror}): let JUPYTER_RUNTIME_DIR name a folder of "
            "yours."
        ) from error


def must_be_a_port(number):
    """JupyterLab takes any number, and names an address then that nobody can open."""
    if not 0 <= number <= 65535:
        raise Stop(f"{number} is no port: they are numbered up to 65535.")


def start(arguments):
    """Run JupyterLab until it is stopped."""
    from jupyter_core.paths import jupyter_runtime_dir
    from jupyterlab.labapp import LabApp

    can_keep_files(jupyter_runtime_dir())
    server = LabApp.initialize_server(argv=arguments)
    must_be_a_port(server.port)
    url = server.display_url.splitlines()[0]
    for handler in server.log.handlers:
        handler.addFilter(lambda record: UNTRUSTED not in str(record.msg))
    server.web_app.settings.setdefault("ws_ping_timeout", 30_000)  # ms; tornado warns of the default, three intervals
    server.identity_provider.token_generated = False  # else the server prints its addresses a second time
    server.io_loop.add_callback(lambda: print(f"The book: {url} (to stop it: Ctrl-C here, twice)", flush=True))
    server.start()


@in_a_sentence
def main(arguments):
    if set(arguments) & {"--version", "--help-all", "--generate-config"} or arguments[:1] == ["list"]:
        from jupyterlab.labapp import main as lab

        return lab(argv=arguments)
    with one_at_a_time(ENVIRONMENT):  # another terminal may do the same
        waiting = [] if "--author" in arguments else folder.prepare()
    _, taken = command_line(arguments)
    if waiting:
        numbers = ", ".join(name[:2] for name in waiting)
        print(f"New editions of {numbers} are here: `python run.py update` brings them in and keeps your answers.")
    return start(taken)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
