// simulator: shows a start page to choose an operation, and the window of each chosen operation.
#include <utility>

#include "apps/cli/commands.h"
#include "apps/cli/commands/operation_window.h"
#include "apps/cli/commands/session_window.h"
#include "apps/cli/commands/window_devices.h"
#include "apps/view/start_page.h"
#include "data-tools/cases/procedure_file.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

namespace {

struct SimulatorArguments {
  std::optional<double> seconds;
  std::string screenshot;
  workbench::DeviceChoice device;
  DisplayArguments display;
};

constexpr const char* k_tutorial = "first-steps";

view::StartPageOptions page_of(const SimulatorArguments& arguments, std::string problem) {
  view::StartPageOptions page;
  page.problem = std::move(problem);
  page.language = arguments.display.language;
  page.tiles = {
      {"First steps", "Turn, touch, drill, undo, measure and take an X-ray, in five minutes.", "first-steps",
       "head", k_tutorial},
      {"Craniotomy", "Plan the outline, drill the holes, cut and lift the flap.", "craniotomy", "head",
       "craniotomy"},
      {"Ventriculostomy", "Drill at Kocher's point and pass a catheter into the ventricle.",
       "ventriculostomy", "head", "ventriculostomy"},
      {"Laminectomy and screws", "Open the canal of L4, probe the pedicles and place screws.",
       "laminectomy-screws", "spine", "laminectomy-screws"},
      {"Free practice: head", "All instruments on the built-in skull, without steps.", "head", "head", ""},
      {"Free practice: spine", "All instruments on the built-in lumbar spine, without steps.", "spine",
       "spine", ""}};
  constexpr std::size_t k_sessions = 12;
  for (workbench::Autosave& session : workbench::list_autosaves(k_sessions))
    page.sessions.push_back({std::move(session.file), session.title.empty() ? "Operation" : session.title,
                             std::move(session.begin), session.seconds, session.is_interrupted,
                             session.needs_scan});
  for (const data_tools::ShippedProcedure& shipped : data_tools::shipped_procedures()) {
    if (shipped.name == k_tutorial) continue;  // its texts fit the built-in head only
    if (const auto file = data_tools::shipped_procedure(std::string(shipped.name)))
      page.procedures.emplace_back(shipped.name, file.value().procedure.title);
  }
  page.seconds = arguments.seconds;
  page.should_close = is_interrupted;
  page.screenshot = arguments.screenshot;
  return page;
}

Status run_choice(const view::StartChoice& choice, const SimulatorArguments& arguments) {
  const workbench::DeviceChoice& device = arguments.device;
  if (choice.kind == view::StartChoice::Kind::operation) {
    WindowArguments window;
    window.source = choice.path;
    window.procedure = choice.procedure;
    window.device = device;
    window.display = arguments.display;
    const auto done = run_operation_window(window, "simulator");
    return done ? std::nullopt : Status(done.error());
  }
  workbench::SourceChoice scan;
  scan.path = choice.scan;
  if (choice.kind == view::StartChoice::Kind::resume) {
    const auto devices = open_window_devices(device, arguments.display.language, true);
    if (!devices) return devices.error();
    auto continued = workbench::continue_session(choice.path, scan, true, terminal_listener(),
                                                 workbench::hand_count_of(devices.value()));
    if (!continued) return continued.error();
    const auto done = continue_in_window(std::move(continued).value(), choice.scan,
                                         {choice.path, choice.scan}, devices.value(), arguments.display);
    return done ? std::nullopt : Status(done.error());
  }
  auto session = workbench::open_session(choice.path, scan, terminal_listener());
  if (!session) return session.error();
  return play_in_window(*session.value(), {choice.path, scan, session.value()->source.written_name()},
                        arguments.display);
}

Result<Outcome> run_simulator(const SimulatorArguments& arguments) {
  data_tools::OutputSet outputs;
  outputs.add_output("screenshot", arguments.screenshot, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  // Report an invalid display and an invalid name of a device before the start page opens, not after an
  // operation was chosen.
  if (const auto devices = workbench::make_devices(arguments.device, terminal_listener()); !devices)
    return devices.error();
  view::WindowOptions checked;
  if (Status error = choose_display(arguments.display, checked)) return *error;
  checked.head_tracker.reset(), checked.hmd.reset();  // frees the port and the headset
  Outcome outcome("simulator");
  int operations = 0;
  std::string problem;
  for (;;) {
    const auto choice = view::choose_start(page_of(arguments, std::exchange(problem, {})));
    if (!choice) return choice.error();
    if (choice.value().kind == view::StartChoice::Kind::none || is_interrupted()) break;
    ++operations;
    // The page shows the error, so that another case can be chosen.
    if (Status error = run_choice(choice.value(), arguments)) problem = error->message();
  }
  outcome.json["operations"] = operations;
  outcome.print("operations: {operations}");
  return finished(outputs, std::move(outcome));
}

Run build_simulator(Options& options) {
  auto a = std::make_shared<SimulatorArguments>();
  options.add("--seconds", a->seconds, "Close the start page after this time").type("S");
  options
      .add("--screenshot", a->screenshot,
           "Write a picture of the start page; without --seconds no window is opened")
      .type("OUT.png");
  add_display(options, a->display);
  add_devices(options, a->device);
  return run_with(a, run_simulator);
}

}  // namespace

const Command k_simulator{"simulator", "Choose an operation on a start page, and perform it step by step",
                          "  trephine simulator\n  trephine simulator --device falcon --pedal pedal",
                          build_simulator};

}  // namespace trephine::cli
