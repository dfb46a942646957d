"""Takes X-rays of a pedicle screw from five directions as NumPy arrays, and finds the screw in each by subtraction.

Also writes the images next to each other if you name a file: /usr/bin/python3 xray_views.py views.png
"""

import struct
import sys
import zlib

import numpy as np
import trephine as tr
from numpy.typing import NDArray

Image = NDArray[np.uint8]


def write_png(path: str, image: Image) -> None:
    """Writes a grey image (rows, columns)."""
    rows = b"".join(b"\0" + row.tobytes() for row in image)
    parts = ((b"IHDR", struct.pack(">IIBBBBB", image.shape[1], image.shape[0], 8, 0, 0, 0, 0)),
             (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for name, data in parts:
            file.write(struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)))


operation = tr.Operation.open("spine", plan=True)
angles = (-90, -45, 0, 45, 90)  # degrees of the C-arm around the patient; 0 is from the front


def views() -> list[Image]:
    return [operation.xray((12.0, 14.0, 6.5), primary=angle, columns=240, rows=240, pixel=0.8) for angle in angles]


before = views()
operation.command("place-screw", entry=(16.3, 37.0, 6.5), target=(8.2, -9.0, 6.5), diameter=6, length=45, seconds=0,
                  forced=True)
after = views()
for angle, first, second in zip(angles, before, after):
    is_screw = np.abs(first.astype(int) - second) > 20
    rows, columns = np.nonzero(is_screw)
    # Principal components of the pixels: the screw's length and direction in the image.
    offsets = np.stack([columns, rows]) - np.array([[columns.mean()], [rows.mean()]])
    axis = np.linalg.svd(offsets, full_matrices=False)[0][:, 0]
    along = axis @ offsets
    print(f"{angle:4d} deg: the screw covers {len(rows):5d} pixels, {0.8 * np.ptp(along):5.1f} mm long at the detector")

if len(sys.argv) > 1:
    write_png(sys.argv[1], np.concatenate(after, axis=1))
