#include "data-tools/files/atomic_file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

namespace trephine::data_tools {

namespace fs = std::filesystem;

namespace {

constexpr const char *k_prefix = ".trephine-", *k_number = "####";

Error write_error(const std::string& path, const std::string& found, const std::string& expected,
                  const std::string& remedy) {
  return Error{.what = "the file cannot be written",
               .where = file_name(path),
               .found = found,
               .expected = expected,
               .remedy = remedy};
}

/// A partly written file or folder, registered so that the handler of a signal can remove it.
class UnfinishedFile {
 public:
  /// Registers a file or a folder; the files of a folder are registered separately. "####" in a path means
  /// 0001 to `number_count`. A path that is too long, or for which no slot is free, is not registered.
  explicit UnfinishedFile(const std::string& path, int number_count = 0) {
    if (path.size() >= Slot{}.path.size()) return;
    for (Slot& slot : slots()) {
      int expected = k_free;
      if (!slot.state.compare_exchange_strong(expected, k_filling)) continue;
      std::memcpy(slot.path.data(), path.c_str(), path.size() + 1);
      const std::size_t digits = path.rfind(k_number);
      slot.number_count = digits == std::string::npos ? 0 : number_count;
      slot.digits = digits;
      slot.state = k_set;
      slot_ = &slot;
      return;
    }
  }
  ~UnfinishedFile() {
    if (slot_) slot_->state = k_free;
  }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  /// Removes all registered files, then folders. Async-signal-safe.
  static void remove_all() noexcept {
    for (Slot& slot : slots()) {
      if (slot.state != k_set) continue;
      for (int n = 1; n <= slot.number_count; ++n) {
        for (std::size_t i = 0, rest = static_cast<std::size_t>(n); i < 4; ++i, rest /= 10)
          slot.path[slot.digits + 3 - i] = static_cast<char>('0' + rest % 10);
        ::unlink(slot.path.data());
      }
      if (slot.number_count == 0) ::unlink(slot.path.data());
    }
    for (Slot& slot : slots())
      if (slot.state == k_set) ::rmdir(slot.path.data());
  }

 private:
  static constexpr int k_free = 0, k_filling = 1, k_set = 2;
  struct Slot {
    std::atomic<int> state{k_free};
    std::array<char, 4096> path{};
    int number_count = 0;
    std::size_t digits = 0;  ///< position of the number in the path
  };
  static std::array<Slot, 16>& slots() {
    static std::array<Slot, 16> all;
    return all;
  }
  Slot* slot_ = nullptr;
};

/// Syncs the bytes of a file, or the entries of a folder, to the disk; returns an errno, or 0.
int sync_path(const fs::path& path, int flags) {
  const int file = ::open(path.c_str(), flags | O_CLOEXEC);
  if (file < 0) return errno;
  const int number = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  return number;
}
int sync_folder(const fs::path& folder) { return sync_path(folder, O_RDONLY | O_DIRECTORY); }

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

/// Resolves symbolic links, also if the last target does not exist.
fs::path resolve_links(fs::path path) {
  std::error_code error;
  for (int i = 0; i < 40 && fs::is_symlink(path, error); ++i) {
    const fs::path target = fs::read_symlink(path, error);
    if (error) break;
    path = target.is_absolute() ? target : folder_of(path) / target;
  }
  return path;
}

/// Returns a file's name, or only the end of a long name, because temporary_path() adds a prefix.
std::string name_suffix(const fs::path& target) {
  constexpr std::size_t k_max = 160;
  const std::string name = target.filename().string();
  return name.size() > k_max ? name.substr(name.size() - k_max) : name;
}

/// Returns a unique path in the same folder that includes the process id. The extension stays last: writers
/// select the format by it (".nii.gz" has two).
fs::path temporary_path(const fs::path& target) {
  static std::atomic<int> count{0};
  return folder_of(target) /
         (k_prefix + std::to_string(::getpid()) + "-" + std::to_string(++count) + "-" + name_suffix(target));
}

/// Removes temporary files of this target that are over an hour old and whose process no longer runs.
void remove_abandoned(const fs::path& target) {
  std::error_code error;
  const std::string name = name_suffix(target);
  for (fs::directory_iterator it(folder_of(target), error), end; !error && it != end; it.increment(error)) {
    const std::string found = it->path().filename().string();
    if (!found.starts_with(k_prefix) || !found.ends_with("-" + name)) continue;
    int process = 0;
    const char* digits = found.c_str() + std::strlen(k_prefix);
    if (std::from_chars(digits, found.c_str() + found.size(), process).ec != std::errc() || process <= 0)
      continue;
    std::error_code ignored;
    const auto age = fs::file_time_type::clock::now() - fs::last_write_time(it->path(), ignored);
    if (::kill(process, 0) != 0 && errno == ESRCH && age > std::chrono::hours(1))
      fs::remove_all(it->path(), ignored);
  }
}

/// Renames a file or folder, and syncs the folder that contains it; returns an errno, or 0.
int rename_durably(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) return errno;
  sync_folder(folder_of(to));
  return 0;
}

}  // namespace

