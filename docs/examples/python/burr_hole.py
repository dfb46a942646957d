"""Drills a burr hole, undoes it, and compares X-rays before and after."""

import numpy as np
import trephine as tr

operation = tr.Operation.open("head", hand=tr.Hand("burr", diameter=7, removal_rate=100))
before = operation.xray((0, 0, 40), columns=256, rows=256, pixel=1.0)

positions = np.zeros((6000, 3))
positions[:, 1] = -20
positions[:, 2] = np.maximum(70 - 0.004 * np.arange(6000), 50)
touches = operation.run(positions, buttons=1)
print(f"removed: {operation.removed_mm3:.0f} mm3, strongest force {np.linalg.norm(touches.force, axis=1).max():.1f} N")
for event in operation.events:
    print(f"{event.tick / 1000:6.3f} s  {event.name}  {event.fields}")

after = operation.xray((0, 0, 40), columns=256, rows=256, pixel=1.0)
print(f"pixels of the X-ray that changed: {np.count_nonzero(before != after)}")
operation.run(positions[-1:], buttons=0)
operation.undo()
print(f"after undo: {operation.removed_mm3:.0f} mm3")
