"""Contact methods in Python. A method queries the matter, moves its own proxy, and is compared with the methods of
trephine.

    def sphere_tracing(matter, radius):           # called once per scene
        proxy = None
        def step(hand):                           # called once per tick, position in mm; returns the proxy
            ...
        return step

    rows = compare(sphere_tracing, "out")         # writes out/index.html: charts with a row for `sphere_tracing`
"""

from __future__ import annotations

import csv
import json
import os
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, NamedTuple, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import Operation
from .program import call

Array = NDArray[np.float64]


class Matter:
    """The solid of a scene, for queries at points (world, mm)."""

    def __init__(self, operation: Operation) -> None:
        self._operation = operation
        #: distances between voxel centres along x, y, z, mm
        self.spacing = operation.spacing

    def query(self, points: ArrayLike) -> dict[str, NDArray[Any]]:
        """Returns `solid`, `value`, `gradient` and more for each point, as `Operation.query` does."""
        return self._operation.query(points)


Step = Callable[[Array], ArrayLike]
Method = Callable[[Matter, float], Step]


class Proxies(NamedTuple):
    """Results of `run_method`: a row per tick."""

    proxy: Array  #: mm
    force: Array  #: N, stiffness times the vector from the hand to the proxy
    microseconds: Array  #: time of each call


def run_method(operation: Operation, method: Method, positions: ArrayLike, *, radius: float = 0.0,
               stiffness: float = 0.5) -> Proxies:
    """Moves the hand along positions (N, 3) and calls the method once per tick. The operation does not change."""
    path: Array = np.asarray(positions, float)
    if path.ndim != 2 or path.shape[1] != 3 or not np.isfinite(path).all():
        raise ValueError("positions must be finite numbers of shape (ticks, 3).")
    if not radius >= 0 or not 0 < stiffness < np.inf:
        raise ValueError("radius must be at least 0 mm, and stiffness above 0 N/mm.")
    step = method(Matter(operation), radius)
    proxies, times = np.empty_like(path), np.empty(len(path))
    for i, hand in enumerate(path):
        start = time.perf_counter()
        proxy = np.asarray(step(hand.copy()))
        times[i] = 1e6 * (time.perf_counter() - start)
        if proxy.shape != (3,) or np.iscomplexobj(proxy) or not np.isfinite(proxy.astype(float)).all():
            raise ValueError(f"The method returned no point in tick {i}. Return three finite numbers.")
        proxies[i] = proxy
    return Proxies(proxies, stiffness * (proxies - path), times)


def compare(method: Method, output: Union[str, "os.PathLike[str]"], *, scenes: str = "sphere-psf-1.5",
            name: str = "", methods: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Judges a method, and methods of trephine, on the scenes whose names contain `scenes`, with the judge of
    `trephine-bench feel`. Writes charts into the folder `output`, and returns a row per scene and method: errors
    against the ideal proxy, falls, and times. `name`: name of the method; by default the name of the function.
    `methods`: names of methods of trephine and of its peers, for example ("subvoxel", "mesh"); by default all."""
    name = name or getattr(method, "__name__", "method")
    if not name.replace("_", "").replace("-", "").isalnum():
        raise ValueError(f"The name of the method is {name!r}. Use letters, digits, _ and -.")
    if isinstance(methods, str):
        raise TypeError(f"methods must be a list of names, such as [{methods!r}].")
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        options = ["feel", "--quick", "--only", scenes]
        call(*options, "-o", str(work / "first"), "--export", str(work / "scenes"), "--methods", "subvoxel",
             program="trephine-bench")
        results = work / f"{name}.csv"
        with open(results, "w", newline="", encoding="ascii") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(["scene", "proxy_x", "proxy_y", "proxy_z", "us"])
            for scene in sorted(path for path in (work / "scenes").iterdir() if path.is_dir()):
                facts = json.loads((scene / "scene.json").read_text(encoding="utf-8"))
                operation = Operation.open(scene / "volume.mha", iso=facts["solid_from"])
                with open(scene / "hip.csv", newline="", encoding="ascii") as steps:
                    path = np.array([[float(row[axis]) for axis in "xyz"] for row in csv.DictReader(steps)])
                run = run_method(operation, method, path, radius=facts["radius_mm"])
                for proxy, microseconds in zip(run.proxy, run.microseconds):
                    table.writerow([facts["id"], *(repr(float(x)) for x in proxy), f"{microseconds:.3f}"])
        chosen = ["--methods", *methods] if methods else []
        judged = call(*options, *chosen, "-o", os.fspath(output), "--results", str(results), program="trephine-bench")
    rows: list[dict[str, Any]] = judged["rows"]
    return rows
