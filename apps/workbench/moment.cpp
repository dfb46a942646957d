#include "apps/workbench/moment.h"

#include <algorithm>
#include <cmath>

#include "apps/workbench/text.h"
#include "data-tools/cases/phantom_cases.h"
#include "modules/pedicle/placement.h"

namespace trephine::workbench {

namespace {

Status open_session_at(const MomentChoice& choice, const Listener& listener, Moment& moment) {
  SourceChoice scan = choice.source;
  scan.path = choice.case_source;
  auto opened = open_session(choice.source.path, scan, listener);
  if (!opened) return opened.error();
  moment.session = std::move(opened).value();
  OpenedSession& session = *moment.session;
  const auto tick = tick_at(*session.reader, choice.until);
  if (!tick) return tick.error();
  return go_to(moment, tick.value());
}

}  // namespace

Result<const volume::PlannedTrajectory*> find_trajectory(const Moment& moment, const std::string& name,
                                                         const char* where) {
  std::string known;
  for (const volume::PlannedTrajectory& t : moment.plan.trajectories) {
    if (t.name == name) return &t;
    known += (known.empty() ? "" : ", ") + t.name;
  }
  return Error{.what = "unknown trajectory",
               .where = where,
               .found = name,
               .expected = known.empty() ? "a case with a plan" : known};
}

std::vector<Moment::Object> objects_of(const sim::Engine& engine) {
  std::vector<Moment::Object> objects;
  for (const haptics::TouchItem* model : engine.models()) {
    Moment::Object object{haptics::name_of(*model), engine.surface_of(*model), engine.placement_of(*model),
                          model->matter};
    object.screw = data_tools::recognized_screw(object.tree->vertices());
    if (object.screw) {
      object.screw->entry_world = object.placement.world_from_local(object.screw->entry_world);
      object.screw->tip_world = object.placement.world_from_local(object.screw->tip_world);
    }
    objects.push_back(std::move(object));
  }
  const auto* pedicle = engine.state().undoable_of<pedicle::PedicleState>();
  for (const sim::Body& body : engine.state().undoable.bodies) {
    objects.push_back({format_text(body.is_implant ? "implant %u" : "piece %u", body.id.value),
                       body.piece->tree, engine.placement_of(body), body.matter, !body.is_implant});
    const auto index = pedicle ? pedicle->find_screw(body.id) : std::nullopt;
    if (!index) continue;
    const pedicle::Screw screw = pedicle->screw(*index);
    objects.back().screw = {screw.entry_world, screw.tip_world, screw.diameter};
  }
  return objects;
}

Status go_to(Moment& moment, std::uint64_t tick) {
  OpenedSession& session = *moment.session;
  std::erase_if(moment.objects, [](const Moment::Object& object) { return !object.is_external; });
  if (Status error = session.replay->seek(tick)) return error;
  moment.seconds = static_cast<double>(tick) / session.reader->header().rate_hz;
  sim::Engine& engine = session.replay->engine();
  engine.freeze();
  const haptics::TouchScene& scene = engine.scene();
  moment.scan = scene.base;
  moment.version = engine.version();
  if (engine.state().plan) moment.plan = *engine.state().plan;
  moment.forbidden.clear();
  for (const auto& structure : engine.forbidden())
    if (structure->shape())
      moment.forbidden.push_back(*structure->shape());  // forbidden models are in `objects`
  if (moment.forbidden.empty())
    if (const auto plan =
            session.source.is_builtin ? data_tools::phantom_plan(session.source.name) : session.source.plan)
      moment.forbidden = forbidden_of(*plan);
  for (const haptics::TouchItem& item : scene.items)
    if (!moment.shape && !item.is_mesh() && &item.field.volume() == scene.base.get())
      moment.shape = item.field.shape();
  for (Moment::Object& object : objects_of(engine)) moment.objects.push_back(std::move(object));
  return std::nullopt;
}

Result<std::unique_ptr<Moment>> open_moment(const MomentChoice& choice, const Listener& listener) {
  if (choice.until && !(*choice.until >= 0 && std::isfinite(*choice.until)))
    return Error{.what = "the time is out of range",
                 .where = "until",
                 .found = format_text("%g s", *choice.until),
                 .expected = "0 s or more"};
  if (Status error = check(choice.shape)) return *error;
  auto moment = std::make_unique<Moment>();
  if (is_session_file(choice.source.path)) {
    if (Status error = open_session_at(choice, listener, *moment)) return *error;
  } else {
    if (choice.until)
      return Error{.what = "a scan has no time axis",
                   .where = "until",
                   .found = format_text("%g s", *choice.until),
                   .expected = "a recorded session",
                   .remedy = "omit the time, or pass a session"};
    SourceChoice scan = choice.source;
    scan.uses_plan = true;
    auto source = open_source(scan, listener);
    if (!source) return source.error();
    moment->source = std::move(source).value();
    moment->scan = moment->source.volume;
    moment->version = std::make_shared<volume::Version>(moment->scan);
    moment->plan = plan_of(moment->source);
    if (moment->source.plan) {
      moment->forbidden = forbidden_of(*moment->source.plan);
      for (const data_tools::CaseStructure& s : moment->source.plan->structures)
        if (!s.is_forbidden && !moment->shape) moment->shape = s.shape;
    }
  }
  if (choice.shape.is_set() || !moment->shape) {
    const Source& source = moment->session ? moment->session->source : moment->source;
    const auto shape = choose_shape(source, choice.shape, listener);
    if (shape)
      moment->shape = shape.value();
    else if (choice.shape.is_set())
      return shape.error();
  }
  std::vector<ModelChoice> models = moment->session ? std::vector<ModelChoice>() : models_of(moment->source);
  models.insert(models.end(), choice.models.begin(), choice.models.end());
  for (const ModelChoice& model_choice : models) {
    auto model = load_model(model_choice, moment->objects.size() + 1, listener);
    if (!model) return model.error();
    haptics::Placement placement;
    placement.position_world = model_choice.at_world;
    const char* kind = model_choice.screw ? "screw %zu" : "model %zu";
    moment->objects.push_back(
        {model_choice.name.empty() ? format_text(kind, moment->objects.size() + 1) : model_choice.name,
         std::move(model).value(), placement, model_choice.matter, false, true, model_choice.screw});
  }
  return moment;
}

}  // namespace trephine::workbench
