"""Runs one student's answers and the checks that belong to them, in a process of its own: `student_run` starts it.

It knows neither `book` nor the chapters. The job comes through stdin; results go to a file, line by line, each with
the job's nonce. The order: the chapter's own cells (their names are kept), then the student's, then every check on
the chapter's names with the student's answers put in. What lies in modules is put back before each check, and
compared after it. What this process may not do is refused by an audit hook, which nobody can take away again.
"""

import ast
import builtins
import contextlib
import functools
import importlib
import io
import json
import os
import sys
import types
from json.encoder import encode_basestring_ascii

LONG = 300
#: Audit events that no answer needs: other processes, other people's frames and objects, code in disguise.
REFUSED = (
    "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.forkpty", "os.kill",
    "os.killpg", "pty.spawn", "ctypes.dlopen", "ctypes.dlsym", "ctypes.call_function", "ctypes.addressof",
    "ctypes.string_at", "sys._current_frames", "sys.settrace", "sys.setprofile", "gc.get_objects",
    "gc.get_referrers", "gc.get_referents", "code.__new__", "function.__new__", "signal.pthread_kill",
    "sqlite3.connect",
)  # fmt: skip
#: Audit events that name a path to look at, one to write, and one to look at and another to write.
READS = ("os.listdir", "os.scandir", "os.chdir")
WRITES = ("os.rename", "os.remove", "os.link", "os.symlink", "os.truncate", "os.mkdir", "os.rmdir", "os.chmod",
          "os.chown", "os.utime", "os.setxattr", "shutil.move", "shutil.rmtree")  # fmt: skip
COPIES = ("shutil.copyfile", "shutil.copytree")
#: Modules that write files without asking Python.
BEHIND = {"readline", "tkinter", "_tkinter", "_gdbm", "_dbm"}
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
HIDDEN_ATTRIBUTES = ("tb_frame", "gi_frame", "cr_frame", "ag_frame", "__code__", "f_locals", "f_globals")
FIXED_ATTRIBUTES = ("__defaults__", "__kwdefaults__")
#: Where all that checks, and this file, rely on lies.
RELIED_ON = {"omx", "numpy", "sympy", "mpmath", *sys.stdlib_module_names}
#: Attributes of a class that Python itself sets.
PYTHONS_OWN = {"__dict__", "__weakref__", "__abstractmethods__", "__subclasshook__", "__init_subclass__"}


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
    """A function that adds a line to the results, known to the grader alone; nobody else may open that file.

    It uses nothing that an answer could replace: no name of a module, and no built-in that it has not kept.
    """
    results, write, quoted, kind = os.open(path, os.O_WRONLY | os.O_APPEND), os.write, encode_basestring_ascii, type
    text, yes, no = str, True, False

    def say(**what):
        line = f'{{"nonce": "{nonce}"'
        for name, value in what.items():
            shown = (
                "true" if value is yes else "false" if value is no else f"{value:d}" if kind(value) is not text else ""
            )
            line += f', "{name}": {shown or quoted(value)}'
        write(results, (line + "}\n").encode())

    return say


def limit_memory(bytes_at_most=8 * 2**30):
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (bytes_at_most, bytes_at_most))


def grade(job, say):
    tried = []
    fresh, before = the_chapter(job["chapter"], say)
    load_what_is_named(job["student"])
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
    module.__dict__.update(display=lambda *_, **__: None, get_ipython=lambda: Magics(module.__dict__))
    sys.modules["__main__"] = module
    return module.__dict__


class Magics:
    """IPython's magics do nothing here; what stands below a `%%time` is run all the same."""

    def __init__(self, names):
        self._names = names

    def __getattr__(self, name):
        return lambda *_, **__: None

    def run_cell_magic(self, name, _, body):
        if name in ("time", "timeit", "capture", "prun"):
            run(body, self._names, "<answer below a magic>")


