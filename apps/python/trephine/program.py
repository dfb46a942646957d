"""Calls of the command-line programs, which write reports and compare methods in processes of their own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any, Optional, Union

from ._core import Error

Path_ = Union[str, "os.PathLike[str]"]


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


def call(*words: Path_, program: str = "trephine") -> dict[str, Any]:
    """Runs a command, and returns its JSON. Raises Error with the message of the command."""
    result = subprocess.run([find_program(program), *map(os.fspath, words), "--json"], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True, check=False)
    try:
        output: dict[str, Any] = json.loads(result.stdout)
    except ValueError:
        lines = result.stderr.strip().splitlines() or [f"the program ended with exit status {result.returncode}"]
        raise Error(f"{program} {os.fspath(words[0])}: {lines[-1]}") from None
    if "error" in output:
        fields = output["error"] if isinstance(output["error"], dict) else {"what": str(output["error"])}
        error = Error(": ".join(str(fields[key]) for key in ("what", "where", "found") if fields.get(key)))
        for key in ("what", "where", "found", "expected", "remedy"):
            setattr(error, key, str(fields.get(key, "")))
        raise error
    return output


def report(session: Path_, page: Path_, *, scan: Optional[Path_] = None, expert: Optional[Path_] = None) -> None:
    """Writes the report of a recorded session as one HTML page. `scan`: for a session that does not contain its scan.
    `expert`: a session to compare with."""
    words: list[Path_] = ["report", session, "-o", page]
    if scan is not None:
        words += ["--scan", scan]
    if expert is not None:
        words += ["--expert", expert]
    call(*words)
