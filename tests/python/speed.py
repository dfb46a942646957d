"""Prints times: of a tick in contact, with all ticks in one call and with one call per tick; and of a step and a
reset of learning environments.

PYTHONPATH=build/release/python /usr/bin/python3 tests/python/speed.py
"""

import subprocess
import time

import numpy as np
import trephine as tr
from trephine.env import BurrHole, Pocket, SurgeryEnv
from trephine.program import find_program

TICKS = 100_000
angles = np.linspace(0, 6.28, TICKS)
positions = 29.5 * np.stack([np.sin(angles), np.zeros(TICKS), np.cos(angles)], axis=1)
operation = tr.Operation.open(tr.Scan.phantom("sphere", spacing=(1, 1, 1), radius=30), iso=300)
operation.run(np.linspace((0, 0, 40), positions[0], 200))

whole, single = [], []
for _ in range(5):
    start = time.perf_counter()
    touches = operation.run(positions)
    whole.append(time.perf_counter() - start)
    start = time.perf_counter()
    for position in positions[:, None]:
        operation.run(position)
    single.append(time.perf_counter() - start)
assert touches.contact.all()
print(f"one call for all ticks: {min(whole) / TICKS * 1e6:.2f} us per tick")
# Compares with a loop of C++ over the same ticks, alternately.
ratios = []
for _ in range(5):
    loop = float(subprocess.run([find_program("speed_loop")], check=True, stdout=subprocess.PIPE, text=True).stdout)
    runs = []
    for _ in range(5):
        start = time.perf_counter()
        operation.run(positions)
        runs.append(time.perf_counter() - start)
    ratios.append(1e6 * min(runs) / TICKS / loop)
print(f"a loop of C++:          {loop:.2f} us per tick; Python takes {np.median(ratios):.3f} times as long (median of 5)")
print(f"one call per tick:      {min(single) / TICKS * 1e6:.2f} us per tick")

for task in (Pocket(), BurrHole()):
    env = SurgeryEnv(task, ticks_per_step=50)
    steps, resets = [], []
    for _ in range(20):
        env.reset(seed=1)
        for _ in range(40):
            start = time.perf_counter()
            env.step([0, 0, -10, 1])
            steps.append(time.perf_counter() - start)
        start = time.perf_counter()
        env.reset(seed=1)
        resets.append(time.perf_counter() - start)
    name = type(task).__name__
    print(f"{name}: step of 50 ticks {np.median(steps) * 1e3:.2f} ms, reset {np.median(resets) * 1e3:.2f} ms (medians)")
