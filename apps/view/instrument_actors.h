// Actors of instruments: solids of revolution, arrows and rods, and their placement.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>
#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkSmartPointer.h>

namespace trephine::view {

/// Returns a solid of revolution around +z from (z, radius) pairs; optionally with helical flutes.
vtkSmartPointer<vtkPolyData> make_revolution(const std::vector<glm::dvec2>& profile, bool is_fluted);

/// Places a unit source that points along +x along `direction`, scaled to length and width (mm).
void place(vtkActor* actor, const glm::dvec3& origin, glm::dvec3 direction, double length, double width);
/// Places a solid of revolution around +z along `axis` (unit).
void place(vtkActor* actor, const glm::dvec3& origin, const glm::dvec3& axis);

/// Returns an actor of one colour, shares of 1.
vtkSmartPointer<vtkActor> make_actor(vtkPolyDataMapper* mapper, const glm::dvec3& colour);
vtkSmartPointer<vtkActor> make_actor(vtkAlgorithmOutput* source, double r, double g, double b);

}  // namespace trephine::view
