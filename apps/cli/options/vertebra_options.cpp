#include "apps/cli/options/vertebra_options.h"

#include "apps/cli/commands.h"

namespace trephine::cli {

void add_vertebra(Options& options, VertebraArguments& a) {
  add_session(options, a.session, a.case_source);
  options.add("--vertebra", a.vertebra, "Label of the vertebra in the scan").type("LABEL");
  options
      .add("--canal", a.canal,
           "A position in its canal, at the height of its lamina, mm (LPS); required without a label")
      .type("X,Y,Z");
  options.add("--until", a.until, "Time of the state in the session, s (default: the end)").type("S");
}

Result<OpenedVertebra> open_vertebra(const VertebraArguments& arguments) {
  if (arguments.vertebra.empty() && arguments.canal.empty())
    return Error{.what = "no vertebra selected",
                 .expected = "--vertebra or --canal",
                 .remedy = "list the labels with trephine info"};
  OpenedVertebra result;
  if (!arguments.canal.empty()) {
    const auto place = parse_point(arguments.canal, "--canal");
    if (!place) return place.error();
    result.canal = place.value();
  }
  auto opened = workbench::open_session(arguments.session, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  result.session = std::move(opened).value();
  const auto end = workbench::tick_at(*result.session->reader, arguments.until);
  if (!end) return end.error();
  if (Status error = result.session->replay->seek(end.value())) return *error;
  result.engine().freeze();
  const haptics::TouchScene& scene = result.session->scene();
  if (scene.items.empty() || scene.items[0].is_mesh())
    return Error{.what = "the session has no bone",
                 .where = "session",
                 .expected = "a session whose first shape is of a volume"};
  if (arguments.vertebra.empty()) return result;
  const volume::Volume& scan = result.bone().volume();
  result.label = scan.label_value(arguments.vertebra);
  if (result.label > 0 && !scan.labels.is_empty()) return result;
  std::string known;
  for (std::size_t i = 1; i < scan.label_names.size(); ++i)
    known += (i > 1 ? ", " : "") + scan.label_names[i];
  return Error{.what = "unknown label",
               .where = "vertebra",
               .found = arguments.vertebra,
               .expected = known.empty() ? "a scan with labels" : known,
               .remedy = "pass a position in its canal: --canal"};
}

Error no_canal(const LocatedError& error, const char* where) {
  const glm::dvec3& at = error.position_world;
  return {.what = error.reason,
          .where = where,
          .found = format_text("%.1f, %.1f, %.1f", at.x, at.y, at.z),
          .expected = "a vertebra with a closed canal",
          .remedy = "pass a position in its canal at the height of its lamina: --canal"};
}

}  // namespace trephine::cli
