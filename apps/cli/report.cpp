#include "apps/cli/report.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <glm/common.hpp>
#include <unistd.h>

#include "apps/cli/build_info.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "haptics/mesh/mesh_tree.h"
#include "volume/base/percentile.h"
#include "volume/base/work_counters.h"
#include "volume/fields/soft_field.h"

namespace trephine::cli {

namespace {
std::atomic<bool> g_keeps_identity{false};
std::atomic<bool> g_interrupted{false};  // global, because a signal handler sets it

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}
double monotonic() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
}  // namespace

Result<Outcome> finished(const data_tools::OutputSet& outputs, Outcome outcome, const char* hint) {
  if (Status error = outputs.result()) return *error;
  outcome.json["written"] = outputs.written();
  for (const std::string& path : outputs.written_paths()) outcome.print("wrote {path}", {{"path", path}});
  if (outputs.written().empty() && *hint != 0) outcome.print(hint);
  return outcome;
}

Json new_report(const std::string& name) {
  return {{"schema", "trephine." + name + "/1"},
          {"version", TREPHINE_VERSION},
          {"commit", TREPHINE_COMMIT},
          {"compiler", TREPHINE_COMPILER},
          {"cpu", cpu_name()}};
}

std::string program_name() {
  return std::string("trephine ") + TREPHINE_VERSION + " (" + TREPHINE_COMMIT + ", " + TREPHINE_COMPILER +
         ")";
}

Json error_report(const std::string& name, const Error& error) {
  Json json = new_report("error");
  json["command"] = name;
  json["error"] = {{"what", error.what},
                   {"where", error.where},
                   {"found", error.found},
                   {"expected", error.expected},
                   {"remedy", error.remedy}};
  return json;
}

std::string text_of_json(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

int exit_code_of(const Error& error) {
  switch (error.kind) {
    case ErrorKind::missing_here:
      return exit_missing_here;
    case ErrorKind::interrupted:
      return exit_interrupted;
    case ErrorKind::bad_input:
    case ErrorKind::refused:
    case ErrorKind::different:
      break;
  }
  return exit_bad_input;
}

Json percentiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {{"count", values.size()},
          {"p50", percentile(values, 50)},
          {"p99", percentile(values, 99)},
          {"p999", percentile(values, 99.9)},
          {"max", values.empty() ? 0 : values.back()}};
}

void notify_resampled(const volume::Volume& volume, const std::string& path) {
  if (!path.empty() && !volume.frame.is_orthogonal() && !data_tools::keeps_shear(path))
    notice(
        "note: the written volume was resampled to right angles (cubic between voxels, air outside): this "
        "format does not support sheared volumes");
}

bool keeps_identity() { return g_keeps_identity.load(); }
void keep_identity() { g_keeps_identity = true; }
std::string name_in_report(const workbench::Source& source) {
  return keeps_identity() ? source.name : source.written_name();
}

std::string for_terminal(const std::string& text, bool is_one_line) {
  std::string out;
  const auto byte = [&text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : static_cast<unsigned char>(0);
  };
  const auto show = [&](std::size_t from, std::size_t count) {
    for (std::size_t i = from; i < from + count; ++i) out += format_text("\\x%02x", byte(i));
  };
  for (std::size_t i = 0; i < text.size();) {
    const unsigned char c = byte(i);
    const std::size_t length = data_tools::utf8_length(text, i);
    if (length == 0) {
      show(i, 1);
      ++i;
      continue;
    }
    const bool is_control =
        (c < 0x20 && (c != '\n' || is_one_line)) || c == 0x7f || (c == 0xc2 && byte(i + 1) < 0xa0);
    // Characters that change the direction of writing: U+202A to 202E, U+2066 to 2069.
    const bool is_direction_mark =
        c == 0xe2 && ((byte(i + 1) == 0x80 && byte(i + 2) >= 0xaa && byte(i + 2) <= 0xae) ||
                      (byte(i + 1) == 0x81 && byte(i + 2) >= 0xa6 && byte(i + 2) <= 0xa9));
    if (is_control || is_direction_mark)
      show(i, length);
    else
      out.append(text, i, length);
    i += length;
  }
  return out;
}

std::string with_dashes(std::string text) {
  constexpr std::string_view k_option = "option ";
  for (std::size_t at = 0; (at = text.find('(', at)) != std::string::npos; ++at) {
    std::string names = text.substr(at, text.find(')', at) - at);
    if (!names.starts_with("(option ") && !names.starts_with("(omit option ")) continue;
    const std::size_t length = names.size();
    for (std::size_t i = 0; (i = names.find(k_option, i)) != std::string::npos;)
      names.replace(i, k_option.size(), "--");
    text.replace(at, length, names);
  }
  return text;
}

