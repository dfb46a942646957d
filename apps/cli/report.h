// Outcome: result of a command, as text, as JSON and as an exit code. Reports, notices and progress.
#pragma once

#include <string>
#include <vector>

#include "apps/cli/rows.h"
#include "apps/workbench/clock.h"
#include "apps/workbench/listener.h"
#include "apps/workbench/source.h"
#include "apps/workbench/text.h"
#include "data-tools/files/output_set.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::cli {

using workbench::Clock;
using workbench::format_text;
using workbench::hash_text;
using workbench::seconds_since;

enum ExitCode {
  exit_done = 0,
  exit_check_failed = 1,
  exit_bad_input = 2,
  exit_missing_here = 3,
  exit_interrupted = 130
};

/// Returns an object with `schema` ("trephine.NAME/1"), version, commit, compiler and cpu, to which a command
/// adds its results.
Json new_report(const std::string& name);

/// The result of a command that ran: `text` for people or `json` for programs goes to stdout.
struct Outcome : Rows {
  explicit Outcome(const std::string& report, int code = exit_done)
      : Rows{new_report(report), ""}, exit_code(code) {}
  int exit_code;
};

/// Adds the list of written files to the outcome, as text and JSON. Prints `hint` if no file was written.
/// Error: a file could not be written.
Result<Outcome> finished(const data_tools::OutputSet& outputs, Outcome outcome, const char* hint = "");

inline Json json_of(const glm::dvec3& p) { return {p.x, p.y, p.z}; }
/// Report of an error of any command: schema trephine.error/1.
Json error_report(const std::string& name, const Error& error);
int exit_code_of(const Error& error);
/// Serialises JSON; invalid UTF-8, as in file names, is replaced.
std::string text_of_json(const Json& json, int indent = 2);

/// Nearest-rank percentiles, in the unit of the values (docs/performance.md). Sorts its copy.
Json percentiles(std::vector<double> values);

/// "trephine 0.1.0 (commit, compiler)".
std::string program_name();

/// Returns the memory of base voxels, labels, bits and tables by our own accounting, and the resident memory
/// of the process, in bytes.
Json memory_report(const haptics::TouchScene& scene, const volume::Version& version);

/// Escapes control characters, invalid UTF-8 and marks of the writing direction, so that names in a text
/// cannot control a terminal. `is_one_line`: escapes line ends as well, so that a name cannot look like a
/// message.
std::string for_terminal(const std::string& text, bool is_one_line = false);
/// True if reports may contain the names of folders and files; set once, by --keep-identity.
bool keeps_identity();
void keep_identity();
/// Returns the name of a scan in a report. The name of its file is included with --keep-identity only.
std::string name_in_report(const workbench::Source& source);

/// Prints a notice if the file format stores this sheared volume resampled to right angles. An empty path
/// prints nothing.
void notify_resampled(const volume::Volume& volume, const std::string& path);
/// Prints a notice on one line of stderr.
void notice(const std::string& text);
/// Returns a text of a library in which options have the form of the command line: "(option scale 2)" becomes
/// "(--scale 2)".
std::string with_dashes(std::string text);
/// Returns a listener that prints notices and progress to stderr.
workbench::Listener terminal_listener();
/// Prints the bounding box of the first shape and the models, and that of a path that touched nothing.
void print_shape_location(const haptics::TouchScene& scene, const haptics::PosePath& path);
/// Environment variable with the number of a file that receives the shares of progress lines, as a double at
/// its start, and the number that run_own_program() uses.
inline constexpr const char* k_progress_variable = "TREPHINE_PROGRESS_FILE";
inline constexpr int k_progress_file = 3;

/// Progress line on a terminal, rewritten at most ten times per second. Prints nothing on other outputs, and
/// nothing in the first second after the first call of any progress line. Returns false after an interrupt.
class ProgressLine {
 public:
  explicit ProgressLine(std::string label) : label_(std::move(label)) {}
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  bool operator()(double share);

 private:
  std::string label_;
  double last_ = -1;
  bool is_shown_ = false;
};

/// True after Ctrl-C, SIGTERM or SIGHUP. Commands poll it in their loops.
bool is_interrupted();
void listen_for_interrupt();
/// Error of interrupted work. `is_recorded`: the work done so far remains in a session.
Error interrupted(const std::string& work, bool is_recorded = false);

/// Resident memory of this process, in bytes.
std::size_t resident_bytes();
/// Seconds since the process started, by the kernel's clock.
double process_seconds();

}  // namespace trephine::cli
