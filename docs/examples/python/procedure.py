"""A procedure in Python: drills until the burr is through the bone. It observes, and acts by poses and commands."""

import numpy as np
import trephine as tr

operation = tr.Operation.open("head", hand=tr.Hand("burr", diameter=4, removal_rate=150), plan=True)

TICKS = 100  # the procedure looks at the state ten times a second
depth = 68.0
while depth > 50:
    positions = np.tile((0.0, -20.0, depth), (TICKS, 1))
    touches = operation.run(positions, buttons=1)
    if operation.removed_mm3 > 30 and not touches.contact[-20:].any():
        break
    depth -= 0.2  # mm

operation.run(positions[-1:], buttons=0)
print(f"through at z = {depth:.1f} mm after {operation.tick / 1000:.1f} s")
for name in ("removed", "nearest to dura"):
    print(f"{name}: {operation.measures[name]:.2f}")
