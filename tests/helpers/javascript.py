"""Asking the site's JavaScript in Node for numbers, to be compared with Python's."""

import json
import shutil
import subprocess

import pytest

from book.publish import page_scripts

NODE = shutil.which("node")


def in_node(expression, arguments, more=""):
    """The value of a JavaScript expression for each of the arguments (`a`), with the site's kinematics (and `more`)."""
    if NODE is None:
        pytest.skip("node is not on this machine")
    program = f"globalThis.window = {{}};\n{page_scripts.kinematics()}\n{more}\n"
    program += "const { fk, ik } = window.OMX_KINEMATICS;\n"
    program += f"console.log(JSON.stringify({json.dumps(arguments)}.map((a) => {expression})));"
    done = subprocess.run([NODE], input=program, capture_output=True, text=True, timeout=60, check=True)
    return json.loads(done.stdout)


def assert_javascript(path):
    """Node reads a module and has nothing against it."""
    if NODE is None:
        pytest.skip("node is not on this machine")
    module = shutil.copy(path, path.with_suffix(".mjs"))
    done = subprocess.run([NODE, "--check", module], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


def flat(value):
    """All numbers of nested lists, in order."""
    return [number for item in value for number in flat(item)] if isinstance(value, (list, tuple)) else [value]
