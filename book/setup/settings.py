"""What of the user's own settings for pip and uv holds here: the index, the proxy, the certificate. Nothing else.

A setting such as `user = true`, `target`, `require-hashes` or `exclude-newer` is meant for other work, and would
stop or mislead a set-up that has its own environment. Standard library only.
"""

import os
import re
import sys
from pathlib import Path

KEPT = {
    "PIP_": (
        *("INDEX_URL", "EXTRA_INDEX_URL", "NO_INDEX", "FIND_LINKS", "TRUSTED_HOST", "PROXY", "CERT", "CLIENT_CERT"),
        *("KEYRING_PROVIDER", "RETRIES", "DEFAULT_TIMEOUT", "CACHE_DIR", "NO_CACHE_DIR"),
    ),
    "UV_": (
        *("DEFAULT_INDEX", "INDEX", "INDEX_URL", "EXTRA_INDEX_URL", "NO_INDEX", "FIND_LINKS", "INSECURE_HOST"),
        *("INDEX_STRATEGY", "OFFLINE", "NATIVE_TLS", "SYSTEM_CERTS", "KEYRING_PROVIDER", "HTTP_RETRIES"),
        *("HTTP_TIMEOUT", "HTTP_PROXY", "HTTPS_PROXY", "NO_PROXY", "ALL_PROXY", "CACHE_DIR", "NO_CACHE"),
    ),
}
LOGIN = re.compile(r"UV_INDEX_\w+_(USERNAME|PASSWORD)")


def is_foreign(name):
    """Is this an environment variable by which the user sets pip or uv for other work?"""
    for prefix, kept in KEPT.items():
        if name.startswith(prefix):
            return name.removeprefix(prefix) not in kept and not LOGIN.fullmatch(name)
    return False


def for_uv(given=os.environ):
    """Variables that say to uv what of its settings files holds; the files themselves are not read then."""
    found = {"UV_NO_CONFIG": "1"}
    for path in uv_files(given):
        said = toml(path)
        said = {**said.get("pip", {}), **said}
        indexes = [index for index in said.get("index", []) if isinstance(index, dict) and "url" in index]
        said["default-index"] = [index["url"] for index in indexes if index.get("default")][:1]
        said["index"] = [f"{index['name']}={index['url']}" if "name" in index else index["url"]
                         for index in indexes if not index.get("default")]  # fmt: skip
        said["insecure-host"] = said.get("allow-insecure-host")
        for name in KEPT["UV_"]:
            if text := word(said.get(name.lower().replace("_", "-"))):
                found["UV_" + name] = text
    return {name: value for name, value in found.items() if name not in given or is_foreign(name)}


def uv_files(given):
    """Where uv looks for settings, the weakest first."""
    if sys.platform == "win32":
        bases = [given.get("PROGRAMDATA"), given.get("APPDATA")]
    else:
        bases = ["/etc", given.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")]
    files = [Path(base, "uv", "uv.toml") for base in bases if base]
    return [*files, Path(given["UV_CONFIG_FILE"])] if given.get("UV_CONFIG_FILE") else files


def toml(path):
    """The settings of a file; none where there is no such file, or none that can be read."""
    import tomllib  # here, because every start of run.py imports this file

    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def word(value):
    """A value as an environment variable holds it; '' for what says nothing."""
    if isinstance(value, list):
        return " ".join(map(str, value))
    return "" if value is None or value is False else "1" if value is True else str(value)


def for_pip(listed, given=os.environ):
    """Variables that say to pip what of its settings files holds; `listed` is what `pip config list` printed."""
    found = {"PIP_CONFIG_FILE": os.devnull}
    for name, value in re.findall(r"^(?:global|install)\.([\w-]+)='(.*)'$", listed, re.M):
        name = name.upper().replace("-", "_")
        name = {"TIMEOUT": "DEFAULT_TIMEOUT"}.get(name, name)
        if name in KEPT["PIP_"]:
            found["PIP_" + name] = " ".join(value.encode().decode("unicode_escape").split())
    return {name: value for name, value in found.items() if name not in given or is_foreign(name)}
