#include "apps/workbench/report_data.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <map>

#include "apps/workbench/session_score.h"
#include "apps/workbench/text.h"
#include "modules/catalogue.h"
#include "volume/base/parallel.h"

namespace trephine::workbench {

using glm::dvec3;

Envelope::Envelope(std::uint64_t tick_count, std::size_t column_count)
    : tick_count_(std::max<std::uint64_t>(tick_count, 1)),
      columns_(static_cast<std::size_t>(std::clamp<std::uint64_t>(column_count, 1, tick_count_))) {}

void Envelope::add(std::uint64_t tick, double value) noexcept {
  if (tick >= tick_count_ || columns_.empty()) return;
  Column& column = columns_[static_cast<std::size_t>(tick * columns_.size() / tick_count_)];
  column.low = column.has_value ? std::min(column.low, value) : value;
  column.high = column.has_value ? std::max(column.high, value) : value;
  column.has_value = true;
}

double Envelope::greatest() const noexcept {
  double greatest = 0;
  for (const Column& column : columns_)
    if (column.has_value) greatest = std::max(greatest, column.high);
  return greatest;
}

double RemovalDistances::within(std::size_t mm) const noexcept {
  double sum = inside_mm3;
  for (std::size_t i = 0; i < std::min(mm, k_bins); ++i) sum += mm3[i];
  return sum;
}

namespace {

/// Adds the volumes of the counted cells of a brick to the bins of `result`, by distance from the structure.
class BrickDistances {
 public:
  BrickDistances(const volume::Version& version, const sim::Forbidden& structure, RemovalDistances& result)
      : version_(version), structure_(structure), result_(result) {}

  using Counted = std::array<bool, volume::k_brick * volume::k_brick * volume::k_brick>;
  void add(const glm::ivec3& first, const Counted& counted) {
    first_ = first;
    counted_ = &counted;
    add_cube(glm::ivec3(0), volume::k_brick);
  }

 private:
  /// Adds a cube of cells. The distances of its cells differ from the distance of its centre by at most
  /// `reach`. If all these distances are in one bin, the cube is added as a whole. Otherwise it is divided
  /// into eight.
  void add_cube(const glm::ivec3& low, int edge) {
    const std::size_t count = count_in(low, edge);
    if (count == 0) return;
    const volume::CutLattice& lattice = version_.lattice();
    const double reach = 0.5 * (edge - 1) * lattice.frame().diagonal_mm();
    const dvec3 centre = dvec3(first_ + low) + 0.5 * (edge - 1);
    const dvec3 world = version_.base().frame.world_from_volume(lattice.volume_from_lattice(centre));
    // The clearance of this ball is the least possible distance of a cell. Measured distances are limited to
    // k_reach from the surface of the ball, so that with a ball they are valid farther from the centre than
    // with a point.
    const double least = structure_.clearance({.centre = world, .radius = reach}, expected_);
    expected_ = least;
    // The samples of the structure decide whether a point is inside. Its surface, from which distances are
    // measured, may differ from them by half a voxel.
    const bool has_one_side = least > structure_.voxel_mm() || least + 2 * reach < -structure_.voxel_mm();
    if (edge == 1 || (has_one_side && bin_of(least) == bin_of(least + 2 * reach))) {
      value_of(bin_of(least)) += static_cast<double>(count) * lattice.frame().voxel_mm3();
      return;
    }
    const int half = edge / 2;
    for (int part = 0; part < 8; ++part)
      add_cube(low + half * glm::ivec3(part & 1, part >> 1 & 1, part >> 2), half);
  }
  std::size_t count_in(const glm::ivec3& low, int edge) const {
    std::size_t count = 0;
    for (int z = low.z; z < low.z + edge; ++z)
      for (int y = low.y; y < low.y + edge; ++y)
        for (int x = low.x; x < low.x + edge; ++x) count += (*counted_)[volume::Brick::index(x, y, z)];
    return count;
  }
  /// -1: inside the structure; k_bins: beyond all bins.
  static int bin_of(double distance) {
    constexpr auto k_bins = static_cast<double>(RemovalDistances::k_bins);
    return distance < 0 ? -1 : static_cast<int>(std::min(distance, k_bins));
  }
  double& value_of(int bin) {
    if (bin < 0) return result_.inside_mm3;
    const auto i = static_cast<std::size_t>(bin);
    return i < RemovalDistances::k_bins ? result_.mm3[i] : result_.beyond_mm3;
  }

