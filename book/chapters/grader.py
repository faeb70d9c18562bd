"""Runs one student's answers and the checks that belong to them, in a process of its own: `grading` starts it.

It knows neither `book` nor the chapters. The job comes through stdin; results go to a file, line by line, each with
the job's nonce. The order: the chapter's own cells (their names are kept), then the student's, then every check on
the chapter's names with the student's answers put in. What lies in modules is put back before each check, and
compared after it. What this process may not do is refused by an audit hook, which nobody can take away again.
"""

import ast
import builtins
import contextlib
import importlib
import io
import json
import os
import sys
import types

LONG = 300
#: Audit events that no answer needs: other processes, other people's frames and objects, code in disguise.
REFUSED = (
    "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.forkpty", "os.kill",
    "os.killpg", "pty.spawn", "ctypes.dlopen", "ctypes.dlsym", "ctypes.call_function", "ctypes.addressof",
    "ctypes.string_at", "sys._current_frames", "sys.settrace", "sys.setprofile", "gc.get_objects",
    "gc.get_referrers", "gc.get_referents", "code.__new__", "function.__new__", "signal.pthread_kill",
)  # fmt: skip
PATHS = ("open", "os.listdir", "os.scandir", "os.chdir", "os.rename", "os.remove", "os.link", "os.symlink",
         "os.truncate", "os.mkdir", "os.rmdir", "shutil.copyfile", "shutil.copytree", "shutil.move")  # fmt: skip
HIDDEN_ATTRIBUTES = ("tb_frame", "gi_frame", "cr_frame", "ag_frame", "__code__", "f_locals", "f_globals")


class Refusal(PermissionError):
    """An answer tried what answers may not."""


def main():
    job = json.loads(sys.stdin.buffer.read())
    sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115 - input() finds the end at once
    sys.path[:] = [job["library"], *job["packages"], *(path for path in sys.path if path)]
    say = reporter(job.pop("results"), job.pop("nonce"))
    limit_memory()
    for name in ("__main__", "mpl_toolkits"):
        sys.modules.pop(name, None)
    grade(job, say)


def reporter(path, nonce):
    """A function that adds a line to the results, known to the grader alone; nobody else may open that file."""
    results = os.open(path, os.O_WRONLY | os.O_APPEND)

    def say(**what):
        os.write(results, json.dumps({"nonce": nonce, **what}).encode() + b"\n")

    return say


def limit_memory(bytes_at_most=8 * 2**30):
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (bytes_at_most, bytes_at_most))


def grade(job, say):
    tried = []
    fresh, before = the_chapter(job["chapter"], say)
    keeper = Keeper()
    watch(job["forbidden"], tried)
    answers = the_student(job, fresh, keeper, say)
    for exercise in job["exercises"]:
        looked_at(exercise, dict(before[exercise["check"]]), answers, keeper, tried, job["skip"], say)
    say(done=True)


# ---- the chapter's own cells ---------------------------------------------------------------------------------


def the_chapter(cells, say):
    """({cell: names that it bound}, {check: names before it}) of the chapter, TODOs left in."""
    names, fresh, before = namespace("chapter"), {}, {}
    for cell in cells:
        say(at=cell["id"], of="chapter")
        if cell["role"] == "check":
            before[cell["id"]] = dict(names)
            continue
        old = dict(names)
        with contextlib.suppress(Exception):
            run(cell["source"], names, f"<chapter {cell['id']}>")
        fresh[cell["id"]] = {k: v for k, v in names.items() if k not in old or old[k] is not v}
    return fresh, before


def namespace(name):
    """The names of a fresh notebook; the module that holds them is what the cells know as __main__."""
    module = types.ModuleType("__main__", name)
    module.__dict__.update(display=lambda *_, **__: None, get_ipython=lambda: Magics())
    sys.modules["__main__"] = module
    return module.__dict__


class Magics:
    """IPython's magics do nothing here."""

    def __getattr__(self, name):
        return lambda *_, **__: None


def run(source, names, filename):
    """Run a cell's source; magics are left out."""
    try:
        tree = ast.parse(source, filename)
    except SyntaxError:
        from IPython.core.inputtransformer2 import TransformerManager

        tree = ast.parse(TransformerManager().transform_cell(source), filename)
    exec(compile(tree, filename, "exec"), names)


# ---- the student's cells --------------------------------------------------------------------------------------


