"""Touches the built-in head with a stylus, and prints the first contact and the force at the end."""

import numpy as np
import trephine as tr

operation = tr.Operation.open("head")

# The hand moves down onto the skull at 30 mm/s, and stops 3 mm below its surface.
positions = np.zeros((1500, 3))
positions[:, 1] = -20
positions[:, 2] = np.maximum(90 - 0.03 * np.arange(1500), 62)
touches = operation.run(positions)

first = int(np.argmax(touches.contact))
print(f"contact after {first} ms at z = {touches.proxy[first, 2]:.2f} mm")
print(f"force at the end: {np.linalg.norm(touches.force[-1]):.2f} N")
