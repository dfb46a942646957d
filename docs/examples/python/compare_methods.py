"""Two contact methods in Python, compared with those of trephine.

`steps` moves the proxy along the line to the hand in small steps, and stops in front of matter. `slide` sets the proxy
to the hand in free space. While the hand is inside matter, `slide` moves the proxy along the surface, toward the foot of
the perpendicular from the hand.
"""

import sys

import numpy as np
from trephine.methods import Matter, Step, compare

from numpy.typing import NDArray

Array = NDArray[np.float64]


def steps(matter: Matter, radius: float) -> Step:
    """Moves toward the hand, and stops in front of matter. The proxy does not slide."""
    proxy: list[Array] = []
    length = 0.1 * min(matter.spacing)

    def step(hand: Array) -> Array:
        if not proxy:
            proxy.append(hand)
        motion = hand - proxy[0]
        count = max(1, int(np.ceil(np.linalg.norm(motion) / length)))
        points = proxy[0] + motion * (np.arange(1, count + 1) / count)[:, None]
        is_solid = matter.query(points)["solid"]
        free = int(np.argmax(is_solid)) if is_solid.any() else count
        if free > 0:
            proxy[0] = points[free - 1]
        return proxy[0]

    return step


def slide(matter: Matter, radius: float) -> Step:
    """Follows the hand in free space; in contact, moves in the tangent plane, then along the gradient to the surface."""
    proxy: list[Array] = []

    def step(hand: Array) -> Array:
        at = proxy[0] if proxy else hand
        if matter.query(hand[None])["solid"][0]:
            for _ in range(6):
                gradient = matter.query(at[None])["gradient"][0]
                size = np.linalg.norm(gradient)
                if size < 1e-9:
                    break
                normal = -gradient / size
                at = at + (hand - at) - np.dot(hand - at, normal) * normal
                for _ in range(4):  # Newton's method, to the surface
                    here = matter.query(at[None])
                    slope = here["gradient"][0]
                    at = at - here["value"][0] * slope / max(float(np.dot(slope, slope)), 1e-12)
        else:
            at = hand
        proxy[:] = [at]
        return at

    return step


if __name__ == "__main__":
    folder = sys.argv[1] if len(sys.argv) > 1 else "out-methods"
    for method in (steps, slide):
        rows = compare(method, f"{folder}/{method.__name__}", scenes="sphere-psf-1.5-slide-100",
                       methods=("subvoxel", "mesh", "plane", "gradient", "raystep"))
        for row in rows:
            if row["method"] in (method.__name__, "subvoxel"):
                print(f"{row['method']:9} surface {row['total_rms_voxels']:.3f} voxels, force {row['force_rms_n']:.4f} N, "
                      f"{row['step_us']['p50']:.1f} us, falls {row['fall_throughs']}")
