// OutputSet: inputs and outputs of a command, declared in advance. No input is replaced, no two outputs are
// one file, and a failed output does not affect the others.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "volume/base/error.h"

namespace trephine::data_tools {

/// Kind of a written file; its extensions are in a table of the implementation.
enum class OutputKind { any, volume, mesh, picture, chart, table, data, folder };  // folder: a new folder

/// Returns the extensions of a kind as text, for example ".h5 or .hdf5"; empty for `any` and `folder`.
std::string extensions_of(OutputKind kind);
/// Returns true if the name ends with an extension of the kind, ignoring case, or if the kind has no
/// extensions.
bool is_output_of(OutputKind kind, const std::string& path);
/// Error if is_output_of() is false.
Status check_extension(OutputKind kind, const std::string& path);

class OutputSet {
 public:
  /// Declares an input: a file, a folder and its contents, or a header and its voxels. Ignores an empty path.
  void add_input(const std::string& path);
  /// Declares an output; `name` is its name in reports, such as "output". Ignores an empty path.
  void add_output(std::string name, const std::string& path, OutputKind kind = OutputKind::any);
  /// Checks in advance that every output can be written and replaces no input.
  Status check() const;

  /// Calls `write` for the output that was declared with `path`; ignores an empty path. A failure is kept for
  /// result().
  void write(const std::string& path, const std::function<Status()>& write);
  /// Adds the status of a recording: its failure is included in result().
  void add_recording_status(const Status& status);
  /// Returns the first failure, with the locations of all failures and the names of the written outputs. Call
  /// this method after all write() calls.
  Status result() const;
  /// Returns the names of the written outputs, in order.
  const std::vector<std::string>& written() const { return written_; }
  /// Returns the paths of the written outputs, in order.
  const std::vector<std::string>& written_paths() const { return written_paths_; }

 private:
  struct Output {
    std::string name, path;
    OutputKind kind;
  };
  std::vector<std::string> inputs_;
  std::vector<Output> outputs_;
  std::vector<std::string> written_, written_paths_;
  std::vector<Error> failures_;
};

}  // namespace trephine::data_tools
