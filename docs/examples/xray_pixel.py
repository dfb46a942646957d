#!/usr/bin/env python3
"""Projects a point of the patient into an X-ray. Reads only the DICOM header of the image.

    trephine fluoro spine --view lateral --dicom shot.dcm
    python3 xray_pixel.py shot.dcm 10,20,30

prints column and row (the middle of the upper left pixel is 0, 0). The point is in mm, LPS.
"""
import math
import struct
import sys


def header(path):
    """Returns the attributes of a DICOM file (explicit VR, little endian) by their tags."""
    data = open(path, "rb").read()
    found, at = {}, 132
    while at + 8 <= len(data):
        group, element, kind = struct.unpack_from("<HH2s", data, at)
        if kind in (b"OB", b"OW", b"OF", b"SQ", b"UT", b"UN"):
            length, at = struct.unpack_from("<I", data, at + 8)[0], at + 12
        else:
            length, at = struct.unpack_from("<H", data, at + 6)[0], at + 8
        value = data[at : at + length]
        found[group, element] = struct.unpack("<H", value)[0] if kind == b"US" else value
        at += length
    return found


def pixel(path, point):
    found = header(path)
    numbers = lambda *tag: [float(v) for v in found[tag].decode().strip(" \0").split("\\")]
    primary = math.radians(numbers(0x0018, 0x1510)[0])
    secondary = math.radians(numbers(0x0018, 0x1511)[0])
    to_detector, to_patient = numbers(0x0018, 0x1110)[0], numbers(0x0018, 0x1111)[0]
    down_mm, right_mm = numbers(0x0018, 0x1164)
    x, y, z = (p - c for p, c in zip(point, numbers(0x300A, 0x012C)))
    # Distances of the point from the isocentre: to the right and up in the image, and toward the detector
    # (PS3.3 C.8.7.5).
    right = x * math.cos(primary) + y * math.sin(primary)
    outward = x * math.sin(primary) - y * math.cos(primary)
    toward = outward * math.cos(secondary) + z * math.sin(secondary)
    up = z * math.cos(secondary) - outward * math.sin(secondary)
    magnification = to_detector / (to_patient + toward)
    columns, rows = found[0x0028, 0x0011], found[0x0028, 0x0010]
    return (columns - 1) / 2 + magnification * right / right_mm, (rows - 1) / 2 - magnification * up / down_mm


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    print("%.3f %.3f" % pixel(sys.argv[1], [float(v) for v in sys.argv[2].split(",")]))
