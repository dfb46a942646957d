"""A procedure and a judgement in Python: a burr hole that ends at the dura, and the width of the hole."""

from typing import Iterable

import numpy as np
import trephine as tr
from trephine.procedure import Command, Observation, Procedure, perform


class BurrHole(Procedure):
    """Ends when the burr is through the bone, or has touched a forbidden structure such as the dura."""

    interval = 50

    def start(self, operation: tr.Operation) -> Iterable[Command]:
        return [Command("note", text="The hole begins.")]

    def observe(self, observation: Observation) -> Iterable[Command]:
        names = {event.name for event in observation.events}
        if names & {"structure-touched", "structure-torn"}:
            self.complete("the burr touched a structure")
        elif observation.operation.removed_mm3 > 30 and not observation.touches.contact[-20:].any():
            self.complete("the burr is through the bone")
        return [Command("note", text=self.reason)] if self.reason else []


operation = tr.Operation.open("head", hand=tr.Hand("burr", diameter=4, removal_rate=150), plan=True)
path = np.tile((0.0, -20.0, 0.0), (9000, 1))
path[:, 2] = np.linspace(68, 50, len(path))
outcome = perform(operation, BurrHole(), path, buttons=1)
print(f"{outcome.reason} after {outcome.ticks / 1000:.1f} s")

# A judgement of your own: the largest distance of removed matter from the axis of the hole, less the burr's radius.
offsets = np.stack(np.meshgrid(np.arange(-4, 4.01, 0.25), np.arange(-4, 4.01, 0.25), np.arange(52, 66, 0.5)), -1)
points = offsets.reshape(-1, 3) + (0, -20, 0)
removed = operation.query(points)["removed"]
widest = float(np.hypot(*(points[removed][:, :2] - (0, -20)).T).max())
score = operation.score([tr.MeasuredValue("hole: width beyond the burr", widest - 2, unit="mm", full_at=0.5, zero_at=2)])
for finding in score["findings"]:
    if finding["name"].startswith("hole"):
        print(f"{finding['name']}: {finding['value']:.2f} mm, {finding['verdict']}, {finding['points']:.1f} of 1 point")
