// Contact methods on one chart of run time against error: rows of `trephine-bench feel`.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/measure.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_state.h"

namespace trephine::bench {

/// A scene with a motion of the HIP over it.
struct FeelScene {
  std::string name;      ///< "sphere"
  std::string variant;   ///< "psf 1.5", "noise 20 HU", ...
  std::string motion;    ///< "slide 100 mm/s"
  double radius_mm = 0;  ///< of the tool
  std::string group;     ///< "smooth", "sharp", "rough" or "real": selects the requirements
  haptics::TouchScene scene;
  haptics::PosePath path;
  double field_s = 0;         ///< to build the tool's offset field, before the first step
  double field_update_s = 0;  ///< to update this field after the hole is drilled; not part of a step
  std::shared_ptr<const haptics::TouchState> drilled = nullptr;  ///< null: uncut
  haptics::TouchState touch_state() const {
    return drilled ? *drilled : haptics::TouchState(std::make_shared<volume::Version>(scene.base));
  }

  /// Signed distance (mm, negative inside) to the region forbidden to the tool's centre; empty for scans.
  std::function<double(const glm::dvec3&)> distance;
  double plate_mm = 0;          ///< thickness, if the shape is a plate
  bool has_outer_edge = false;  ///< the shape has a convex edge, which blurred samples blunt by up to a voxel
};

/// Result of one method on one scene. Errors are in voxels (the shortest step of the grid) or in the unit of
/// their name; empty if they cannot be measured for the scene or the method.
struct FeelRow {
  std::string scene, variant, motion, group, method;
  int size = 0;
  double radius_mm = 0;
  long steps = 0, contacts = 0;
  std::optional<double>
      method_error_voxels;  ///< largest distance, over all steps, from an ideal proxy on the same solid
  /// RMS distance from the analytic surface, of the proxy and of an ideal proxy on the smooth solid of the
  /// samples. The second is the error that the samples alone cause.
  std::optional<double> total_rms_voxels, floor_rms_voxels;
  std::optional<double> deepest_voxels;     ///< largest depth in the analytic shape
  std::optional<double> max_deviation_mm;   ///< largest distance from an ideal proxy on the analytic shape
  std::optional<double> direction_rms_deg;  ///< angle between the raw and the exact force
  /// Distance from the ideal proxy on the analytic shape, along its surface.
  std::optional<double> tangential_p50_mm, tangential_p99_mm;
  std::optional<double> force_rms_n;  ///< stiffness times the distance from this ideal proxy
  std::optional<double>
      rendered_rms_n;           ///< force with damping and smoothing, minus stiffness times exact offset
  double rough_n = 0;           ///< RMS of the raw force above 20 Hz
  double rough_smoothed_n = 0;  ///< the same at the default smoothing
  double jump_n = 0;            ///< mean change of the raw force when the proxy enters another voxel
  double max_change_n = 0;      ///< largest change of the raw force between two ticks in contact
  long fall_throughs = 0, stuck = 0;
  long other_rest = 0;  ///< number of times that the proxy came to rest elsewhere than the ideal proxy
  long ghosts =
      0;  ///< steps in contact while the ideal proxy is free and the proxy more than a voxel from the HIP
  long missed = 0;  ///< steps without contact while the ideal proxy presses by more than a voxel
  long buried = 0;  ///< steps that reported restored matter over the proxy; these scenes restore none
  StepTimes time_us;
  /// CPU instructions per step in contact, from a single-stepped process (apps/bench/instructions.h).
  /// Measured on the reference scene only.
  std::optional<double> instructions;
  double voxels = 0, cells = 0, triangles = 0, queries = 0;  ///< per step
  double field_s = 0, field_update_s = 0;                    ///< of the offset field, as in the scene
  std::size_t bytes = 0;                                     ///< memory in addition to the voxels
};

struct FeelScaling {
  std::string method;
  bool has_smaller_voxels =
      false;  ///< one box in voxels of decreasing size; otherwise equal voxels in boxes of increasing size
  int size = 0;
  StepTimes time_us;
};

/// |force| along a slide, or while the hand presses and the HIP is updated less often than the servo runs.
struct FeelTrace {
  std::string method;
  bool is_pressing = false;
  std::vector<double> t, raw_n, smoothed_n;
};

/// Results of another program for exported scenes: a proxy per step, in the order of hip.csv.
struct FeelResults {
  std::string program;                                           ///< its name on the chart
  std::map<std::string, std::vector<glm::dvec3>> proxies_world;  ///< by the scene's id
  std::map<std::string, std::vector<double>> us;                 ///< per step, if given
};

/// "sphere-psf-1.5-slide-100-mm-s": a scene's name in files.
std::string feel_id(const std::string& name, const std::string& variant, const std::string& motion);
inline std::string feel_id(const FeelScene& s) { return feel_id(s.name, s.variant, s.motion); }

struct FeelOptions {
  bool is_quick = false;
  /// Called with a method's results for a scene, a proxy per step.
  std::function<void(const FeelScene&, const std::string& method, const std::vector<glm::dvec3>& proxies)>
      on_results;
  std::string only;  ///< play built-in scenes whose id contains this, and measure no scaling; empty: all
  std::vector<std::string>
      methods;  ///< play these methods and peers; scaling is measured for all methods; empty: all
  std::optional<FeelResults> results;
  /// Called with each scene before it is played, for example to export it. A failure ends the run.
  std::function<Status(const FeelScene&)> inspect;
  std::vector<FeelScene> more;           ///< played after the built-in scenes, for example scans
  std::function<bool(double)> progress;  ///< fraction done; returning false stops
};

/// Parts of the time of a step that builds its surface on the fly (Jiang, dissertation, table V): medians
/// over contact steps, us.
struct FeelSplit {
  std::string method;
  double traversal_us = 0, net_us = 0, rest_us = 0;
};

struct FeelReport {
  std::vector<FeelSplit> split;
  std::vector<FeelRow> rows;
  std::vector<FeelScaling> scaling;
  std::vector<FeelTrace> traces;
  std::vector<std::pair<std::string, std::string>> peers;  ///< name and version of the peers built in
  bool is_stopped = false;
  Status failure;
};

/// Calls use(scene) for the built-in scenes whose id contains `only`, built one at a time, until it returns
/// false. Quick ones are smaller and fewer.
void for_feel_scenes(bool is_quick, const std::string& only, const std::function<bool(FeelScene&&)>& use);
std::vector<std::string> feel_scene_ids(bool is_quick);
/// Returns the names of all methods and peers.
std::vector<std::string> feel_methods();
FeelReport run_feel(const FeelOptions& options);

/// Returns the path of a HIP, for FeelOptions::more: it comes from above (along -z) and slides along a line
/// across the scan, `depth` mm below the first bone, at `speed` mm/s; `samples` positions at 1 kHz.
haptics::PosePath slide_over(const haptics::TouchScene& scene, double speed, double depth, int samples);

}  // namespace trephine::bench
