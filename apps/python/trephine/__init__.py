"""Volumetric surgical simulation: touch, drill and image scans.

Arrays of voxels are (z, y, x). Points are (x, y, z) in mm: x to the patient's left, y to the back, z up (LPS).
"""

from ._core import Error, Event, Fault, Hand, MeasuredValue, Operation, Scan, Snapshot, Surface, Touches, __version__

__all__ = ["Error", "Event", "Fault", "Hand", "MeasuredValue", "Operation", "Scan", "Snapshot", "Surface", "Touches", "__version__"]
