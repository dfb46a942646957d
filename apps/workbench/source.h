// SRC: a scan that open_volume reads, a case, or the built-in head; and which shape of it is meant.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/trephine/report.h"
#include "data-tools/case_folder.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"
#include "modules/drilling/burr.h"
#include "volume/version.h"

namespace trephine::app {

/// --iso V, --window LO:HI or --label NAME; at most one.
struct ShapeChoice {
  std::optional<double> iso;
  std::string window, label;
};

struct Source {
  std::shared_ptr<const volume::Volume> volume;
  std::string name, format, modality;  ///< what to call it: never a path
  std::string case_name;               ///< a name that was chosen for it, to be written down; else empty
  /// For what is kept in files, pictures too: never what a folder or file is called.
  std::string written_name() const { return case_name.empty() ? "scan" : case_name; }
  bool is_builtin = false;
  std::optional<data_tools::CasePlan> plan;  ///< of a case
  std::vector<std::string> notices;
  double read_seconds = 0, bits_seconds = 0;
};

/// Opens `src`; says its notices on stderr when it is a person who reads.
volume::Result<Source> open_source(const std::string& src);
/// The shape that is meant; CT without a choice is bone from 300 HU, which is said. Error when there is no
/// default.
volume::Result<volume::Shape> choose_shape(const Source& source, const ShapeChoice& choice);
/// A scene with that one shape, its bits made. A case without a choice gives all its touchable structures.
volume::Result<haptics::TouchScene> make_scene(Source& source, const ShapeChoice& choice,
                                               bool is_soft = true);
/// Both at once: what most commands begin with. The scene borrows the scan that the source holds.
struct OpenedTouch {
  Source source;
  haptics::TouchScene scene;
};
/// `is_soft`: binary shapes are made smooth, for methods that touch the smooth solid. `blur_voxels`: sigma of
/// a Gaussian over the intensities, first.
volume::Result<OpenedTouch> open_touch(const std::string& src, const ShapeChoice& choice, bool is_soft = true,
                                       double blur_voxels = 0);
/// A path file, or what is wrong with it.
volume::Result<haptics::PosePath> open_path(const std::string& path);
/// Error when `output` is one of the files that a command reads or records, lies among those of a folder, or
/// holds the voxels of a header: nothing that was given is lost.
volume::Status check_apart(const std::string& output, const std::vector<std::string>& others);
/// haptics::set_tool_radius(), and a word on stderr where it takes seconds.
volume::Status make_round(haptics::TouchScene& scene, double radius);
/// When a path met nothing: says where the shape lies and where the path went.
void say_where(const haptics::TouchScene& scene, const haptics::PosePath& path);
/// Options that several commands share.
volume::Status check_rate(double rate_hz);
volume::Status check_burr(double diameter_mm);
/// Makes a scene ready for a burr, and for smaller ones down to `wanted`, else `usual` (mm, diameter); or for
/// the touch of a round one, which is the smallest.
volume::Status make_ready_for(drilling::Burr& burr, std::optional<double> wanted, double usual,
                              haptics::TouchScene& scene);
/// The shape in words, for reports: "300 HU and above", "label dura".
std::string describe(const volume::Shape& shape, bool is_hounsfield);
/// Memory by our own accounting: base voxels, labels, bits and tables.
Json memory_report(const haptics::TouchScene& scene, const volume::Version& version);

}  // namespace trephine::app
