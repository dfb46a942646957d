// From what a person or a script asks for to what an engine starts from: the one place that puts a scan, a
// shape, hands and their tools together.
#pragma once

#include "apps/workbench/source.h"
#include "data-tools/screw_model.h"
#include "sim/overlay.h"
#include "sim/scene_spec.h"

namespace trephine::workbench {

/// A polygonal model to touch.
struct ModelChoice {
  std::string file;
  double mm_per_unit = 1;
  std::string frame;                                           ///< "LPS" or "RAS"; empty: as the file says
  glm::dvec3 at_world{0.0};                                    ///< where its origin lies
  std::optional<data_tools::ScrewPlace> screw = std::nullopt;  ///< in place of a file
  /// It is touched by depth images. `file` may be a folder then: of models that have the same triangles, by
  /// their names, which it looks like a beat after another.
  bool is_depth = false;
  double beat = 1.0 / 30;     ///< s
  bool is_repeating = false;  ///< after the last comes the first
  double pixel = 0.2;         ///< mm
  double rate = 100;          ///< Hz, of depth images
  /// Intrinsics of a depth video without them: fx, fy, cx, cy, pixels.
  std::optional<std::array<double, 4>> intrinsics = std::nullopt;
  std::optional<double> mm_per_value = std::nullopt;  ///< of a depth video that does not state it
  /// It is touched as the picture of it on the screen; all of those are one object.
  bool is_background = false;
};

/// The chosen surface, at its file's or its given place; reports what was assumed.
volume::Result<std::shared_ptr<const haptics::MeshTree>> load_model(const ModelChoice& choice,
                                                                    std::size_t number,
                                                                    const Listener& listener);

/// Given properties of a surface; the others stay as they are.
struct MaterialChoice : data_tools::CaseMaterial {
  std::optional<double> viscosity, pop_force;
  haptics::Material over(haptics::Material under) const;
};

/// Options of an operation, in addition to its scan.
struct OperationChoice {
  ShapeChoice shape;  ///< none: a case's touchable structures, or bone
  /// One at least. A tool radius of 0 is that which the instrument needs.
  std::vector<sim::HandSpec> hands{sim::HandSpec()};
  MaterialChoice material;  ///< of the chosen shape (of a case: its first) and of models
  std::optional<haptics::StiffnessRamp> ramp;
  std::vector<ModelChoice> models;
  double rate_hz = 1000;
  haptics::ForceOptions force;
  /// mm, of what will ever cut; nothing: what the hands begin with.
  std::optional<double> smallest_burr;
  bool cuts_by_command = false;  ///< so that what must not be cut matters, whatever hands hold
  double blur_voxels = 0;        ///< sigma of a Gaussian over the scan, first
};

/// Ready to begin.
struct Operation {
  Source source;
  sim::SceneSpec spec;  ///< what was made: a session's header
  sim::OperationStart start;
  double making_seconds = 0;  ///< bits, fields, methods

  /// Scene of the first hand, and its method.
  const std::shared_ptr<const haptics::TouchScene>& scene() const { return start.hands[0].feels.scene; }
  const haptics::ProxyMethod& method() const { return *start.hands[0].feels.method; }
  haptics::ServoOptions servo() const;
  sim::Engine engine() const;
};

/// Trajectories and landmarks of a plan as what a view shows: lines that begin before the bone, with names.
sim::Overlays plan_overlays(const data_tools::CasePlan& plan);

/// Checks that need no work: names, ranges, words. Parses the hands' instruments.
volume::Status check(const OperationChoice& choice);
/// Error names what it speaks of by the names above: "iso", "smallest burr", "tool radius", "method" ...
volume::Result<Operation> open_operation(const SourceChoice& src, const OperationChoice& choice,
                                         const Listener& listener = {});
volume::Result<Operation> make_operation(Source source, const OperationChoice& choice,
                                         const Listener& listener = {});

/// A scan with what can be touched of it, for programs that neither record nor cut. A case gives all its
/// touchable structures; shapes of two values are made smooth.
struct OpenedTouch {
  Source source;
  haptics::TouchScene scene;
  double making_seconds = 0;
};
volume::Result<OpenedTouch> open_touch(const SourceChoice& src, const ShapeChoice& choice,
                                       const Listener& listener = {});

}  // namespace trephine::workbench
