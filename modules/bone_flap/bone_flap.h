// BoneFlap: a saw follows an outline drawn on the skull and detaches the bone inside it.
#pragma once

#include "sim/api/module.h"

namespace trephine::bone_flap {

/// Width of the saw's cut: w0_8 is 0.8 mm.
enum class Saw : std::uint8_t { w0_8, w1_2, w1_6, w2_0, w2_4 };
double width_of(Saw saw) noexcept;  ///< mm

inline constexpr std::int64_t k_max_anchors = 1000;

// Commands that draw an outline anchor by anchor. The outline is a setting: undo does not change it.

/// Appends an anchor.
struct AddAnchor {
  glm::dvec3 at{0.0};  ///< mm, world: position on the skull
  static const sim::Schema& schema();
};
struct MoveAnchor {
  std::int64_t number = 1;  ///< starts at 1
  glm::dvec3 at{0.0};       ///< mm, world
  static const sim::Schema& schema();
};
struct RemoveAnchor {
  std::int64_t number = 0;  ///< starts at 1; 0: the last anchor
  static const sim::Schema& schema();
};
struct ClearAnchors {
  static const sim::Schema& schema();
};

/// Job that cuts a flap. The anchors are on the skull, in their order around the outline.
struct CutFlap {
  std::string outline = {};  ///< name of an outline of the plan; empty: `anchors`
  /// mm, world; empty: the drawn anchors, or without these the only outline of the plan
  std::vector<glm::dvec3> anchors = {};
  Saw saw = Saw::w1_6;
  double distance = 70;  ///< mm, from the outline's centre to the apex
  /// Position on the flap, mm, world; empty: bone on the normal through the outline's centre, or near it.
  std::vector<glm::dvec3> seed = {};
  std::vector<sim::Id> leave = {};            ///< numbers of pieces that are not detached; 1 is the largest
  double smoothing = 0;                       ///< mm, sigma of a Gaussian over the rim; 0: sharp
  double smallest = 50;                       ///< mm3; smaller pieces, except that of the seed, are debris
  double hole = 5, space = 3, thickest = 25;  ///< mm; see SawLimits
  std::int64_t item = 0;                      ///< index of the skull's shape in the anatomy
  static const sim::Schema& schema();
};

/// Job that previews a flap, and changes no anatomy. The preview shows the path of the saw and the flap until
/// the outline changes.
struct PreviewFlap {
  std::string outline = {};              ///< as in CutFlap
  std::vector<glm::dvec3> anchors = {};  ///< as in CutFlap
  Saw saw = Saw::w1_6;
  double distance = 70;  ///< mm
  std::int64_t item = 0;
  static const sim::Schema& schema();
};

/// Last cut. Part of the undoable state.
struct FlapState {
  std::int64_t flaps = 0;           ///< number of cuts so far
  std::vector<glm::dvec3> outline;  ///< mm, world: path of the saw's centre on the outer table
  std::vector<glm::dvec3> floor;    ///< mm, world: deepest point of the saw at each outline point
  glm::dvec3 centre{0.0}, normal{0.0}, apex{0.0};  ///< world, mm; the normal is a unit vector
  double width = 0, area = 0, wall = 0;            ///< saw's width, mm; outer surface and sawn walls, mm2
  /// Volumes, mm3: bone removed by the saw, bone removed by smoothing, and the detached pieces.
  double kerf_size = 0, rim_size = 0, flap_size = 0;
  static const sim::Schema& schema();
};

/// Drawn outline. Not changed by undo.
struct FlapSettings {
  std::vector<glm::dvec3> anchors;  ///< drawn outline, mm, world
  static const sim::Schema& schema();
};

/// Result of this module: the preview of a flap, and the reason why the last attempt failed.
struct FlapPreview {
  std::vector<glm::dvec3> failed_anchors;  ///< anchors of the last attempt that failed, mm, world
  std::string problem;                     ///< reason of that failure; empty: no failure
  glm::dvec3 problem_at{0.0};              ///< location of the problem, mm, world
  /// Preview on the skull, mm, world: lines from the centre to the outline, each of lid_rings + 1 points.
  std::vector<glm::dvec3> lid = {};
  std::int64_t lid_rings = 0;
  std::vector<glm::dvec3> depth = {};  ///< deepest point of the saw at the outer end of each line, mm, world
  std::string summary = {};            ///< empty: no preview
  static const sim::Schema& schema();
};

/// Emitted at the outline's centre after a cut.
struct FlapCut {
  std::int64_t pieces = 0;  ///< number of pieces inside the outline, detached or not
  /// Areas and volumes, as in FlapState.
  double area = 0, wall = 0, kerf_size = 0, rim_size = 0, flap_size = 0;
  std::int64_t holes = 0;  ///< pairs of neighbouring samples that are connected through the cut
  static const sim::Schema& schema();
};
/// Emitted at the piece's centre.
struct FlapPiece {
  std::int64_t number = 0;  ///< rank by size; 1 is the largest
  double size = 0;          ///< mm3
  bool is_seed = false, is_detached = false;
  bool is_at_border = false;  ///< the piece reaches the border of the scan
  static const sim::Schema& schema();
};
/// Result of a preview. Emitted at the outline's centre, or at the location of the problem if the cut would
/// fail.
struct FlapPreviewed {
  double area = 0;      ///< mm2 of the outer surface; 0: the cut would fail
  std::string summary;  ///< of the flap, or the reason for the failure
  static const sim::Schema& schema();
};
/// Failure of a cut. Emitted at the location of the problem.
struct FlapFailed {
  std::string reason;
  std::int64_t holes = 0;  ///< as in FlapCut
  static const sim::Schema& schema();
};

class BoneFlap final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "bone_flap"; }
  std::uint32_t version() const noexcept override { return 3; }  // 3: volumes are those of the bodies
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value undoable() const override { return FlapState{}; }
  sim::Value settings() const override { return FlapSettings{}; }
  sim::Value result() const override { return FlapPreview{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  std::vector<sim::Finding> findings(const sim::JobInput& input) const override;
  sim::Overlays overlays(const sim::OperationState& operation) const override;
};

}  // namespace trephine::bone_flap
