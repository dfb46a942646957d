#include "apps/cli/commands/script_play.h"

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>

#include "apps/view/render_window.h"
#include "apps/view/tool_appearance.h"
#include "apps/view/viewport.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "modules/catalogue.h"

namespace trephine::cli {

namespace fs = std::filesystem;
using glm::dvec3;

namespace {

std::vector<view::StructureOpacity> opacities_of(const data_tools::ScriptPicture& picture) {
  std::vector<view::StructureOpacity> opacities;
  for (const auto& [name, opacity] : picture.opacities) opacities.push_back({name, opacity});
  return opacities;
}

/// Draws the pictures of one operation off-screen, one at a time. Consecutive pictures with equal opacities
/// share a viewport.
class ScriptPictures {
 public:
  ScriptPictures(const workbench::ScriptRun& run, std::string folder)
      : run_(&run), folder_(std::move(folder)) {}

  Status write(const data_tools::ScriptPicture& request, const workbench::ScriptMoment& moment,
               const std::string& caption) {
    const auto begin = Clock::now();
    const volume::Version& version = *moment.engine.version();
    const bool is_opaque = request.opacities.empty();
    if (!picture_ || request.opacities != opacities_) {
      auto surface = view::make_offscreen(1200, 900);
      if (!surface) return surface.error();
      picture_.reset();
      surface_ = std::move(surface).value();
      opacities_ = request.opacities;
      picture_.emplace(*run_->operation().scene(), surface_->window(), !is_opaque);
      if (Status error = picture_->set_opacities(opacities_of(request))) return error;
      picture_->request_all(moment.engine.version());
    } else {
      picture_->request(moment.engine.version(), moment.changed);
    }
    picture_->wait();
    if (Status error = aim(request, moment.engine)) return error;
    const auto h = static_cast<std::size_t>(request.hand);
    const haptics::ServoRecord& hand = moment.hands[h];
    if (request.has_tool)
      picture_->show_stylus(hand, view::appearance_of(moment.engine.state().settings.hands[h].parameters),
                            version, from_);
    else
      picture_->view().show(view::StylusState{.is_visible = false});
    picture_->show(moment.engine.overlays(), moment.hands);
    picture_->show_text(caption, "");
    if (is_opaque)
      picture_->draw();
    else
      picture_->complete();
    Status error = view::write_png(surface_->window(), (fs::path(folder_) / request.file).string());
    seconds_ += seconds_since(begin);
    return error;
  }
  double seconds() const noexcept { return seconds_; }

 private:
  Status aim(const data_tools::ScriptPicture& request, const sim::Engine& engine) {
    from_ = glm::normalize(request.from);
    const dvec3 up(0, 0, 1);
    for (const workbench::Place& named : run_->places())
      if (named.name == request.place) {
        const Result<workbench::Place> place = workbench::current_place(named, engine);
        if (!place) return place.error();
        from_ = glm::normalize(place.value().direction(request.from));
        picture_->view().aim_camera(place.value().at(request.aim), from_, up, *request.distance);
        return std::nullopt;
      }
    dvec3 low, high;
    picture_->view().bounds(low, high);
    picture_->view().aim_camera(0.5 * (low + high) + request.aim, from_, up,
                                request.distance.value_or(view::BoneView::distance_of(low, high)));
    return std::nullopt;
  }

  const workbench::ScriptRun* run_;
  std::string folder_;
  std::unique_ptr<view::DrawSurface> surface_;
  std::optional<view::Viewport> picture_;                  // destroyed before its surface
  std::vector<std::pair<std::string, double>> opacities_;  // of picture_
  dvec3 from_{0.0};
  double seconds_ = 0;
};

}  // namespace

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (!path.empty()) fs::remove(path, ignored);
}