  const volume::Version& version_;
  const sim::Forbidden& structure_;
  RemovalDistances& result_;
  glm::ivec3 first_{0};
  const Counted* counted_ = nullptr;
  double expected_ = sim::Forbidden::k_reach;  ///< clearance of the previous cube: an estimate
};

}  // namespace

RemovalDistances removal_distances(const volume::Version& version, std::span<const volume::Field> solids,
                                   const sim::Forbidden& structure) {
  RemovalDistances result{.structure = structure.name()};
  BrickDistances distances(version, structure, result);
  const volume::CutLattice& lattice = version.lattice();
  const auto is_solid = [&](const glm::ivec3& sample) {
    const dvec3 p = lattice.volume_from_lattice(dvec3(sample));
    return std::any_of(solids.begin(), solids.end(),
                       [&](const volume::Field& solid) { return solid.value(p) >= 0; });
  };
  version.for_bricks_in(
      glm::ivec3(0), lattice.size() - 1, [&](const glm::ivec3& low, const volume::Brick& brick) {
        BrickDistances::Counted counted{};
        for (int z = 0; z < volume::k_brick; ++z)
          for (int y = 0; y < volume::k_brick; ++y)
            for (int x = 0; x < volume::k_brick; ++x)
              counted[volume::Brick::index(x, y, z)] =
                  (brick.is_hollow || !brick.is_kept(x, y, z)) && is_solid(low + glm::ivec3(x, y, z));
        distances.add(low, counted);
      });
  return result;
}

namespace {

/// Chooses the moments of pictures while a session is replayed.
class MomentCollector {
 public:
  MomentCollector(const ReportChoice& choice, double rate_hz) : choice_(choice), rate_hz_(rate_hz) {}

  /// Adds moments for the events since the last call.
  void observe(sim::Engine& engine) {
    const sim::Chronicle& chronicle = engine.state().chronicle;
    for (; next_ < chronicle.size(); ++next_) observe(chronicle[next_], engine);
  }
  /// Adds a moment for each bad or fair finding with a position, in the state at the time of the finding (at
  /// the end if it has no time). The moment of an event about the same injury is removed. `replay` must be at
  /// the end of the session, and is there again afterward.
  Status add_findings(const sim::Score& score, sim::Replay& replay) {
    const std::uint64_t end = replay.engine().state().next_tick;
    std::vector<ReportMoment> events = std::exchange(found_, {});
    for (const sim::Finding& finding : score.findings) {
      const bool is_bad = finding.verdict == sim::Finding::Verdict::bad;
      if (!finding.position_world || !(is_bad || finding.verdict == sim::Finding::Verdict::fair)) continue;
      ReportMoment moment{
          .tick = finding.tick.value_or(end),
          .text = words_of(finding.name) + (finding.reason.empty() ? "" : ". " + finding.reason),
          .level = is_bad ? EventLevel::danger : EventLevel::outcome,
          .position_world = *finding.position_world};
      std::erase_if(events, [&](const ReportMoment& event) { return !event.xray && is_same(event, moment); });
      if (Status error = replay.seek(std::min(moment.tick + 1, end))) return error;
      add(std::move(moment), replay.engine());
    }
    found_.insert(found_.end(), std::make_move_iterator(events.begin()),
                  std::make_move_iterator(events.end()));
    return replay.seek(end);
  }
  /// Returns the chosen moments by time. If there are too many, the first X-rays are chosen, and injuries are
  /// chosen before other moments.
  std::vector<ReportMoment> finish() {
    std::stable_sort(found_.begin(), found_.end(), [](const ReportMoment& a, const ReportMoment& b) {
      return (a.level == EventLevel::danger) > (b.level == EventLevel::danger);
    });
    std::vector<ReportMoment> chosen;
    std::size_t slices = 0, xrays = 0;
    for (ReportMoment& moment : found_)
      if (moment.xray ? xrays++ < choice_.xray_count : slices++ < choice_.slice_count)
        chosen.push_back(std::move(moment));
    std::stable_sort(chosen.begin(), chosen.end(),
                     [](const ReportMoment& a, const ReportMoment& b) { return a.tick < b.tick; });
    return chosen;
  }

