#include "data-tools/atomic_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Error;
using volume::Status;

namespace {

Error cannot_write(const std::string& path, const std::string& why) {
  return Error{"the file cannot be written", file_name(path), why,
               "a folder that exists, may be written and has room", "choose another place, or make room"};
}

/// Makes sure that a file's bytes (or a folder's entries) survive a power cut.
bool sync_path(const std::string& path, int flags) {
  const int file = ::open(path.c_str(), flags);
  if (file < 0) return false;
  const bool is_synced = ::fsync(file) == 0;
  ::close(file);
  return is_synced;
}

}  // namespace

bool has_extension(const std::string& path, const std::string& end) {
  if (path.size() < end.size()) return false;
  return std::equal(
      end.begin(), end.end(), path.end() - static_cast<std::ptrdiff_t>(end.size()),
      [](char e, char p) { return e == (p >= 'A' && p <= 'Z' ? static_cast<char>(p - 'A' + 'a') : p); });
}

std::string file_name(const std::string& path) {
  std::string trimmed = path;
  while (trimmed.size() > 1 && trimmed.back() == '/') trimmed.pop_back();
  const std::string name = fs::path(trimmed).filename().string();
  return name.empty() ? trimmed : name;
}

Status check_writable(const std::string& path) {
  const fs::path target(path);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return cannot_write(path, "its folder does not exist");
  if (fs::is_directory(target, ignored)) return cannot_write(path, "there is a folder of that name");
  if (::access(folder.c_str(), W_OK) != 0) return cannot_write(path, std::strerror(errno));
  return std::nullopt;
}

Status write_atomically(const std::string& path, const std::function<Status(const std::string&)>& write) {
  const fs::path target(path);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code ignored;
  if (Status error = check_writable(path)) return error;
  // The extension stays last: writers choose the format by it (".nii.gz" has two).
  const std::string name = target.filename().string();
  const fs::path temporary = folder / (".trephine-" + std::to_string(::getpid()) + "-" + name);
  Status status = write(temporary.string());
  if (!status && !sync_path(temporary.string(), O_RDONLY)) status = cannot_write(path, std::strerror(errno));
  if (!status && ::rename(temporary.c_str(), target.c_str()) != 0)
    status = cannot_write(path, std::strerror(errno));
  if (status)
    fs::remove(temporary, ignored);
  else
    sync_path(folder.string(), O_RDONLY | O_DIRECTORY);
  return status;
}

Status write_file_atomically(const std::string& path, const std::string& contents) {
  return write_atomically(path, [&](const std::string& temporary) -> Status {
    std::ofstream out(temporary, std::ios::binary);
    out.write(contents.data(), static_cast<std::streamsize>(contents.size()));
    out.close();
    if (!out) return cannot_write(path, std::strerror(errno));
    return std::nullopt;
  });
}

}  // namespace trephine::data_tools
