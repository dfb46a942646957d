// Inputs and outputs of a command, declared before it begins: nothing that is read is replaced, no two
// outputs are one file, and one that fails takes no other with it.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "volume/error.h"

namespace trephine::data_tools {

/// Kind of a written file; its extensions are a table in output_set.cpp.
enum class OutputKind { any, volume, mesh, picture, table, folder };  // folder: a new one

/// ".mha, .nrrd, .nii or .nii.gz": those of a kind, for people; empty for any.
std::string extensions_of(OutputKind kind);
/// Does the name end with an extension of the kind, whatever its case?
bool is_output_of(OutputKind kind, const std::string& path);
/// That, as an error.
volume::Status check_extension(OutputKind kind, const std::string& path);

class OutputSet {
 public:
  /// A file that is read, a folder with all that lies in it, a header with its voxels. Empty: nothing.
  void reads(const std::string& path);
  /// A file that will be written: `name` is what reports call it ("output"). Empty: nothing.
  void writes(std::string name, const std::string& path, OutputKind kind = OutputKind::any);
  /// Before any work is done: what would keep one of them from being written, or lose what was given.
  volume::Status check() const;

  /// Has the one of that path written; nothing when the path is empty. What fails is kept for result().
  void write(const std::string& path, const std::function<volume::Status()>& write);
  /// Adds the end of a recording: its failure is one of result().
  void recorded(const volume::Status& ended);
  /// When all are done: what failed, and which others are there all the same.
  volume::Status result() const;
  /// Names of those that are written, in order.
  const std::vector<std::string>& written() const { return written_; }

 private:
  struct Output {
    std::string name, path;
    OutputKind kind;
  };
  std::vector<std::string> inputs_;
  std::vector<Output> outputs_;
  std::vector<std::string> written_;
  std::vector<volume::Error> failed_;
};

}  // namespace trephine::data_tools
