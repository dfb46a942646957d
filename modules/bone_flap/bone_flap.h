// A bone flap: a saw follows the outline that was drawn on the skull, and what lies within comes off.
#pragma once

#include "sim/module.h"

namespace trephine::bone_flap {

/// Width of the saw's cut, mm: choices of a list.
enum class Saw : std::uint8_t { w0_8, w1_2, w1_6, w2_0, w2_4 };
double width_of(Saw saw) noexcept;

/// Method of the cut: a kerf as wide as the saw along the sides of a pyramid, or the voxels that lines from
/// its apex to the outline go through ("A Surface-based Volume Haptics Approach", thesis, 5.2.3), which leave
/// holes.
enum class Way : std::uint8_t { kerf, traced };

inline constexpr std::int64_t k_most_anchors = 1000;

// An outline that is drawn anchor by anchor. It is a setting: undo leaves it alone.

/// One more, after the last.
struct AddAnchor {
  glm::dvec3 at{0.0};  ///< mm, world, on the skull
  static const sim::Schema& schema();
};
struct MoveAnchor {
  std::int64_t number = 1;  ///< from 1 on
  glm::dvec3 at{0.0};
  static const sim::Schema& schema();
};
struct RemoveAnchor {
  std::int64_t number = 0;  ///< 0: the last
  static const sim::Schema& schema();
};
struct ClearAnchors {
  static const sim::Schema& schema();
};

/// A job. Its anchors stand on the skull, in their order round.
struct CutFlap {
  std::vector<glm::dvec3> anchors = {};  ///< mm, world; none: those that were drawn
  Saw saw = Saw::w1_6;
  double distance = 70;  ///< mm, from the outline's middle to the apex
  Way way = Way::kerf;
  std::vector<glm::dvec3> seed = {};  ///< a place on the flap; none: where the middle's normal meets bone
  std::vector<sim::Id> leave = {};    ///< numbers of pieces that stay, from the largest on
  double smoothing = 0;               ///< mm, sigma of a Gaussian over the rim; 0: sharp
  double smallest = 50;               ///< mm3; less is debris
  double hole = 5, space = 3, thickest = 25;  ///< mm; modules/bone_flap/kerf.h
  std::int64_t item = 0;                      ///< the shape that is skull, of those of the anatomy
  static const sim::Schema& schema();
};

/// A job that cuts nothing: shows where the saw would go, and what would come off, until the outline changes.
struct PreviewFlap {
  std::vector<glm::dvec3> anchors = {};  ///< as for CutFlap
  Saw saw = Saw::w1_6;
  double distance = 70;  ///< mm
  std::int64_t item = 0;
  static const sim::Schema& schema();
};

/// Last cut. Undo takes it back.
struct FlapWorld {
  std::int64_t flaps = 0;
  std::vector<glm::dvec3> outline;  ///< on the skull's outside, where the saw's middle went ...
  std::vector<glm::dvec3> floor;    ///< ... and as deep as it went there
  glm::dvec3 centre{0.0}, normal{0.0}, apex{0.0};
  double width = 0, area = 0, wall = 0;               ///< mm, mm2 of the outside and of the walls
  double kerf_size = 0, rim_size = 0, flap_size = 0;  ///< mm3
  static const sim::Schema& schema();
};

/// The outline that is drawn, that for which there was no flap last, and why; what a flap would be.
struct FlapSettings {
  std::vector<glm::dvec3> anchors;  ///< drawn
  std::vector<glm::dvec3> tried;    ///< anchors of the last attempt that failed
  std::string trouble;
  glm::dvec3 trouble_at{0.0};
  std::vector<glm::dvec3> lid = {};    ///< on the skull: lines from the middle to the outline, ...
  std::int64_t lid_rings = 0;          ///< ... of so many places and one each
  std::vector<glm::dvec3> depth = {};  ///< how deep the saw would go at the end of each
  std::string preview = {};            ///< in words
  static const sim::Schema& schema();
};

/// Emitted at the outline's middle.
struct FlapCut {
  std::int64_t pieces = 0;  ///< within the outline, taken or left
  double area = 0, wall = 0, kerf_size = 0, rim_size = 0, flap_size = 0;
  std::int64_t holes = 0;  ///< ways through the cut, of those between neighbouring samples
  static const sim::Schema& schema();
};
/// Emitted at the piece's middle.
struct FlapPiece {
  std::int64_t number = 0;  ///< by size, from 1
  double size = 0;          ///< mm3
  bool is_seed = false, is_taken = false, is_at_border = false;
  static const sim::Schema& schema();
};
/// Result of a preview: emitted at the outline's middle, or where the cut fails.
struct FlapSeen {
  double area = 0;  ///< mm2; 0: the cut fails
  std::string says;
  static const sim::Schema& schema();
};
/// Emitted at the location of the problem.
struct NoFlap {
  std::string why;
  std::int64_t holes = 0;
  static const sim::Schema& schema();
};

class BoneFlap final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "bone_flap"; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value world() const override { return FlapWorld{}; }
  sim::Value settings() const override { return FlapSettings{}; }
  volume::Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
  sim::Overlays overlays(const sim::OperationState& now) const override;
};

}  // namespace trephine::bone_flap
