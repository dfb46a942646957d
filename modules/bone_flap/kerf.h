// Path of a saw that follows a pyramid's sides through the calvaria, and distances to it.
#pragma once

#include <unordered_map>

#include "modules/bone_flap/outline.h"
#include "volume/removal.h"

namespace trephine::bone_flap {

/// mm that a kerf goes on beyond the inner and the outer table, so that the flap comes free.
inline constexpr double k_under_table = 0.25;

/// Depth of the saw, mm.
struct Depth {
  double hole = 5;       ///< along the outline: wider than that without bone is no seam
  double space = 3;      ///< air within the bone, through which it goes on to what lies deeper
  double thickest = 25;  ///< bone that goes on deeper is no calvaria
};

/// "between anchors 3 and 4", of so many.
std::string between_anchors(std::size_t side, std::size_t count);

/// Surface that the saw's middle sweeps: flat strips between lines from the apex through the outline, each
/// from under the inner table to above the outer one.
class Sheet {
 public:
  /// A line from the apex, and where the sheet begins and ends on it.
  struct Line {
    std::size_t side;     ///< of the pyramid, from its anchor of that number on
    glm::dvec3 along;     ///< unit, outward
    double outer, inner;  ///< mm from the apex: the tables
    double from, to;      ///< of the sheet
    bool is_on_anchor, is_bone;
  };

  /// `width`: mm, the saw's. False: there is no calvaria all along the outline.
  bool make(const Pyramid& pyramid, const volume::Field& bone, double width, const Depth& depth,
            Trouble& trouble);

  const Pyramid& pyramid() const noexcept { return pyramid_; }
  const std::vector<Line>& lines() const noexcept { return lines_; }  ///< round, in the order of anchors
  double width() const noexcept { return width_; }
  glm::dvec3 place(const Line& line, double t) const noexcept { return pyramid_.apex_world + t * line.along; }
  glm::dvec3 outer_place(std::size_t i) const noexcept { return place(lines_[i], lines_[i].outer); }
  /// Places at which its lines meet the skull's outside, and at which they end below.
  std::vector<glm::dvec3> outline() const;
  std::vector<glm::dvec3> floor() const;
  /// mm2 of the sheet that lies in bone that is there.
  double wall_mm2(const volume::Field& bone, const volume::Version& before) const;
  /// The skull's outer surface within the sheet, opened before or not: lines from its middle to the outline,
  /// each of as many places; about `step` mm between them both ways.
  struct Lid {
    std::vector<std::size_t> rim;               ///< the sheet's lines to which they lead
    std::vector<std::vector<glm::dvec3>> grid;  ///< one a line, from the middle outward
  };
  Lid lid(const volume::Field& bone, double step) const;
  /// mm2 of that surface.
  double outer_mm2(const volume::Field& bone) const;

  /// A strip, between line `i` and the next.
  struct Strip {
    glm::dvec3 corners[4];  ///< round: two on this line, two on the next
    glm::dvec3 normal;      ///< unit
    glm::dvec3 middle;      ///< of a ball around it ...
    double reach;           ///< ... and how large that is
    std::size_t side;       ///< of the pyramid
  };
  Strip strip(std::size_t i) const noexcept;
  /// Square of a point's distance to a strip.
  static double distance_square(const Strip& strip, const glm::dvec3& p_world) noexcept;
  /// Does the way between two points go through the strip?
  static bool crosses(const Strip& strip, const glm::dvec3& a, const glm::dvec3& b) noexcept;

 private:
  bool find_tables(const volume::Field& bone, const Depth& depth, Trouble& trouble);
  bool check_holes(double largest, Trouble& trouble);
  bool check_scan(const volume::Volume& scan, Trouble& trouble) const;

  Pyramid pyramid_;
  std::vector<Line> lines_;
  double width_ = 0;
};

/// A sheet's kerf on a cut lattice: what is not farther from it than half the saw's width.
class Kerf final : public volume::RemovalField {
 public:
  /// `beyond`: mm that are asked about farther away than the band.
  Kerf(const Sheet& sheet, const volume::Version& version, double beyond = 0);
  Reach find(const glm::ivec3& low, double band, Distances& mm) override;
  /// Samples that it may reach.
  const volume::VoxelBox& samples() const noexcept { return box_; }

  /// Ways between neighbouring samples (26 around each) of what is left that go through the sheet: each lets
  /// a flood through.
  std::int64_t count_holes(const volume::Field& bone, const volume::Version& left) const;

 private:
  const Sheet& sheet_;
  const volume::CutLattice lattice_;
  std::vector<Sheet::Strip> strips_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> near_;  ///< strips, by brick
  volume::VoxelBox box_;
};

/// The other way, of the thesis "A Surface-based Volume Haptics Approach" (5.2.3): all voxels that lines from
/// the apex to places of the outline go through, exactly. Kept for comparison with the kerf: it has
/// holes.
class TracedVoxels final : public volume::RemovalField {
 public:
  /// `step`: mm between places along the outline.
  TracedVoxels(const Sheet& sheet, const volume::Version& version, double step);
  Reach find(const glm::ivec3& low, double band, Distances& mm) override;
  const volume::VoxelBox& samples() const noexcept { return box_; }
  std::size_t count() const noexcept { return count_; }

 private:
  const volume::CutLattice lattice_;
  std::unordered_map<std::uint64_t, std::vector<glm::ivec3>> near_;  ///< voxels, by brick
  volume::VoxelBox box_;
  std::size_t count_ = 0;
};

}  // namespace trephine::bone_flap
