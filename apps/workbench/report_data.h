// ReportData: contents of a report on a recorded session as plain data, collected in one replay.
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

/// Least and greatest value in each column of a chart over time: no peak is lost at any width of the chart.
class Envelope {
 public:
  struct Column {
    double low = 0, high = 0;
    bool has_value = false;
  };
  Envelope() = default;
  /// Divides the ticks 0 .. tick_count - 1 into columns. Counts of 0 become 1; there are at most as many
  /// columns as ticks.
  Envelope(std::uint64_t tick_count, std::size_t column_count);
  /// Ignores ticks beyond the last one.
  void add(std::uint64_t tick, double value) noexcept;
  std::span<const Column> columns() const noexcept { return columns_; }
  /// Greatest value; 0 without values or if all are negative.
  double greatest() const noexcept;

 private:
  std::uint64_t tick_count_ = 1;
  std::vector<Column> columns_;
};

/// Volume of removed and detached matter, by its distance from a structure that must not be cut.
struct RemovalDistances {
  static constexpr std::size_t k_bins = 20;  ///< of 1 mm
  std::string structure;
  std::array<double, k_bins> mm3{};              ///< bin i: at i to i + 1 mm from the structure
  double inside_mm3 = 0;                         ///< in the structure
  double beyond_mm3 = 0;                         ///< at k_bins mm or more
  double within(std::size_t mm) const noexcept;  ///< at less than `mm` (at most k_bins), and inside
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
  std::optional<fluoroscopy::XrayTaken> xray = {};      ///< if an X-ray was taken at this moment
  std::shared_ptr<const volume::Version> version = {};  ///< frozen
  std::vector<Moment::Object> objects = {};
};

struct ReportChoice {
  std::string session;
  SourceChoice case_source;                     ///< scan, for a session that does not contain it
  std::size_t column_count = 900;               ///< of the charts
  std::size_t slice_count = 6, xray_count = 4;  ///< greatest number of slices and of X-rays
};

struct ReportData {
  std::unique_ptr<OpenedSession> session;  ///< replayed to its end
  double seconds = 0;
  sim::Score score;
  Timeline timeline;
  Envelope force;      ///< N, strongest force of all hands in each tick
  Envelope clearance;  ///< mm, least distance of a tool from a forbidden structure; empty without structures
  std::vector<ToolPath> paths;            ///< one per hand
  glm::dvec3 mean_hand_position{0.0};     ///< mm; shows the side from which the hands work
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