 private:
  static constexpr std::size_t k_max_of_type = 2;  // events of one type, so that other types are shown too

  /// Returns true if two moments are near in time and space and therefore show one injury. An event may be
  /// emitted some seconds after the deepest position, at which a finding is located.
  bool is_same(const ReportMoment& a, const ReportMoment& b) const {
    constexpr double k_seconds = 3, k_distance = 3;  // s, mm
    const double ticks =
        a.tick > b.tick ? static_cast<double>(a.tick - b.tick) : static_cast<double>(b.tick - a.tick);
    return ticks < k_seconds * rate_hz_ && glm::distance(a.position_world, b.position_world) < k_distance;
  }

  void observe(const sim::Event& event, sim::Engine& engine) {
    const std::shared_ptr<const volume::SurgicalPlan>& plan = engine.state().plan;
    const EventText text = plan ? describe_event(event, plan->procedure) : describe_event(event);
    const auto* xray = event.value.as<fluoroscopy::XrayTaken>();
    // When these two events are emitted, the implant or screw is not completely inserted yet.
    const bool is_slice = (text.level == EventLevel::danger || text.level == EventLevel::outcome) &&
                          event.value.name() != "body-added" && event.value.name() != "screw-placed";
    if (!xray && (!is_slice || event.position_world == dvec3(0) ||
                  by_type_[std::string(event.value.name())]++ >= k_max_of_type))
      return;
    ReportMoment moment{
        .tick = event.tick, .text = text.text, .level = text.level, .position_world = event.position_world};
    if (xray) moment.xray = *xray;
    // A structure that was touched but not torn has a lower priority than an injury.
    if (event.value.name() == "structure-touched") moment.level = EventLevel::outcome;
    add(std::move(moment), engine);
  }
  void add(ReportMoment moment, sim::Engine& engine) {
    engine.freeze();
    moment.seconds = static_cast<double>(moment.tick) / rate_hz_;
    moment.version = engine.version();
    moment.objects = objects_of(engine);
    found_.push_back(std::move(moment));
  }

  const ReportChoice& choice_;
  double rate_hz_;
  std::size_t next_ = 0;
  std::map<std::string, std::size_t> by_type_;
  std::vector<ReportMoment> found_;
};

/// Returns the touchable shapes of the scan.
std::vector<volume::Field> solids_of(const sim::Engine& engine) {
  std::vector<volume::Field> solids;
  for (const haptics::TouchItem& item : engine.scene().items)
    if (!item.is_mesh() && &item.field.volume() == engine.scene().base.get()) solids.push_back(item.field);
  return solids;
}

/// Combines the values of all hands in a tick to one value, such as the largest, and adds it to an envelope.
class HandValues {
 public:
  HandValues(Envelope& envelope, const double& (*choose)(const double&, const double&))
      : envelope_(&envelope), choose_(choose) {}
  void add(std::uint64_t tick, double value) {
    if (tick != tick_) flush();
    value_ = value_ ? choose_(*value_, value) : value;
    tick_ = tick;
  }
  void flush() {
    if (value_) envelope_->add(tick_, *value_);
    value_.reset();
  }

