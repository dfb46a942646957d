// The filled cut of a plane through shapes of a volume and through closed meshes.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "volume/bone_labels.h"
#include "volume/field.h"
#include "volume/image_plane.h"
#include "volume/version.h"

namespace trephine::cross_section {

/// Triangles in the world, seen from outside counter-clockwise.
struct SectionMesh {
  std::vector<glm::dvec3> vertices_world;
  std::vector<std::uint32_t> triangles;  ///< three a triangle
};

/// Edges of one triangle only, where corners in one place are one: their ends. Empty: the mesh is closed.
std::vector<std::array<glm::dvec3, 2>> open_edges(const SectionMesh& mesh);

/// A closed line in the plane, mm from its middle; what it encloses lies to its left.
using Loop = std::vector<glm::dvec2>;
double area_of(std::span<const Loop> loops) noexcept;  ///< mm2

/// Cut of the plane through one object.
struct Cut {
  std::vector<std::uint8_t> inside;  ///< a byte a pixel, row by row from the upper left
  std::vector<Loop> outline;
  double area = 0;  ///< mm2, of the outline
};

/// Cuts a closed mesh: a pixel's middle is inside where the surface before the plane is left more often than
/// entered (winding number above 0). Corners and pixels are taken to 2^-20 mm, and all decisions are made in
/// whole numbers; a middle on the surface counts as if it were moved by (e, e^2, e^3) to the right, up and
/// forward. Places within 1000 mm of the plane's middle; error beyond, and for meshes with open edges, which
/// are named.
volume::Result<Cut> cut_mesh(const volume::ImagePlane& plane, const SectionMesh& mesh, int threads = 0);

/// Cuts a shape of a volume as it is touched: its field is 0 or more and the place was not cut away.
/// `version`: of the field's volume; null: untouched. The outline is that of values at pixels' middles,
/// linear between.
Cut cut_volume(const volume::ImagePlane& plane, const volume::Field& field, const volume::Version* version,
               int threads = 0);

/// The pixels whose middles lie in voxels of labels that name a bone and are not cut away: cancellous bone
/// below the threshold of a window is bone too. A byte a pixel as in Cut; empty where no label names a bone.
std::vector<std::uint8_t> bone_by_labels(const volume::ImagePlane& plane, const volume::Volume& volume,
                                         const volume::Version* version);

}  // namespace trephine::cross_section
