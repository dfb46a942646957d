"""Calls of the command-line programs, which write reports and compare methods in processes of their own."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Optional, Union

import numpy as np

from ._core import Error, Scan

PathLike = Union[str, "os.PathLike[str]"]
#: the scan that a session operated on, if the session does not contain it
ScanOrPath = Union[None, PathLike, Scan]


def find_program(name: str = "trephine") -> str:
    """Returns the path of a program. Searches the folder in the environment variable TREPHINE_PROGRAMS, then the build
    or installation that contains this module, then PATH."""
    folders = [os.environ.get("TREPHINE_PROGRAMS", "")]
    folders += [str(parent / "bin") for parent in list(Path(__file__).resolve().parents)[1:6]]
    for folder in folders:
        path = shutil.which(name, path=folder) if folder else None
        if path:
            return path
    path = shutil.which(name)
    if path:
        return path
    raise FileNotFoundError(f"The program {name} was not found. Set TREPHINE_PROGRAMS to its folder.")


def call(*words: PathLike, program: str = "trephine") -> dict[str, Any]:
    """Runs a command, and returns its JSON. Raises Error with the message of the command."""
    result = subprocess.run([find_program(program), *(os.fspath(word) for word in words), "--json"], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True, check=False)
    try:
        output: dict[str, Any] = json.loads(result.stdout)
    except ValueError:
        lines = result.stderr.strip().splitlines() or [f"the program ended with exit status {result.returncode}"]
        raise Error(f"{program} {os.fspath(words[0])}: {lines[-1]}") from None
    if "error" in output:
        fields = output["error"] if isinstance(output["error"], dict) else {"what": str(output["error"])}
        lines = [": ".join(str(fields[key]) for key in ("where", "what") if fields.get(key))]
        lines += [f"  {key}: {fields[key]}" for key in ("found", "expected", "remedy") if fields.get(key)]
        error = Error("\n".join(lines))
        for key in ("what", "where", "found", "expected", "remedy"):
            setattr(error, key, str(fields.get(key, "")))
        raise error
    return output


def _file(path: PathLike) -> str:
    """Returns a path that no command takes for an option."""
    text = os.fspath(path)
    return "./" + text if text.startswith("-") else text


@contextmanager
def _scan_options(scan: ScanOrPath) -> Iterator[list[PathLike]]:
    """Provides the options for a scan. A Scan is written to a temporary file."""
    if scan is None:
        yield []
    elif isinstance(scan, Scan):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scan.nrrd")
            scan.save(path)
            yield ["--scan", path]
    else:
        yield ["--scan", _file(scan)]


def report(session: PathLike, page: PathLike, *, scan: ScanOrPath = None, expert: Optional[PathLike] = None) -> None:
    """Writes the report of a recorded session as one HTML page. `scan`: for a session that does not contain its scan.
    `expert`: a session to compare with."""
    with _scan_options(scan) as options:
        call("report", _file(session), "-o", _file(page), *options, *(["--expert", _file(expert)] if expert is not None else []))


def audit(session: PathLike, *, scan: ScanOrPath = None) -> dict[str, Any]:
    """Returns the results of the independent judge of each tick of a session, `trephine audit`."""
    with _scan_options(scan) as options:
        return call("audit", _file(session), *options)


def ticks(session: PathLike, *, scan: ScanOrPath = None) -> dict[str, Any]:
    """Replays a session, and returns its ticks as arrays of the columns of `trephine replay --table`: `t`, `hip_x`,
    `proxy_x`, `force_x`, `contact`, `shape` and others (docs/file-formats.md). Hands are numbered from 0."""
    with tempfile.TemporaryDirectory() as folder, _scan_options(scan) as options:
        table = os.path.join(folder, "ticks.csv")
        call("replay", _file(session), "--table", table, *options)
        with open(table, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    names = rows[0].keys() if rows else ()
    texts = ("shape", "side")
    columns = {name: np.array([row[name] if name in texts else float(row[name]) for row in rows]) for name in names}
    if "hand" in columns:
        columns["hand"] -= 1
    return columns
