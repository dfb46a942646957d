// ReportData: contents of a report on a recorded session as plain data, from one replay.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/workbench/moment.h"
#include "apps/workbench/timeline.h"
#include "apps/workbench/tool_path.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "sim/api/finding.h"

namespace trephine::workbench {

/// Least and greatest values by column of a chart over time: no peak is lost at any width.
class Envelope {
 public:
  struct Column {
    double low = 0, high = 0;
    bool has_value = false;
  };
  Envelope() = default;
  /// Divides the ticks 0 .. tick_count - 1 into columns; both at least 1.
  Envelope(std::uint64_t tick_count, std::size_t column_count);
  /// Ignores ticks beyond the last one.
  void add(std::uint64_t tick, double value) noexcept;
  std::span<const Column> columns() const noexcept { return columns_; }
  /// Greatest value; 0 without values.
  double greatest() const noexcept;

 private:
  std::uint64_t tick_count_ = 1;
  std::vector<Column> columns_;
};

/// Removed and detached matter by distance to a structure that must not be cut.
struct RemovalDistances {
  static constexpr std::size_t k_bins = 20;  ///< of 1 mm
  std::string structure;
  std::array<double, k_bins> mm3{};              ///< bin i: from i to i + 1 mm
  double inside_mm3 = 0;                         ///< in the structure
  double beyond_mm3 = 0;                         ///< at k_bins mm or more
  double within(std::size_t mm) const noexcept;  ///< at less than `mm`, and inside
};
/// Sums the cells of the cut lattice whose centres are removed, and were solid in one of `solids`.
RemovalDistances removal_distances(const volume::Version& version, std::span<const volume::Field> solids,
                                   const sim::Forbidden& structure);

/// State at a decisive moment, for pictures.
struct ReportMoment {
  std::uint64_t tick = 0;
  double seconds = 0;
  std::string text;
  EventLevel level = EventLevel::outcome;
  glm::dvec3 position_world{0.0};                       ///< mm
  std::optional<fluoroscopy::XrayTaken> xray = {};      ///< an X-ray was taken
  std::shared_ptr<const volume::Version> version = {};  ///< frozen
  std::vector<Moment::Object> objects = {};
};

struct ReportChoice {
  std::string session;
  SourceChoice case_source;                     ///< scan of a session that lacks it
  std::size_t column_count = 900;               ///< of the charts
  std::size_t slice_count = 6, xray_count = 4;  ///< greatest number of pictures of each kind
};

struct ReportData {
  std::unique_ptr<OpenedSession> session;  ///< at its end
  double seconds = 0;
  sim::Score score;
  Timeline timeline;
  Envelope force;      ///< N, the strongest of all hands in each tick
  Envelope clearance;  ///< mm from the nearest tool to a forbidden structure; without structures no values
  std::vector<ToolPath> paths;            ///< one per hand
  glm::dvec3 mean_hand_position{0.0};     ///< mm, mean position of the hands: the side from which they work
  std::vector<RemovalDistances> removal;  ///< one per forbidden structure
  std::vector<ReportMoment> moments;      ///< by time
  sim::Overlays overlays;                 ///< at the end
  double removed_mm3 = 0;

  const sim::SessionHeader& header() const noexcept { return session->reader->header(); }
  const sim::Engine& engine() const noexcept { return session->replay->engine(); }
};

/// Replays a session once and collects the contents of its report. Error: the session cannot be opened, or
/// the listener stopped the work.
Result<ReportData> collect_report(const ReportChoice& choice, const Listener& listener = {});

}  // namespace trephine::workbench
