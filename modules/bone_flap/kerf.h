// CutSurface, Kerf: surface that a saw cuts through the calvaria, along the sides of a pyramid over the
// outline, and the distances of lattice samples to it.
#pragma once

#include <unordered_map>

#include "modules/bone_flap/outline.h"
#include "volume/cuts/removal.h"

namespace trephine::bone_flap {

/// Overcut of the kerf beyond the inner and the outer table, mm, so that the flap detaches.
inline constexpr double k_overcut = 0.25;

/// Limits for the bone on the saw's path, mm.
struct SawLimits {
  double hole = 5;       ///< widest gap in the bone along the outline that is bridged: a suture
  double space = 3;      ///< widest air gap between the tables that is sawn through
  double thickest = 25;  ///< thicker bone is not calvaria
};

/// Returns "between anchors 3 and 4" for side 2 of an outline with `count` anchors.
std::string between_anchors(std::size_t side, std::size_t count);

/// Surface swept by the saw's centre line: flat strips between lines from the apex through the outline. On
/// each line it extends from below the inner table to above the outer table.
class CutSurface {
 public:
  /// Line from the apex, with the extent of the surface on it.
  struct Line {
    std::size_t side;     ///< side of the pyramid: index of its first anchor
    glm::dvec3 along;     ///< unit, outward
    double outer, inner;  ///< tables, mm from the apex
    double from, to;      ///< inner and outer end of the surface, mm from the apex
    bool is_on_anchor;    ///< goes through an anchor
    bool is_bone;         ///< tables were found; else they are interpolated across a gap
  };

  /// Computes the surface for a saw of `width` mm. Fails if the outline leaves the calvaria or the scan, or
  /// if the apex is too near to bone.
  LocatedStatus make(const Pyramid& pyramid, const volume::Field& bone, double width,
                     const SawLimits& limits);

  const Pyramid& pyramid() const noexcept { return pyramid_; }
  const std::vector<Line>& lines() const noexcept { return lines_; }  ///< in the order of the anchors
  double width() const noexcept { return width_; }                    ///< mm
  /// Returns the point of a line at `t` mm from the apex, mm, world.
  glm::dvec3 point_at(const Line& line, double t) const noexcept {
    return pyramid_.apex_world + t * line.along;
  }
  glm::dvec3 outer_point(std::size_t i) const noexcept { return point_at(lines_[i], lines_[i].outer); }
  /// Returns the points where the lines meet the outer table, mm, world.
  std::vector<glm::dvec3> outline() const;
  /// Returns the deepest point of the surface on each line, mm, world.
  std::vector<glm::dvec3> floor() const;
  /// Returns the area of the surface in bone that is not removed in `before`, mm2.
  double wall_mm2(const volume::Field& bone, const volume::Version& before) const;
  /// Outer surface of the skull inside the outline, without regard to earlier cuts: lines from its centre to
  /// the outline, all with the same number of points.
  struct OuterSurface {
    std::vector<std::size_t> rim;               ///< indices in lines() of the lines at which the grid ends
    std::vector<std::vector<glm::dvec3>> grid;  ///< points of a line per rim index, from the centre outward
  };
  /// `step`: approximate spacing of the points along and across the grid's lines, mm.
  OuterSurface outer_surface(const volume::Field& bone, double step) const;
  /// Returns the area of the outer surface, mm2.
  double outer_mm2(const volume::Field& bone) const;

  /// Flat part of the surface between a line and the next line. World frame, mm.
  struct Strip {
    glm::dvec3 corners[4];  ///< in order around the strip: two on the first line, two on the second
    glm::dvec3 normal;      ///< unit
    glm::dvec3 middle;      ///< centre of the bounding ball
    double reach;           ///< radius of the bounding ball
    std::size_t side;       ///< side of the pyramid
  };
  Strip strip(std::size_t i) const noexcept;
  /// Returns the squared distance of a point from a strip, mm2.
  static double distance_square(const Strip& strip, const glm::dvec3& p_world) noexcept;
  /// Returns true if the segment from a to b crosses the strip.
  static bool crosses(const Strip& strip, const glm::dvec3& a, const glm::dvec3& b) noexcept;

 private:
  LocatedStatus find_tables(const volume::Field& bone, const SawLimits& limits);
  LocatedStatus check_holes(double largest);
  LocatedStatus check_scan(const volume::Volume& scan) const;

  Pyramid pyramid_;
  std::vector<Line> lines_;
  double width_ = 0;
};

/// Kerf on a cut lattice: the samples within half of the saw's width of a CutSurface.
class Kerf final : public volume::RemovalField {
 public:
  /// `beyond`: distance outside the band up to which distances are also computed, mm. Borrows the surface.
  Kerf(const CutSurface& surface, const volume::Version& version, double beyond = 0);
  Reach find(const glm::ivec3& low, double band, Distances& mm) override;
  /// Returns the box of the samples that the kerf may reach.
  const volume::VoxelBox& samples() const noexcept { return box_; }

  /// Returns the number of pairs of neighbouring bone samples (26 neighbours each) of `rest` whose connection
  /// crosses the surface. A flood fill can pass between flap and skull through each pair.
  std::int64_t count_holes(const volume::Field& bone, const volume::Version& rest) const;

 private:
  const CutSurface& surface_;
  const volume::CutLattice lattice_;
  std::vector<CutSurface::Strip> strips_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> strips_by_brick_;  ///< strips near each brick
  volume::VoxelBox box_;
};

}  // namespace trephine::bone_flap
