// Actors of instruments: solids of revolution, arrows and rods, and their placement.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>
#include <vtkActor.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkSmartPointer.h>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::view {

/// Returns a solid of revolution around +z from (z, radius) pairs; optionally with helical flutes.
vtkSmartPointer<vtkPolyData> make_revolution(const std::vector<glm::dvec2>& profile, bool is_fluted);

/// Returns a mesh with normals. Edges of more than 40 degrees are sharp.
vtkSmartPointer<vtkPolyData> make_mesh(const haptics::MeshTree& tree);

/// Places an actor at a pose.
void place(vtkActor* actor, const haptics::Placement& placement);
/// Places an actor whose source has unit size and points along +x: turns it toward `direction`, and scales it
/// to `length` and `width` (mm).
void place(vtkActor* actor, const glm::dvec3& origin, glm::dvec3 direction, double length, double width);
/// Places an actor of make_revolution(): turns its axis from +z to `axis` (unit).
void place(vtkActor* actor, const glm::dvec3& origin, const glm::dvec3& axis);

/// Returns an actor of one colour, RGB from 0 to 1.
vtkSmartPointer<vtkActor> make_actor(vtkPolyDataMapper* mapper, const glm::dvec3& colour);
vtkSmartPointer<vtkActor> make_actor(vtkAlgorithmOutput* source, double r, double g, double b);

}  // namespace trephine::view