def the_student(job, fresh, keeper, say):
    """{name: value} of the answers, each as it was when its check was reached. Cells in `skip` are left out."""
    names, answers = namespace("student"), {}
    given = {cell["id"]: cell["source"] for cell in job["chapter"] if cell["role"] == "given"}
    wanted = {exercise["check"]: exercise["answers"] for exercise in job["exercises"]}
    for cell in job["student"]:
        if cell["id"] in wanted:
            answers.update(taken(names, wanted.pop(cell["id"])))
        elif given.get(cell["id"]) == cell["source"]:
            names.update(fresh[cell["id"]])  # the chapter's own cell, which has run already
        elif cell["id"] not in job["skip"]:
            say(at=cell["id"], of="student")
            stopped = None
            try:
                run(cell["source"], names, f"<answer {cell['id']}>")
            except BaseException as error:  # whatever a student's cell does, the next one is looked at
                stopped = error
            if found := keeper.put_back():
                say(tampered=cell["id"], said=found)
            if stopped is not None:
                say(stopped=cell["id"], said=told(stopped))
    for left in wanted.values():
        answers.update(taken(names, left))
    return answers


def taken(names, wanted):
    return {name: names.get(name, ...) for name in wanted}


# ---- the checks ----------------------------------------------------------------------------------------------


def looked_at(exercise, names, answers, keeper, tried, skip, say):
    """Run the statements of a check one by one; each that checks something is a criterion."""
    names.update(answers)
    for name in exercise["answers"]:
        if disguised(answers[name]):
            say(tampered=exercise["check"], said=f"{name} is an object of a class of its own, which answers for itself")
            names[name] = ...
    broken = ""
    for number, (source, counts) in enumerate(exercise["statements"]):
        place = f"{exercise['check']}/{number}"
        keeper.put_back()
        said = "it does not come to an end" if place in skip else ""
        if not said:
            say(at=place, of="check")
            said, printed = attempt(source, names, keeper)
        if found := keeper.found:
            said = "something that the check relies on was replaced"
            say(tampered=exercise["check"], said=found)
        if counts:
            also = f" (before it: {broken})" if said.startswith("NameError") and broken else ""
            say(exercise=exercise["name"], number=number, passed=not said, said=(said + also) or printed)
        elif said:
            broken = said
    while tried:
        say(tampered=exercise["check"], said=tried.pop())


def attempt(source, names, keeper):
    """(what went wrong or '', what was printed) of one statement; afterwards all is put back."""
    out, failed = io.StringIO(), None
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
            exec(compile(source, "<check>", "exec"), names)
    except BaseException as error:  # SystemExit and KeyboardInterrupt of an answer, too
        failed = error
    keeper.put_back()
    return ("", " ".join(out.getvalue().split())[-LONG:]) if failed is None else (told(failed), "")


def told(error):
    """A student's sentence on an error: the check's own, or the error's name and text."""
    if type(error).__name__ == "Wrong":
        return str(error)[:LONG]
    explained = sys.modules.get("omx.check.notebook")
    if explained and isinstance(error, Exception):
        with contextlib.suppress(Exception):
            return explained.explained(error)[:LONG]
    return f"{type(error).__name__}: {' '.join(str(error).split())}"[:LONG].rstrip(": ")


def disguised(value):
    """Is this a value of a class that the student wrote, which may answer every comparison as it likes?"""
    return not isinstance(value, (types.FunctionType, type)) and type(value).__module__ == "__main__"


# ---- what must stay as it is -----------------------------------------------------------------------------------


class Keeper:
    """Remembers what the modules hold that checks rely on, says what was changed, and puts it back."""

    def __init__(self):
        names = [n for n in sys.modules if n.split(".")[0] == "omx" or n in ("numpy", "numpy.linalg", "math", "sympy")]
        kept = [(name, vars(sys.modules[name])) for name in sorted(names)] + [("builtins", vars(builtins))]
        self._dicts = [(n, d, {k: v for k, v in d.items() if not k.startswith("__")}) for n, d in kept]
        own = [v for _, d, _ in self._dicts for v in d.values() if str(getattr(v, "__module__", "")).startswith("omx")]
        self._codes = {v: v.__code__ for v in own if isinstance(v, types.FunctionType)}
        self._classes = {v: dict(vars(v)) for v in own if isinstance(v, type)}
        self._modules = {name: sys.modules[name] for name in names}
        self.found = ""

    def put_back(self):
        """Put back what is not as it was; what that is, in words, or ''. Builtins come first: all else needs them."""
        self.found = self._changed()
        self._restore()
        return self.found

    def _changed(self):
        for module, d, was in reversed(self._dicts):
            for name, value in was.items():
                if d.get(name, self) is not value:
                    return f"{module}.{name} was replaced"
        for function, code in self._codes.items():
            if function.__code__ is not code:
                return f"the code of {function.__name__} was replaced"
        for kind, was in self._classes.items():
            if any(vars(kind).get(name, self) is not value for name, value in was.items() if not name.startswith("__")):
                return f"a method of {kind.__name__} was replaced"
        replaced = [name for name, module in self._modules.items() if sys.modules.get(name) is not module]
        return f"the module {replaced[0]} was replaced" if replaced else ""

    def _restore(self):
        for _, d, was in reversed(self._dicts):
            d.update(was)
        for function, code in self._codes.items():
            if function.__code__ is not code:
                function.__code__ = code
        for kind, was in self._classes.items():
            for name, value in was.items():
                if not name.startswith("__") and vars(kind).get(name, self) is not value:
                    setattr(kind, name, value)
        sys.modules.update(self._modules)