void notice(const std::string& text) {
  std::string line = with_dashes(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fprintf(stderr, "%s\n", for_terminal(line, true).c_str());
}

workbench::Listener terminal_listener() {
  return {notice,
          [](const char* label) {
            return [line = std::make_shared<ProgressLine>(label)](double share) { return (*line)(share); };
          },
          is_interrupted};
}

ProgressLine::~ProgressLine() {
  if (is_shown_) std::fprintf(stderr, "\r\033[K");
}

bool ProgressLine::operator()(double share) {
  static const double k_start = monotonic();
  static const int k_file = [] {
    const char* const number = std::getenv(k_progress_variable);
    return number ? std::atoi(number) : -1;
  }();
  const double now = monotonic();
  if (k_file >= 0 && now - last_ > 0.1) {
    last_ = now;
    if (::pwrite(k_file, &share, sizeof share, 0) != sizeof share) return !is_interrupted();
  }
  if (isatty(STDERR_FILENO) && now - k_start > 1 && now - last_ > 0.1) {
    std::fprintf(stderr, "\r%s %3.0f %%", label_.c_str(), 100 * share);
    last_ = now;
    is_shown_ = true;
  }
  return !is_interrupted();
}

bool is_interrupted() { return g_interrupted.load(); }
namespace {

/// The first signal requests an orderly end; a signal more than a second later ends the process at once.
/// Signals within that second count as the same request: timeout(1) and service managers signal a process and
/// then its whole group.
void handle_interrupt(int signal) {
  static std::atomic<std::int64_t> first_ms{0};
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t ms = std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
  std::int64_t first = 0;
  if (!first_ms.compare_exchange_strong(first, ms) && ms - first > 1000) {
    data_tools::remove_unfinished();
    std::signal(signal, SIG_DFL);
    std::raise(signal);  // it is delivered as soon as this handler returns
  }
  g_interrupted = true;
}

}  // namespace

void listen_for_interrupt() {
  struct sigaction action {};
  action.sa_handler = handle_interrupt;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction hang_up {};
  sigaction(SIGHUP, nullptr, &hang_up);
  if (hang_up.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // nohup(1) ignores SIGHUP
}
Error interrupted(const std::string& work, bool is_recorded) {
  return {work + (is_recorded ? " was interrupted; the session so far is kept, nothing else was written"
                              : " was interrupted; nothing was written"),
          "",
          "",
          "",
          "",
          ErrorKind::interrupted};
}

std::size_t resident_bytes() {
  std::ifstream in("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  in >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

double process_seconds() {
  // Field 22 of /proc/self/stat: start in clock ticks since boot.
  std::ifstream in("/proc/self/stat");
  std::string line;
  std::getline(in, line);
  std::size_t at = line.rfind(')') + 2;
  for (int field = 3; field < 22; ++field) at = line.find(' ', at) + 1;
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  const double start = std::stod(line.substr(at)) / static_cast<double>(sysconf(_SC_CLK_TCK));
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) - start;
}

void print_shape_location(const haptics::TouchScene& scene, const haptics::PosePath& path) {
  const volume::Volume& base = *scene.base;
  glm::dvec3 shape_low(1e300), shape_high(-1e300), path_low(1e300), path_high(-1e300);
  for (int z = 0; z < base.size.z; ++z)
    for (int y = 0; y < base.size.y; ++y)
      for (int x = 0; x < base.size.x; ++x) {
        if (!scene.items[0].bits->is_solid({x, y, z})) continue;
        const glm::dvec3 p = base.frame.world_from_volume({x, y, z});
        shape_low = glm::min(shape_low, p), shape_high = glm::max(shape_high, p);
      }
  for (const haptics::PosePath::Sample& s : path.samples())
    path_low = glm::min(path_low, s.pose.position_world),
    path_high = glm::max(path_high, s.pose.position_world);
  const auto box = [](const glm::dvec3& a, const glm::dvec3& b) {
    return format_text("x %.0f to %.0f, y %.0f to %.0f, z %.0f to %.0f mm", a.x, b.x, a.y, b.y, a.z, b.z);
  };
  for (const haptics::TouchItem& item : scene.items) {
    if (!item.is_mesh() || !item.tree || item.tree->triangle_count() == 0) continue;
    for (const glm::dvec3& v : item.tree->vertices()) {
      const glm::dvec3 p = item.placement.world_from_local(v);
      shape_low = glm::min(shape_low, p), shape_high = glm::max(shape_high, p);
    }
  }
  notice("note: the path touched nothing; the touchable objects are within " + box(shape_low, shape_high) +
         ", the path is within " + box(path_low, path_high) +
         " (x to the patient's left, y to the back, z up)");
}

Json memory_report(const haptics::TouchScene& scene, const volume::Version& version) {
  std::size_t bits = 0;
  for (const haptics::TouchItem& shape : scene.items)
    bits += (shape.bits ? shape.bits->bytes() : 0) + (shape.soft ? shape.soft->bytes() : 0);
  const std::size_t base = scene.base->bytes(), tables = version.bytes();
  return {{"voxels_bytes", scene.base->voxels.bytes()},
          {"base_bytes", base},
          {"bits_bytes", bits},
          {"version_bytes", tables},
          {"held_bytes", base + bits + tables},
          {"held_over_voxels",
           static_cast<double>(base + bits + tables) / static_cast<double>(scene.base->voxels.bytes())},
          {"shapes_with_bits", work_counters().occupancies.load()},
          {"resident_bytes", resident_bytes()}};
}

}  // namespace trephine::cli