 private:
  Envelope* envelope_;
  const double& (*choose_)(const double&, const double&);
  std::uint64_t tick_ = 0;
  std::optional<double> value_;
};

/// Returns the distance of a hand's tool from the nearest forbidden structure, mm.
double clearance_of(const sim::Engine& engine, std::size_t hand) {
  double nearest = sim::Forbidden::k_reach;
  for (std::size_t s = 0; s < engine.forbidden().size(); ++s)
    if (engine.watch(hand, s).clearance < nearest)  // the measured clearance, or a lower bound of it
      nearest = std::min(nearest, engine.clearance(hand, s));
  return nearest;
}

/// Replays and judges the session; collects envelopes, paths and moments.
Status judge(ReportData& data, MomentCollector& moments, const Listener& listener) {
  HandValues force(data.force, std::max<double>), clearances(data.clearance, std::min<double>);
  std::uint64_t count = 0;
  const auto observe = [&](sim::Replay& replay, bool is_tick) {
    moments.observe(replay.engine());
    if (!is_tick) return;
    const haptics::ServoRecord& record = replay.record();
    force.add(record.tick, glm::length(record.force_world));
    if (!replay.engine().forbidden().empty())
      clearances.add(record.tick, clearance_of(replay.engine(), record.hand));
    data.paths.resize(std::max<std::size_t>(data.paths.size(), record.hand + 1U));
    const sim::Instrument& tool = replay.engine().state().settings.hands[record.hand];
    // A probe or a catheter in its track works without a button.
    const bool is_working =
        record.pose.is_pressed() || (tool.type && tool.type->is_working &&
                                     tool.type->is_working(tool.parameters.data(), tool.state.data()));
    if (!record.is_reset) data.paths[record.hand].add(record.proxy_world, record.has_contact, is_working);
    data.mean_hand_position += record.pose.position_world;
    ++count;
  };
  auto score = score_session(*data.session, {}, listener, observe);
  if (!score) return score.error();
  data.score = std::move(score).value().score;
  force.flush();
  clearances.flush();
  data.mean_hand_position /= static_cast<double>(std::max<std::uint64_t>(count, 1));
  return std::nullopt;
}

}  // namespace

Result<ReportData> collect_report(const ReportChoice& choice, const Listener& listener) {
  ReportData data;
  {
    auto log = sim::SessionReader::open(choice.session, modules::catalogue());
    if (!log) return log.error();
    auto timeline = read_timeline(log.value());
    if (!timeline) return timeline.error();
    data.timeline = std::move(timeline).value();
    const auto notes = data_tools::read_notes(choice.session);
    if (!notes) return notes.error();
    add_notes(data.timeline, notes.value(), log.value().header().rate_hz);
  }
  auto opened = open_session(choice.session, choice.case_source, listener);
  if (!opened) return opened.error();
  data.session = std::move(opened).value();
  const sim::SessionHeader& header = data.header();
  const std::uint64_t tick_count = data.session->reader->tick_count();
  data.seconds = static_cast<double>(tick_count) / header.rate_hz;
  data.force = data.clearance = Envelope(tick_count, choice.column_count);
  MomentCollector moments(choice, header.rate_hz);
  if (Status error = judge(data, moments, listener)) return *error;

  if (Status error = moments.add_findings(data.score, *data.session->replay)) return *error;
  sim::Engine& end = data.session->replay->engine();
  end.freeze();
  data.moments = moments.finish();
  data.overlays = end.overlays();
  data.removed_mm3 = end.removed_mm3();
  const std::vector<volume::Field> solids = solids_of(end);
  const auto& forbidden = end.forbidden();
  const volume::Version& version = *end.version();
  data.removal.resize(forbidden.size());
  parallel_for(static_cast<int>(forbidden.size()), 0, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    data.removal[index] = removal_distances(version, solids, *forbidden[index]);
  });
  return data;
}

}  // namespace trephine::workbench