Result<PlayedScript> play_script(const ScriptRequest& request) {
  const auto begin = Clock::now();
  if (Status error = check(request.record)) return *error;
  PlayedScript played;
  if (!request.pictures.empty()) {
    if (Status error = data_tools::make_folder(request.pictures)) return *error;
    data_tools::OutputSet outputs;
    for (const std::string& file : request.in_use) outputs.add_input(file);
    for (const std::string& output : request.outputs) outputs.add_output("output", output);
    for (const data_tools::ScriptPicture& picture : request.script.pictures)
      outputs.add_output(picture.file, (fs::path(request.pictures) / picture.file).string(),
                         data_tools::OutputKind::picture);
    if (Status error = outputs.check()) return *error;
  }
  if (request.is_live && !(request.script.rate_hz >= 250 && request.script.rate_hz <= 10000))
    return Error{.what = "the servo rate is out of range",
                 .where = request.where + ": rate",
                 .found = format_text("%g Hz", request.script.rate_hz),
                 .expected = "250 to 10000 Hz",
                 .remedy = "choose another rate, or omit --live"};
  auto opened = workbench::ScriptRun::open(request.script, request.folder, request.where, terminal_listener(),
                                           request.performance);
  if (!opened) return opened.error();
  played.run = std::move(opened).value();
  workbench::ScriptRun& run = *played.run;
  for (const data_tools::ScriptPicture& picture : request.script.pictures)
    if (Status error = view::check_opacities(*run.operation().scene(), opacities_of(picture),
                                             request.where + ", line " + std::to_string(picture.line)))
      return *error;
  played.ready_seconds = seconds_since(begin);

  workbench::RecordChoice record = request.record;
  if ((request.is_live || request.wants_session) && record.file.empty()) {
    Result<std::string> path = workbench::new_autosave();
    if (!path) return path.error();
    played.temporary.path = record.file = path.value();
  }
  played.session = record.file;
  auto recorder = workbench::start_recording(record, run.operation());
  if (!recorder) return recorder.error();

  ScriptPictures pictures(run, request.pictures);
  workbench::PictureTaker taker;
  if (!request.pictures.empty())
    taker = [&](const data_tools::ScriptPicture& picture, const workbench::ScriptMoment& moment,
                const std::string& caption) {
      played.pictures.push_back(picture.file);
      return pictures.write(picture, moment, caption);
    };
  const auto start = Clock::now();
  Result<workbench::ScriptReport> report = workbench::ScriptReport();
  if (request.is_live) {
    notice(format_text("playing live, for %.0f s ...", std::ceil(run.duration())));
    auto live = run.play_live(*recorder.value(), terminal_listener());
    if (!live) return live.error();
    played.live = std::move(live).value();
    played.played_seconds = seconds_since(start);
    recorder.value().reset();
    auto session = sim::SessionReader::open(record.file, modules::catalogue());
    if (!session) return session.error();
    auto replay = sim::Replay::open(session.value(), run.operation().start);
    if (!replay) return replay.error();
    report = run.watch(*played.live, *replay.value(), std::move(taker), terminal_listener());
  } else {
    report = run.play(recorder.value().get(), std::move(taker), terminal_listener());
  }
  if (!report) return report.error();
  played.report = std::move(report).value();
  played.drawing_seconds = pictures.seconds();
  if (!request.is_live) played.played_seconds = seconds_since(start) - played.drawing_seconds;
  return played;
}

Json servo_json(const haptics::ServoReport& servo) {
  const auto times = [](double p50, double p99, double p999, double max) {
    return Json{{"p50", p50}, {"p99", p99}, {"p999", p999}, {"max", max}};
  };
  return {{"ticks", servo.ticks},
          {"step_us", times(servo.step_p50_us, servo.step_p99_us, servo.step_p999_us, servo.step_max_us)},
          {"late_us", times(servo.late_p50_us, servo.late_p99_us, servo.late_p999_us, servo.late_max_us)},
          {"overruns", servo.overruns},
          {"faults", servo.faults},
          {"notice", servo.notice}};
}

Json places_json(const workbench::ScriptRun& run) {
  Json list = Json::array();
  for (const workbench::Place& place : run.places()) {
    if (place.body > 0)
      list.push_back({{"name", place.name}, {"body", place.body}});
    else
      list.push_back({{"name", place.name},
                      {"at", json_of(place.point)},
                      {"outward", json_of(place.outward)},
                      {"thickness_mm", place.thickness}});
  }
  return list;
}

Json checks_json(const workbench::ScriptReport& report) {
  Json list = Json::array();
  for (const workbench::ScriptCheck& c : report.checks)
    list.push_back(
        {{"line", c.line}, {"at_seconds", c.at}, {"what", c.what}, {"found", c.found}, {"is_met", c.is_met}});
  return list;
}

void print_checks(Rows& rows, const char* unmet) {
  for (const Json& check : rows.json["checks"])
    rows.print(std::string(check["is_met"].get<bool>() ? "ok    " : unmet) +
                   "  line {line}, at {at_seconds:.3f} s: {what} ({found})",
               check);
}

}  // namespace trephine::cli
