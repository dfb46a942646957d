// SRC: a scan that open_volume reads, a case, or a phantom that is built in; and which shape of it is meant.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/workbench/listener.h"
#include "data-tools/case_folder.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::workbench {

/// From `iso` up, a window "LO:HI", or a label; at most one, of which the largest part or all.
struct ShapeChoice {
  std::optional<double> iso;
  std::string window, label;
  bool is_auto = false;     ///< where nothing says what is solid: from where the histogram parts
  bool is_largest = false;  ///< of the shape only its largest part
  bool is_made() const { return iso || !window.empty() || !label.empty(); }
};

/// A scan, and what may be asked of its reading.
struct SourceChoice {
  std::string path;
  int series = 0, volume = 0;   ///< of several, from 1; 0: the one most probably meant
  bool is_resampled = false;    ///< missing and uneven slices are interpolated
  bool maps_padding = false;    ///< the scanner's padding becomes air
  bool is_hounsfield = false;   ///< its values are, though its file does not say so
  bool takes_plan = false;      ///< of a phantom that is built in: what is touched, what must not be cut
  std::optional<double> scale;  ///< a voxel's step in the file's units
  std::string spacing;          ///< "X,Y,Z" or "S" in mm, of a file that does not say it
  std::string axes;             ///< where its axes go: three letters; empty: "LPS"
  std::string raw;              ///< layout of numbers without a header
  bool takes_sform = false, takes_qform = false;  ///< of NIfTI, where they disagree
  SourceChoice() = default;
  SourceChoice(std::string of) : path(std::move(of)) {}
  SourceChoice(const char* of) : path(of) {}
};

struct Source {
  std::shared_ptr<const volume::Volume> volume;
  std::string name, format, modality;  ///< what to call it: never a path
  std::string case_name;               ///< a name that was chosen for it, to be written down; else empty
  /// For what is kept in files, pictures too: never what a folder or file is called.
  std::string written_name() const { return case_name.empty() ? "scan" : case_name; }
  bool is_builtin = false;
  bool is_altered = false;                   ///< on purpose, after it was read: this scan exists only here
  std::optional<data_tools::CasePlan> plan;  ///< of a case
  std::vector<std::string> notices;
  std::vector<std::pair<std::string, std::string>> facts;  ///< parameters of the scanner, anonymous
  std::vector<data_tools::SeriesFacts> series;             ///< what else could have been opened
  std::vector<data_tools::SegmentFacts> segments;          ///< of a segmentation
  double read_seconds = 0;
};

/// Is it the name of a phantom that is built in, "head" or "spine"?
bool is_builtin(const std::string& src);
/// Opens `src`, and reports its notices.
volume::Result<Source> open_source(const SourceChoice& choice, const Listener& listener = {});
/// In place of the scan its Gaussian; sigma in voxels, of which check(OperationChoice) says whether it may
/// be.
volume::Status blur(Source& source, double sigma);
/// Replaces the scan by one without a shape's other parts; reports how many.
volume::Status keep_largest(Source& source, const volume::Shape& shape, const Listener& listener = {});
/// Says so when other parts of a shape are large enough to be in the way: a table, a head holder.
void offer_largest(const Source& source, const volume::Shape& shape, const Listener& listener);
/// Checks that need no scan.
volume::Status check(const ShapeChoice& choice);
/// The chosen shape; CT without a choice is bone from 300 HU, with a notice. Error when there is no
/// default.
volume::Result<volume::Shape> choose_shape(const Source& source, const ShapeChoice& choice,
                                           const Listener& listener = {});
/// A path file, or what is wrong with it.
volume::Result<haptics::PosePath> open_path(const std::string& path);

}  // namespace trephine::workbench
