"""Surfaces for other libraries, which are imported when they are needed."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from ._core import Surface


def to_vtk(surface: Surface) -> Any:
    """Returns a vtkPolyData with the vertices (double) and triangles of a surface. Needs VTK's Python module."""
    data_model = importlib.import_module("vtkmodules.vtkCommonDataModel")
    core = importlib.import_module("vtkmodules.vtkCommonCore")
    support = importlib.import_module("vtkmodules.util.numpy_support")
    points = core.vtkPoints()
    points.SetData(support.numpy_to_vtk(np.ascontiguousarray(surface.vertices), deep=True))
    cells = data_model.vtkCellArray()
    count = len(surface.triangles)
    cells.SetData(support.numpy_to_vtkIdTypeArray(np.arange(0, 3 * count + 1, 3, dtype=np.int64), deep=True),
                  support.numpy_to_vtkIdTypeArray(surface.triangles.astype(np.int64).ravel(), deep=True))
    mesh = data_model.vtkPolyData()
    mesh.SetPoints(points)
    mesh.SetPolys(cells)
    return mesh


def to_trimesh(surface: Surface) -> Any:
    """Returns a trimesh.Trimesh with the vertices and triangles as they are. Needs the package trimesh."""
    trimesh = importlib.import_module("trimesh")
    return trimesh.Trimesh(vertices=np.array(surface.vertices), faces=surface.triangles.astype(np.int64), process=False)