Error cannot_write(const std::string& path, int number) {
  Error error = write_error(path, number != 0 ? std::strerror(number) : "", "a disk with enough free space",
                            "free disk space, or choose another folder");
  error.kind = ErrorKind::missing_here;
  if (number == EACCES || number == EPERM || number == EROFS) {
    error.expected = "a folder that may be written";
    error.remedy = "choose another folder, or request write permission";
  }
  if (number == ENOENT || number == ENOTDIR || number == ENAMETOOLONG) {
    error.kind = ErrorKind::bad_input;
    error.expected = "a folder that exists, and a name that is not too long";
    error.remedy = "check the spelling, or shorten the name";
  }
  return error;
}

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
  const fs::path target = resolve_links(path), folder = folder_of(target);
  std::error_code ignored;
  if (target.filename().empty() || fs::is_directory(target, ignored))
    return write_error(path, "a folder", "the name of a file", "choose another name");
  if (fs::is_symlink(target, ignored))
    return write_error(path, "a link without a target", "a plain file or an unused name",
                       "choose another name");
  if (!fs::is_directory(folder, ignored))
    return write_error(path, "its folder does not exist", "a folder that exists",
                       "check the spelling, or make the folder first");
  if (fs::exists(target, ignored) && !fs::is_regular_file(target, ignored))
    return write_error(path, "a pipe, a device or a socket of that name", "a plain file or an unused name",
                       "choose another name");
  if (::access(folder.c_str(), W_OK) != 0) return cannot_write(path, errno);
  if (fs::exists(target, ignored) && ::access(target.c_str(), W_OK) != 0)
    return write_error(path, "a file of that name that is protected against writing",
                       "a file that may be replaced", "choose another name");
  return std::nullopt;
}

Status write_atomically(const std::string& path, const std::function<Status(const std::string&)>& write) {
  if (Status error = check_writable(path)) return error;
  const fs::path target = resolve_links(path), temporary = temporary_path(target);
  remove_abandoned(target);
  const UnfinishedFile unfinished(temporary.string());
  Status status = write(temporary.string());
  struct stat existing {};
  if (!status && ::stat(target.c_str(), &existing) == 0) ::chmod(temporary.c_str(), existing.st_mode & 07777);
  if (!status)
    if (const int number = sync_path(temporary, O_RDONLY)) status = cannot_write(path, number);
  if (!status)
    if (const int number = rename_durably(temporary, target)) status = cannot_write(path, number);
  std::error_code ignored;
  if (status) fs::remove(temporary, ignored);
  return status;
}

Status write_file_atomically(const std::string& path, const std::string& contents) {
  return write_atomically(path, [&](const std::string& temporary) -> Status {
    std::ofstream out(temporary, std::ios::binary);
    out.write(contents.data(), static_cast<std::streamsize>(contents.size()));
    out.close();
    if (!out) return cannot_write(path, errno);
    return std::nullopt;
  });
}

namespace {

fs::path strip_slash(const fs::path& path) { return path.has_filename() ? path : path.parent_path(); }

}  // namespace

Status check_new_folder(const std::string& path) {
  const fs::path target = strip_slash(path), folder = folder_of(target);
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(target, ignored)))
    return Error{.what = "the output already exists",
                 .where = file_name(target.string()) + "/",
                 .expected = "the name of a new folder",
                 .remedy = "choose another name, or remove the existing one"};
  if (!fs::is_directory(folder, ignored))
    return write_error(path, "its folder does not exist", "a folder that exists",
                       "check the spelling, or make the folder first");
  return ::access(folder.c_str(), W_OK) != 0 ? Status(cannot_write(path, errno)) : std::nullopt;
}

Status write_folder_atomically(const std::string& path, const std::vector<std::string>& files,
                               const std::function<Status(const std::string&)>& write, int number_count) {
  if (Status error = check_new_folder(path)) return error;
  const fs::path target = strip_slash(path);
  std::error_code ignored;
  const fs::path folder = temporary_path(target);
  remove_abandoned(target);
  if (::mkdir(folder.c_str(), 0755) != 0) return cannot_write(path, errno);
  std::vector<std::unique_ptr<UnfinishedFile>> unfinished;
  unfinished.push_back(std::make_unique<UnfinishedFile>(folder.string()));
  for (const std::string& file : files)
    unfinished.push_back(std::make_unique<UnfinishedFile>((folder / file).string(), number_count));
  Status status = write(folder.string());
  if (!status) sync_folder(folder);
  if (!status)
    if (const int number = rename_durably(folder, target)) status = cannot_write(path, number);
  if (status) fs::remove_all(folder, ignored);
  return status;
}

Status make_folder(const std::string& path) {
  std::error_code failure;
  fs::create_directories(path, failure);
  if (!failure) return std::nullopt;
  Error error = cannot_write(path, failure.value());
  error.what = "the folder cannot be created";
  return error;
}

void remove_unfinished() noexcept { UnfinishedFile::remove_all(); }

}  // namespace trephine::data_tools
