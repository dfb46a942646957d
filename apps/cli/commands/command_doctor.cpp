// doctor: checks this machine for what the programs need, and suggests remedies.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <utility>

#include "apps/cli/commands/doctor_device.h"
#include "apps/view/render_window.h"
#include "apps/workbench/devices.h"
#include "data-tools/files/atomic_file.h"
#include "volume/base/percentile.h"
#include "volume/base/text.h"

namespace trephine::cli {

namespace {

struct DoctorArguments {
  std::string output;
  bool has_only_devices = false, has_feel_test = false;
  workbench::DeviceChoice device;
  double seconds = 3;
};

/// Measures the lateness (us, sorted) of a 1 kHz timer, in a thread with the servo's priority if the system
/// allows it (`is_realtime`).
std::vector<double> watch_timer(double seconds, bool& is_realtime) {
  std::vector<double> lateness_us;
  const auto count = static_cast<std::size_t>(seconds * 1000);
  lateness_us.reserve(count + 1);
  bool is_first = true;  // the first call is not timed
  is_realtime = run_at_1_khz([&](double, double late_us) {
    if (!std::exchange(is_first, false)) lateness_us.push_back(late_us);
    return lateness_us.size() < count;
  });
  std::sort(lateness_us.begin(), lateness_us.end());
  return lateness_us;
}

/// Draws a histogram of lateness as SVG, with three bars per octave and marked percentiles. Both axes are
/// logarithmic.
std::string timer_picture(const std::vector<double>& lateness_us) {
  constexpr int k_bars = 42;
  constexpr double k_first = 1, k_width = 860, k_height = 326, k_left = 70, k_top = 104;
  std::vector<int> bars(k_bars, 0);
  for (const double us : lateness_us)
    ++bars[static_cast<std::size_t>(
        std::clamp(static_cast<int>(3 * std::log2(std::max(us, k_first) / k_first)), 0, k_bars - 1))];
  const int tallest = std::max(1, *std::max_element(bars.begin(), bars.end()));
  const auto x_of = [&](double us) {
    return k_left + k_width * std::clamp(3 * std::log2(std::max(us, k_first) / k_first) / k_bars, 0.0, 1.0);
  };
  const auto height_of = [&](int n) { return n == 0 ? 0 : k_height * std::log1p(n) / std::log1p(tallest); };
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1000 520\" font-family=\"sans-serif\" "
      "font-size=\"16\">\n"
      "<rect width=\"1000\" height=\"520\" fill=\"#fbfaf7\"/>\n"
      "<text x=\"70\" y=\"36\" font-size=\"21\" fill=\"#222\">Lateness of a 1 kHz timer on this "
      "machine</text>\n";
  for (int b = 0; b < k_bars; ++b) {
    const double h = height_of(bars[static_cast<std::size_t>(b)]), w = k_width / k_bars;
    if (h > 0)
      svg += format_text("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"#3b6ea5\"/>\n",
                         k_left + b * w + 1, k_top + k_height - h, w - 2, h);
  }
  for (double us = 1; us < 16384; us *= 10)
    svg += format_text("<text x=\"%.1f\" y=\"455\" text-anchor=\"middle\" fill=\"#444\">%.0f</text>\n",
                       x_of(us), us);
  svg += "<text x=\"500\" y=\"485\" text-anchor=\"middle\" fill=\"#444\">late by, \xc2\xb5s</text>\n";
  for (int n = 1; n <= tallest; n *= 10)
    svg += format_text("<text x=\"62\" y=\"%.1f\" text-anchor=\"end\" fill=\"#444\">%d</text>\n",
                       k_top + k_height - height_of(n) + 5, n);
  const struct {
    double p;
    const char *name, *color;
    double y;
  } marks[] = {{50, "median", "#14694b", 62}, {99, "99 %", "#b5651d", 80}, {100, "latest", "#a02c2c", 98}};
  for (const auto& m : marks) {
    const double us = percentile(lateness_us, m.p), x = x_of(us);
    svg += format_text(
        "<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.0f\" y2=\"430\" stroke=\"%s\" stroke-width=\"2\" "
        "stroke-dasharray=\"6 4\"/>\n",
        x, x, m.y - 12, m.color);
    svg +=
        format_text("<text x=\"%.1f\" y=\"%.0f\" fill=\"%s\" text-anchor=\"%s\">%s %.0f \xc2\xb5s</text>\n",
                    x + (x > 800 ? -6 : 6), m.y, m.color, x > 800 ? "end" : "start", m.name, us);
  }
  return svg + "</svg>\n";
}

/// Returns the programs that have opened a device file.
std::string users_of(const std::string& node) {
  std::string users;
  std::error_code error;
  for (std::filesystem::directory_iterator process("/proc", error), end; !error && process != end;
       process.increment(error)) {
    const std::string id = process->path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    std::error_code refused;
    for (std::filesystem::directory_iterator file(process->path() / "fd", refused), last;
         !refused && file != last; file.increment(refused)) {
      std::error_code broken;
      if (std::filesystem::read_symlink(file->path(), broken) != node) continue;
      std::string name;
      std::getline(std::ifstream(process->path() / "comm"), name);
      users += (users.empty() ? "" : ", ") + name + " (" + id + ")";
      break;
    }
  }
  return users;
}

/// Checks which devices are plugged in, and what prevents their use.
std::vector<CheckResult> find_devices() {
  std::vector<CheckResult> found;
  const auto kinds = workbench::hardware_kinds();
  const haptics::DeviceHost host = workbench::device_host(terminal_listener());
  if (!kinds) found.push_back({"drivers", kinds.error().what, kinds.error().remedy, true});
  if (kinds)
    for (const haptics::DeviceKind& kind : kinds.value()) {
      const std::vector<haptics::DeviceCheck> checks = kind.check(host);
      if (checks.empty()) {
        const std::string missing = kind.missing_software(host);
        found.push_back(
            {kind.name, "not plugged in (" + kind.description + ")" + (missing.empty() ? "" : "; " + missing),
             missing.empty() ? "" : "see docs/devices.md, Setup by device", false});
      }
      for (const haptics::DeviceCheck& check : checks) {
        found.push_back({kind.name, check.found, check.remedy, check.is_fault});
        if (check.node.empty()) continue;
        if (const std::string users = users_of(check.node); !users.empty())
          found.push_back({kind.name, "used by " + users, "close that program", true});
      }
    }
  // The choice of devices.toml is made without opening the devices.
  if (const auto chosen = workbench::make_devices({}, {.notice = [](const std::string&) {}}); !chosen)
    found.push_back({"devices.toml",
                     chosen.error().what + (chosen.error().found.empty() ? "" : ": " + chosen.error().found),
                     chosen.error().remedy.empty() ? "correct or remove the file" : chosen.error().remedy,
                     true});
  found.push_back({"devices", "without hardware: mouse, playback:PATH.csv, virtual:PATH.csv", "", false});
  return found;
}

/// Returns the outcome with the checks and their remedies.
Outcome outcome_of(const std::vector<CheckResult>& checks) {
  Outcome outcome("doctor");
  outcome.json["checks"] = Json::array();
  int faults = 0;
  for (const CheckResult& f : checks) {
    outcome.json["checks"].push_back(
        {{"name", f.name}, {"observation", f.observation}, {"is_fault", f.is_fault}, {"remedy", f.remedy}});
    const Json& row = outcome.json["checks"].back();
    outcome.print(std::string(f.is_fault ? "FAULT" : "   ok") + " {name:14} {observation}", row);
    if (!f.remedy.empty())
      outcome.print(std::string(21, ' ') + (f.is_fault ? "-> " : "   ") + "{remedy}", row);
    faults += f.is_fault;
  }
  outcome.json["faults"] = faults;
  outcome.print(faults == 0 ? "no faults" : faults == 1 ? "{faults} fault" : "{faults} faults");
  if (faults > 0) outcome.exit_code = exit_missing_here;
  return outcome;
}

/// Measures one device.
Result<Outcome> examine_device(const DoctorArguments& arguments) {
  auto chosen = workbench::make_devices(arguments.device, terminal_listener());
  if (!chosen) return chosen.error();
  if (!chosen.value().device)
    return Error{.what = "the mouse of the window is not measured",
                 .where = "--device",
                 .found = arguments.device.device,
                 .expected = "a haptic device or a 3-D mouse",
                 .remedy = "choose one that trephine doctor --devices lists"};
  haptics::Device& device = *chosen.value().device;
  auto checks = measure_device(device, arguments.seconds, [&] {
    notice(format_text("Move the hand for %.1f s ...", arguments.seconds));
  });
  if (!checks) return checks.error();
  if (is_interrupted()) return interrupted("the check of the device");
  if (arguments.has_feel_test) {
    notice("Hold the hand loosely. Three gentle pushes follow; each lasts two seconds.");
    auto pushes = test_feel(device, [](const std::string& question) {
      std::fputs(question.c_str(), stderr);
      std::string answer;
      std::getline(std::cin, answer);
      return answer;
    });
    if (!pushes) return pushes.error();
    checks.value().insert(checks.value().end(), pushes.value().begin(), pushes.value().end());
  }
  return outcome_of(checks.value());
}

Result<Outcome> run_doctor(const DoctorArguments& arguments) {
  if (!(arguments.seconds >= 0.1 && arguments.seconds <= 3600))
    return Error{.what = "the time is out of range",
                 .where = "--seconds",
                 .found = rounded_text(arguments.seconds),
                 .expected = "0.1 to 3600 s"};
  std::vector<CheckResult> checks;
  if (arguments.has_feel_test && arguments.device.device.empty())
    return Error{.what = "no device is selected for the test of its force",
                 .where = "--feel",
                 .remedy = "pass --device, such as --device falcon"};
  if (!arguments.device.device.empty()) {
    if (!arguments.output.empty() || arguments.has_only_devices)
      return Error{.what = "a single device is measured by itself",
                   .where = "--device",
                   .remedy = "omit --output and --devices"};
    return examine_device(arguments);
  }
  if (arguments.has_only_devices) {
    if (!arguments.output.empty())
      return Error{.what = "the picture needs a measurement of the timer",
                   .where = "--output",
                   .remedy = "omit --devices"};
    return outcome_of(find_devices());
  }

  checks.push_back(
      view::has_display()
          ? CheckResult{"display", "available", "", false}
          : CheckResult{
                "display", "not available",
                "pictures work without (--screenshot); for a window log in at a desktop, or use ssh -X",
                true});
  const Result<std::string> gl = view::describe_gl();
  if (gl) {
    const bool is_software = gl.value().find("llvmpipe") != std::string::npos;
    checks.push_back({"OpenGL", gl.value(),
                      is_software
                          ? "drawn by the processor: smooth up to about a million triangles; a graphics "
                            "card's driver makes it faster"
                          : "",
                      false});
  } else {
    checks.push_back({"OpenGL", gl.error().found, gl.error().remedy, true});
  }

  bool is_realtime = false;
  notice("watching the timer for " + format_text("%.1f", arguments.seconds) + " s ...");
  const std::vector<double> lateness_us = watch_timer(arguments.seconds, is_realtime);
  if (is_interrupted()) return interrupted("the check of this machine");
  checks.push_back(
      is_realtime
          ? CheckResult{"scheduling", "real-time priority is allowed", "", false}
          : CheckResult{"scheduling", "real-time priority is refused",
                        "allow it: a line '@audio - rtprio 90' in /etc/security/limits.d/trephine.conf, "
                        "then log in again as a member of audio",
                        true});
  rlimit lock{};
  getrlimit(RLIMIT_MEMLOCK, &lock);
  const bool can_lock = lock.rlim_cur == RLIM_INFINITY || lock.rlim_cur >= (1u << 29) || geteuid() == 0;
  checks.push_back(
      {"locked memory",
       lock.rlim_cur == RLIM_INFINITY
           ? std::string("no limit")
           : format_text("at most %.0f MB", static_cast<double>(lock.rlim_cur) / 1e6),
       can_lock ? ""
                : "allow it: a line '@audio - memlock unlimited' in /etc/security/limits.d/trephine.conf",
       !can_lock});
  const double p50 = percentile(lateness_us, 50), p99 = percentile(lateness_us, 99);
  const bool is_late = p99 > 500;
  checks.push_back({"timer",
                    format_text("1 kHz, late by %.0f us (median), %.0f us (99 %%), at most %.0f us", p50, p99,
                                lateness_us.back()),
                    is_late ? "close other programs; set the processor's governor to performance" : "",
                    is_late});
  Status unwritten;
  if (!arguments.output.empty())
    unwritten = data_tools::write_file_atomically(arguments.output, timer_picture(lateness_us));
  if (unwritten) checks.push_back({"picture", unwritten->what, unwritten->remedy, true});

  const double free_gb = static_cast<double>(volume::available_memory_bytes()) / 1e9;
  checks.push_back({"memory", format_text("%.1f GB available", free_gb),
                    free_gb < 2 ? "close other programs: a large scan needs 1 GB and more" : "",
                    free_gb < 2});
  const std::string session_folder = workbench::autosave_folder();
  std::error_code error;
  const auto space = std::filesystem::space(session_folder, error);
  if (session_folder.empty() || error)
    checks.push_back({"sessions", "no folder for recorded sessions",
                      "set HOME or XDG_STATE_HOME to a folder of yours", true});
  else
    checks.push_back(
        {"sessions", format_text("%.1f GB free in their folder", static_cast<double>(space.available) / 1e9),
         space.available < (1u << 30) ? "free some space: an hour of recording needs up to 0.2 GB" : "",
         space.available < (1u << 30)});
  for (CheckResult& f : find_devices()) checks.push_back(std::move(f));

  Outcome outcome = outcome_of(checks);
  outcome.json["timer_late_us"] = percentiles(lateness_us);
  if (!arguments.output.empty()) outcome.print("picture of the timer: {path}", {{"path", arguments.output}});
  return outcome;
}

Run build_doctor(Options& options) {
  auto a = std::make_shared<DoctorArguments>();
  options.add("-o,--output", a->output, "Picture of the timer's lateness as a chart").type("OUT.svg");
  options.add("--devices", a->has_only_devices, "Check only haptic devices, 3-D mice and pedals");
  options
      .add("--device", a->device.device,
           "Measure rate, regularity and reads of this device while the hand moves: falcon, touch, omega, "
           "inverse3, spacemouse, virtual:PATH.csv")
      .type("NAME");
  options.add(
      "--feel", a->has_feel_test,
      "With --device: push the hand gently along three axes, and ask whether each push was perceived");
  options.add("--seconds", a->seconds, "Duration of the measurement of the timer or of the device")
      .shows_default();
  return run_with(a, run_doctor);
}

}  // namespace

const Command k_doctor{
    "doctor", "Check this machine, and suggest remedies for its faults",
    "  trephine doctor\n  trephine doctor --devices\n  trephine doctor --device falcon --feel", build_doctor};

}  // namespace trephine::cli
