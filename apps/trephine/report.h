// Answer of a command: for people, for programs, and as an exit code.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/workbench/clock.h"
#include "apps/workbench/listener.h"
#include "apps/workbench/source.h"
#include "apps/workbench/text.h"
#include "data-tools/output_set.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::app {

using workbench::Clock;
using workbench::format_text;
using workbench::hash_text;
using workbench::seconds_since;
using Json = nlohmann::ordered_json;

enum ExitCode {
  exit_done = 0,
  exit_check_failed = 1,
  exit_bad_input = 2,
  exit_missing_here = 3,
  exit_interrupted = 130
};

/// The result of a command that ran: `text` for people or `json` for programs goes to stdout.
struct Outcome {
  Json json;
  std::string text;
  int exit_code = exit_done;
};

/// Final answer of a command that wrote files: lists them, in both forms; `hint` where it was asked
/// for none. Error: one could not be written.
volume::Result<Outcome> finished(const data_tools::OutputSet& outputs, Outcome outcome,
                                 const char* hint = "");

/// An object with `schema` ("trephine.NAME/1"), version, commit, compiler and cpu, to which a command adds
/// its own.
Json new_report(const std::string& name);
inline Json json_of(const glm::dvec3& p) { return {p.x, p.y, p.z}; }
/// Report of an error: schema trephine.error/1, whatever the command.
Json error_report(const std::string& name, const volume::Error& error);
int exit_code_of(const volume::Error& error);
/// As text, whatever bytes are in names: what is no UTF-8 is replaced.
std::string text_of_json(const Json& json, int indent = 2);

/// Nearest-rank percentiles, in the unit of the values (docs/performance.md). Sorts its copy.
Json percentiles(std::vector<double> values);

/// "trephine 0.1.0 (commit, compiler)".
std::string program_name();

/// Memory by our own accounting: base voxels, labels, bits and tables.
Json memory_report(const haptics::TouchScene& scene, const volume::Version& version);

/// Text as a terminal may be given it: what names in it could have a terminal do is shown, not done.
/// On one line: ends of lines are shown, too, so that a name cannot look like a message.
std::string for_terminal(const std::string& text, bool is_one_line = false);
/// May names of folders and files stand in reports? Said once, by --keep-identity.
bool keeps_identity();
void keep_identity();
/// Name of a scan in a report.
std::string name_in_report(const workbench::Source& source);

/// Says that a file of this volume holds it at right angles, when it does. No path: nothing is written.
void tell_resampled(const volume::Volume& volume, const std::string& path);
/// A notice to a person: stderr.
void notice(const std::string& text);
/// The person at this terminal: notices and progress to stderr.
workbench::Listener person();
/// When a path met nothing: says where the shape lies and where the path went.
void say_where(const haptics::TouchScene& scene, const haptics::PosePath& path);
/// Progress on a terminal only; a line that is rewritten, at most ten times a second. Returns false when the
/// person pressed Ctrl-C.
class ProgressLine {
 public:
  explicit ProgressLine(std::string what) : what_(std::move(what)) {}
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  bool operator()(double share);

 private:
  std::string what_;
  double last_ = -1;
  bool is_shown_ = false;
};

/// Did the person press Ctrl-C? Commands look at it in their loops.
bool is_interrupted();
void listen_for_interrupt();
/// `is_recorded`: what was done until then stays in a session.
volume::Error interrupted(const std::string& what, bool is_recorded = false);

/// Bytes of resident memory of this process.
std::size_t resident_bytes();
/// Seconds since the process started, by the kernel's clock.
double process_seconds();

}  // namespace trephine::app