def run(source, names, filename):
    """Run a cell's source; of magics, `Magics` says what they do, and what it awaits is awaited, as in a notebook."""
    try:
        tree = ast.parse(source, filename)
    except SyntaxError:
        from IPython.core.inputtransformer2 import TransformerManager

        tree = ast.parse(TransformerManager().transform_cell(source), filename)
    awaited = eval(compile(tree, filename, "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT), names)
    if awaited is not None:
        import asyncio

        asyncio.run(awaited)


def load_what_is_named(cells):
    """Import what the student's cells import of `omx`, NumPy and SymPy, so that it counts as ours."""
    for cell in cells:
        with contextlib.suppress(SyntaxError, ValueError):
            for node in ast.walk(ast.parse(cell["source"])):
                found = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    found = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
                for name in found:
                    if name.split(".")[0] in ("omx", "numpy", "sympy"):
                        with contextlib.suppress(Exception):
                            importlib.import_module(name)


# ---- the student's cells --------------------------------------------------------------------------------------


def the_student(job, fresh, keeper, say):
    """{name: value} of the answers, each as it was when its check was reached. Cells in `skip` are left out."""
    names, answers, copies = namespace("student"), {}, {}
    given = {cell["id"]: meant(cell["source"]) for cell in job["chapter"] if cell["role"] == "given"}
    wanted = {exercise["check"]: exercise["answers"] for exercise in job["exercises"]}
    for cell in job["student"]:
        if cell["id"] in wanted:
            answers.update(taken(names, wanted.pop(cell["id"])))
        elif given.get(cell["id"]) == meant(cell["source"]):
            for name, value in fresh[cell["id"]].items():  # the chapter's own cell, which has run already
                names[name] = copied(value, copies)
        elif cell["id"] not in job["skip"]:
            say(at=cell["id"], of="student")
            stopped = None
            try:
                run(cell["source"], names, f"<answer {cell['id']}>")
            except BaseException as error:  # whatever a student's cell does, the next one is looked at
                stopped = error
            if found := keeper.put_back(made_anew=True):
                say(tampered=cell["id"], said=found)
            if stopped is not None:
                say(stopped=cell["id"], said=told(stopped))
    for left in wanted.values():
        answers.update(taken(names, left))
    return answers


def meant(source):
    """The code without its comments and blanks, to know a cell by."""
    with contextlib.suppress(SyntaxError, ValueError, RecursionError):
        return ast.dump(ast.parse(source))
    return source


def copied(value, copies):
    """The chapter's value for a student, who may change what is in it: arrays, matrices and containers are copies."""
    if id(value) not in copies:
        made, kind = value, type(value)
        if kind in (list, set):
            made = kind(copied(v, copies) for v in value)
        elif kind is dict:
            made = {k: copied(v, copies) for k, v in value.items()}
        elif kind is tuple:
            made = tuple([copied(v, copies) for v in value])
            made = value if all(new is old for new, old in zip(made, value, strict=True)) else made
        elif kind.__name__ in ("ndarray", "MutableDenseMatrix"):
            made = value.copy()
        copies[id(value)] = value, made  # the value, too, lest another one gets its id
    return copies[id(value)][1]


def taken(names, wanted):
    return {name: names.get(name, ...) for name in wanted}


# ---- the checks ----------------------------------------------------------------------------------------------


def looked_at(exercise, names, answers, keeper, tried, skip, say):
    """Run the statements of a check one by one; each that checks something is a criterion."""
    names.update(answers)
    for name in exercise["answers"]:
        if keeper.is_disguised(answers[name]):
            tried.append(f"{name} is an object of a class of its own, which answers for itself")
            names[name] = ...
        elif isinstance(answers[name], types.FunctionType):
            names[name] = honest(answers[name], keeper, tried)
    broken = ""
    keeper.put_back()
    for number, (source, counts) in enumerate(exercise["statements"]):
        place = f"{exercise['check']}/{number}"
        said = "it does not come to an end" if place in skip else ""
        if not said:
            say(at=place, of="check")
            said, printed = attempt(source, names, keeper, made_anew=not counts)
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


def attempt(source, names, keeper, made_anew):
    """(what went wrong or '', what was printed) of one statement; afterwards all is put back."""
    out, failed = io.StringIO(), None
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
            exec(compile(source, "<check>", "exec"), names)
    except BaseException as error:  # SystemExit and KeyboardInterrupt of an answer, too
        failed = error
    keeper.put_back(made_anew)
    once = " ".join(dict.fromkeys(out.getvalue().splitlines()))  # a loop's checks say the same many times
    return ("", " ".join(once.split())[-LONG:]) if failed is None else (told(failed), "")


def told(error):
    """A student's sentence on an error: the check's own, or the error's name and text."""
    if type(error).__name__ == "Wrong":
        return str(error)[:LONG]
    explained = sys.modules.get("omx.check.notebook")
    if explained and isinstance(error, Exception):
        with contextlib.suppress(Exception):
            return explained.explained(error)[:LONG]
    return f"{type(error).__name__}: {' '.join(str(error).split())}"[:LONG].rstrip(": ")


def honest(function, keeper, tried):
    """The student's function; an object that would answer for itself is not passed on."""

    @functools.wraps(function)
    def called(*arguments, **named):
        result = function(*arguments, **named)
        if keeper.is_disguised(result):
            tried.append(f"{function.__name__} returns an object of a class of its own, which answers for itself")
            raise TypeError(
                "it returns an object of a class of its own; numbers, lists, arrays or expressions are wanted"
            )
        return result

    return called


# ---- what must stay as it is -----------------------------------------------------------------------------------


class Keeper:
    """Remembers what the modules hold that checks rely on, says what was changed, and puts it back.

    Of `omx` that is all, also the lengths in a geometry; of others what can be called, and the methods of classes.
    """

    def __init__(self):
        self._modules = {n: m for n, m in sorted(sys.modules.items())
                         if n.split(".")[0] in RELIED_ON and isinstance(m, types.ModuleType)}  # fmt: skip
        self._builtins, self._absent = set(vars(builtins)), object()
        kept = [*self._modules.items(), ("builtins", builtins)]
        self._dicts = [(n, vars(m), held(n, m), self._builtins - vars(m).keys()) for n, m in kept]
        ours = [v for n, _, was, _ in self._dicts if n.split(".")[0] == "omx" for v in was.values()]
        self._codes = {v: v.__code__ for v in ours if isinstance(v, types.FunctionType)}
        things = {id(v): v for value in filter(is_a_thing, ours) for v in (value, *vars(prepared(value)).values())}
        self._things = [(v, dict(vars(prepared(v)))) for v in things.values() if is_a_thing(v)]
        classes = {v for _, _, was, _ in self._dicts for v in was.values() if isinstance(v, type)}
        self._classes = {v: methods(v) for v in classes if v.__flags__ & CHANGEABLE}
        self._known, waiting = {object}, [object]
        while waiting:
            new = set(type.__subclasses__(waiting.pop())) - self._known
            self._known |= new
            waiting += new
        self._modules.pop("__main__", None)
        self.found = ""

    def put_back(self, made_anew=False):
        """Put back what is not as it was; what that is, in words, or ''. Builtins come first: all else needs them.

        `made_anew`: methods of the same code are no news; mpmath makes its own again with every new context.
        """
        self.found = ""
        for module, d, was, free in reversed(self._dicts):
            for name, value in was.items():
                if d.get(name, self._absent) is not value:
                    self._note(f"{module}.{name} was replaced")
                    d[name] = value
            for name in d.keys() & free:
                if not (name.startswith("__") or isinstance(d[name], types.ModuleType)):
                    self._note(f"{module}.{name} was added, in place of Python's own")
                    del d[name]
        for function, code in self._codes.items():
            if function.__code__ is not code:
                self._note(f"the code of {function.__name__} was replaced")
                function.__code__ = code
        for kind, was in self._classes.items():
            now = methods(kind)
            if not the_same(now, was):
                if not (made_anew and the_same(codes(now), codes(was))):
                    self._note(f"a method of {kind.__name__} was replaced")
                for name in now.keys() - was.keys():
                    delattr(kind, name)
                for name, value in was.items():
                    if now.get(name) is not value:
                        setattr(kind, name, value)
        for thing, was in self._things:
            if not the_same(vars(thing), was):
                self._note(f"a {type(thing).__name__} of omx was changed")
                vars(thing).clear()
                vars(thing).update(was)
        for name, module in self._modules.items():
            if sys.modules.get(name) is not module:
                self._note(f"the module {name} was replaced")
                sys.modules[name] = module
        return self.found

    def _note(self, what):
        self.found = self.found or what

    def is_disguised(self, value, depth=4):
        """Is this, or is in it, an object of a class that the student wrote, which may answer as it likes?"""
        if isinstance(value, (types.FunctionType, type)):
            return False
        kind = type(value)
        if kind not in self._known:
            return True
        inside = ()
        if kind in (list, tuple, set, frozenset):
            inside = value
        elif kind is dict:
            inside = [*value, *value.values()]
        elif kind.__name__ == "ndarray" and value.dtype == object:
            inside = value.flat
        elif kind.__module__.startswith("sympy."):
            inside = value.flat() if kind.__name__.endswith("Matrix") else getattr(value, "args", ())
            depth += 1  # an expression may be as deep as it likes
        return depth > 0 and any(self.is_disguised(v, depth - 1) for v in inside)


CHANGEABLE = 1 << 9  # of the flags of a class: Py_TPFLAGS_HEAPTYPE, written in Python


def held(name, module):
    """What is kept of a module: all of `omx`, what can be called of others."""
    ours = name.split(".")[0] == "omx"
    return {k: v for k, v in vars(module).items() if not k.startswith("__") and (ours or callable(v))}


def methods(kind):
    """What can be called, or computes an attribute, in a class itself."""
    return {
        k: v for k, v in vars(kind).items() if (callable(v) or hasattr(type(v), "__get__")) and k not in PYTHONS_OWN
    }


def codes(methods):
    """The methods, Python's functions by their code."""
    return {name: v.__code__ if isinstance(v, types.FunctionType) else v for name, v in methods.items()}


def the_same(now, was):
    """Do two dicts hold the same objects under the same names?"""
    return now.keys() == was.keys() and all(now[name] is value for name, value in was.items())


def is_a_thing(value):
    """An object of `omx`, such as a geometry, that holds what it holds for good."""
    return type(value).__module__.startswith("omx.") and hasattr(value, "__dict__") and not callable(value)


def prepared(thing):
    """The object, with all computed that it computes once."""
    for name, value in vars(type(thing)).items():
        if isinstance(value, functools.cached_property):
            getattr(thing, name)
    return thing


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
    is_secret, is_own, isdir, basename = *places(forbidden), os.path.isdir, os.path.basename
    others, attributes, fixed = tuple(forbidden["libraries"]), set(HIDDEN_ATTRIBUTES), set(FIXED_ATTRIBUTES)

    def a_path(event, arguments, frame):
        two = arguments[: 1 if event == "open" else 2]
        listed = [a for a in two if isinstance(a, (str, bytes, os.PathLike))]
        if any(is_secret(path) for path in listed):
            return f"it reads or writes {basename(os.fsdecode(listed[0]))[-60:]}"
        written = listed[1:] if event in COPIES else listed if event in WRITES else ()
        if event == "open" and arguments[2] & WRITING:
            written = listed
        if foreign := [path for path in written if not is_own(path)]:
            return f"it writes {basename(os.fsdecode(foreign[0]))[-60:]}, outside its folder"
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
            wanted = attributes | fixed if event == "object.__setattr__" else attributes
            hidden = len(arguments) > 1 and arguments[1] in wanted and asked_by_a_student(frame)
        return f"it looks behind the scenes ({event})" if hidden else ""

    def an_import(_, arguments, frame):
        return f"import {arguments[0]}" if arguments[0] in BEHIND and below_a_student(frame) else ""

    def a_thread(event, _, frame):
        return "it starts a thread" if asked_by_a_student(frame) else ""

    def a_disguise(_, arguments, frame):
        name = os.fsdecode(arguments[1]) if isinstance(arguments[1], (str, bytes)) else "<"
        return "it gives code the name of a file" if name[:1] != "<" and asked_by_a_student(frame) else ""

    looks = ("sys._getframe", "object.__getattr__", "object.__setattr__")
    paths = ("open", *READS, *WRITES, *COPIES)
    known = {**dict.fromkeys(paths, a_path), **dict.fromkeys(REFUSED, an_act), **dict.fromkeys(looks, a_look)}
    threads = dict.fromkeys(("_thread.start_new_thread", "_thread.start_joinable_thread"), a_thread)
    return {**known, **threads, "compile": a_disguise, "import": an_import}


def places(forbidden):
    """Two functions: does this path lead to what answers may not see? Does it to what they may write?"""
    roots, allowed, own = (
        tuple(os.path.realpath(root) + os.sep for root in forbidden[name]) for name in ("roots", "except", "own")
    )
    realpath, fspath, fsdecode, nowhere = os.path.realpath, os.fspath, os.fsdecode, os.path.realpath(os.devnull)

    def is_secret(path):
        try:
            path = fsdecode(realpath(fspath(path)))
        except (TypeError, ValueError, OSError):
            return False
        inside = (path + os.sep).startswith(roots) and not (path + os.sep).startswith(allowed)
        return inside or path.endswith(".ipynb")

    def is_own(path):
        try:
            path = fsdecode(realpath(fspath(path)))
        except (TypeError, ValueError, OSError):
            return False
        return path == nowhere or path.startswith(own)

    return is_secret, is_own


if __name__ == "__main__":
    main()
