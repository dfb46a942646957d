// Filled cross-sections of shapes of a volume and of closed meshes.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "volume/cuts/version.h"
#include "volume/imaging/image_plane.h"
#include "volume/scan/bone_labels.h"
#include "volume/scan/field.h"

namespace trephine::cross_section {

/// Triangles in the world frame, mm, counter-clockwise when viewed from outside.
struct SectionMesh {
  std::vector<glm::dvec3> vertices_world;
  std::vector<std::uint32_t> triangles;  ///< three indices per triangle
};

/// Merges corners at the same position, and returns the ends (mm, world) of the edges that the triangles do
/// not pass equally often in both directions, such as the border of a hole. An empty result means that the
/// mesh is closed.
std::vector<std::array<glm::dvec3, 2>> open_edges(const SectionMesh& mesh);

/// Closed polygon in the plane, mm from the plane's centre; the inside is on its left.
using Loop = std::vector<glm::dvec2>;
double area_of(std::span<const Loop> loops) noexcept;  ///< mm2

/// Cross-section of one object.
struct Cut {
  std::vector<std::uint8_t> inside;  ///< one byte per pixel, row by row from the upper left
  std::vector<Loop> outline;
  double area = 0;  ///< mm2, of the outline
};

/// Cuts a closed mesh. A pixel is inside if a line from its centre toward the viewer leaves the mesh more
/// often than it enters it (winding number above 0). Corners and pixels are rounded to 2^-20 mm, and all
/// decisions are made in integers. A centre on the surface counts as if it were moved by (e, e^2, e^3) to the
/// right, up and forward, with an infinitesimal e. Returns an error for an invalid plane, for a mesh with
/// open edges (with their number and the first of them), and if a coordinate of the mesh or half the edge of
/// the image is 1000 mm or more from the plane's centre.
Result<Cut> cut_mesh(const volume::ImagePlane& plane, const SectionMesh& mesh, int threads = 0);

/// Cuts a shape of a volume as it is touched. A pixel is inside if the field is not negative at its centre
/// and no matter was removed there. `version`: version of the field's volume; null: the uncut volume. The
/// outline is interpolated linearly between the values at the pixels' centres.
Cut cut_volume(const volume::ImagePlane& plane, const volume::Field& field, const volume::Version* version,
               int threads = 0);

/// Returns the pixels with centres in voxels that have the label of a bone and were not removed. Cancellous
/// bone whose intensity is below the threshold of a window thus counts as bone. One byte per pixel as in Cut;
/// empty if no label names a bone.
std::vector<std::uint8_t> bone_by_labels(const volume::ImagePlane& plane, const volume::Volume& volume,
                                         const volume::Version* version);

/// Returns the pixels that are bone in the uncut scan, by the shape or by a label. Metal in these pixels
/// does not count as outside bone, because a screw fills the track that was made for it.
std::vector<std::uint8_t> uncut_bone(const volume::ImagePlane& plane, const volume::Field& bone);

}  // namespace trephine::cross_section