def watch(forbidden, tried, student_files=("<answer", "<string")):
    """Refuse from now on what answers may not do; what was tried is added to `tried`.

    All that the hook needs it holds itself: no answer reaches the locals of a function that has returned.
    """
    known, state, getframe = judges(forbidden, *callers(student_files)), {"busy": False}, sys._getframe

    def hook(event, arguments):
        if state["busy"] or event not in known:
            return
        state["busy"] = True
        try:
            reason = known[event](event, arguments, getframe(1))
        finally:
            state["busy"] = False
        if reason:
            tried.append(reason)
            raise Refusal(f"answers may not do this: {reason}")

    importlib.invalidate_caches()
    sys.addaudithook(hook)


def callers(student_files):
    """Three questions about a frame: is it a student's; is one below it; did one ask for it, but for Python's own?"""
    standard = (os.path.dirname(os.__file__) + os.sep, "<frozen")

    def is_a_students(frame):
        return frame.f_code.co_filename.startswith(student_files)

    def below_a_student(frame):
        while frame is not None and not is_a_students(frame):
            frame = frame.f_back
        return frame is not None

    def asked_by_a_student(frame):
        while frame is not None and frame.f_code.co_filename.startswith(standard):
            frame = frame.f_back
        return frame is not None and is_a_students(frame)

    return is_a_students, below_a_student, asked_by_a_student


def judges(forbidden, is_a_students, below_a_student, asked_by_a_student):
    """{audit event: a function that says what is wrong with it, or ""}."""
    is_secret, isdir, basename = secret_paths(forbidden), os.path.isdir, os.path.basename
    others, attributes = tuple(forbidden["libraries"]), set(HIDDEN_ATTRIBUTES)

    def a_path(event, arguments, frame):
        listed = [a for a in arguments[: 1 if event == "open" else 2] if isinstance(a, (str, bytes, os.PathLike))]
        if any(is_secret(path) for path in listed):
            return f"it reads or writes {basename(os.fsdecode(listed[0]))[-60:]}"
        if event == "open" and listed and isdir(listed[0]) and below_a_student(frame):
            return "it opens a folder as a file"
        return ""

    def an_act(event, _, frame):
        return event if below_a_student(frame) else ""

    def a_look(event, arguments, frame):
        if event == "sys._getframe":
            file = frame.f_code.co_filename
            roundabout = file.startswith(others) or file.endswith(("inspect.py", "traceback.py"))
            hidden = is_a_students(frame) or (roundabout and below_a_student(frame))
        else:
            hidden = len(arguments) > 1 and arguments[1] in attributes and asked_by_a_student(frame)
        return f"it looks behind the scenes ({event})" if hidden else ""

    def a_disguise(_, arguments, frame):
        name = os.fsdecode(arguments[1]) if isinstance(arguments[1], (str, bytes)) else "<"
        return "it gives code the name of a file" if name[:1] != "<" and asked_by_a_student(frame) else ""

    looks = ("sys._getframe", "object.__getattr__", "object.__setattr__")
    known = {**dict.fromkeys(PATHS, a_path), **dict.fromkeys(REFUSED, an_act), **dict.fromkeys(looks, a_look)}
    return {**known, "compile": a_disguise}


def secret_paths(forbidden):
    """A function: does this path lead to what answers may not see?"""
    roots, allowed = (
        tuple(os.path.realpath(root) + os.sep for root in forbidden[name]) for name in ("roots", "except")
    )
    realpath, fspath, fsdecode = os.path.realpath, os.fspath, os.fsdecode

    def is_secret(path):
        try:
            path = fsdecode(realpath(fspath(path)))
        except (TypeError, ValueError, OSError):
            return False
        inside = (path + os.sep).startswith(roots) and not (path + os.sep).startswith(allowed)
        return inside or path.endswith(".ipynb")

    return is_secret


if __name__ == "__main__":
    main()
