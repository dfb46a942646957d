#include "data-tools/atomic_file.h"

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
using volume::Error;
using volume::Status;

namespace {

constexpr const char *k_prefix = ".trephine-", *k_number = "####";

Error not_written(const std::string& path, const std::string& found, const std::string& expected,
                  const std::string& remedy) {
  return {"the file cannot be written", file_name(path), found, expected, remedy};
}

/// Half-written files, where the handler of a signal finds them.
class Unfinished {
 public:
  /// A file, or a folder when its files were named before. "####" in the name stands for 0001 to `numbered`.
  explicit Unfinished(const std::string& path, int numbered = 0) {
    if (path.size() >= Slot{}.path.size()) return;
    for (Slot& slot : slots()) {
      int expected = k_free;
      if (!slot.state.compare_exchange_strong(expected, k_filling)) continue;
      std::memcpy(slot.path.data(), path.c_str(), path.size() + 1);
      const std::size_t digits = path.rfind(k_number);
      slot.numbered = digits == std::string::npos ? 0 : numbered;
      slot.digits = digits;
      slot.state = k_set;
      slot_ = &slot;
      return;
    }
  }
  ~Unfinished() {
    if (slot_) slot_->state = k_free;
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  static void remove_all() noexcept {
    for (Slot& slot : slots()) {
      if (slot.state != k_set) continue;
      for (int n = 1; n <= slot.numbered; ++n) {
        for (std::size_t i = 0, rest = static_cast<std::size_t>(n); i < 4; ++i, rest /= 10)
          slot.path[slot.digits + 3 - i] = static_cast<char>('0' + rest % 10);
        ::unlink(slot.path.data());
      }
      if (slot.numbered == 0) ::unlink(slot.path.data());
    }
    for (Slot& slot : slots())
      if (slot.state == k_set) ::rmdir(slot.path.data());
  }

 private:
  static constexpr int k_free = 0, k_filling = 1, k_set = 2;
  struct Slot {
    std::atomic<int> state{k_free};
    std::array<char, 4096> path{};
    int numbered = 0;
    std::size_t digits = 0;  ///< where the number stands
  };
  static std::array<Slot, 16>& slots() {
    static std::array<Slot, 16> all;
    return all;
  }
  Slot* slot_ = nullptr;
};

/// Makes sure that a file's bytes (or a folder's entries) survive a power cut; an errno, or 0.
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

/// Target of a link, to its end, whether it is there or not.
fs::path without_links(fs::path path) {
  std::error_code error;
  for (int i = 0; i < 40 && fs::is_symlink(path, error); ++i) {
    const fs::path named = fs::read_symlink(path, error);
    if (error) break;
    path = named.is_absolute() ? named : folder_of(path) / named;
  }
  return path;
}

/// A file's name, or the end of it where there is no room for more with ours.
std::string end_of_name(const fs::path& target) {
  constexpr std::size_t k_most = 160;
  const std::string name = target.filename().string();
  return name.size() > k_most ? name.substr(name.size() - k_most) : name;
}

/// A name in the same folder that says whose it is. The extension stays last: writers choose the format by it
/// (".nii.gz" has two).
fs::path temporary_for(const fs::path& target) {
  static std::atomic<int> count{0};
  return folder_of(target) /
         (k_prefix + std::to_string(::getpid()) + "-" + std::to_string(++count) + "-" + end_of_name(target));
}

/// Leftovers of this file by a program that was killed: its process is gone, and they are an hour old.
void remove_abandoned(const fs::path& target) {
  std::error_code error;
  const std::string name = end_of_name(target);
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

/// A rename that lasts; an errno, or 0.
int move_into_place(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) return errno;
  sync_folder(folder_of(to));
  return 0;
}

}  // namespace

Error cannot_write(const std::string& path, int number) {
  Error error = not_written(path, number != 0 ? std::strerror(number) : "", "a place with room for it",
                            "make room, or choose another place");
  error.kind = volume::ErrorKind::missing_here;
  if (number == EACCES || number == EPERM || number == EROFS) {
    error.expected = "a folder that may be written";
    error.remedy = "choose another place, or ask for the permission";
  }
  if (number == ENOENT || number == ENOTDIR || number == ENAMETOOLONG) {
    error.kind = volume::ErrorKind::bad_input;
    error.expected = "a folder that exists, and a name that fits";
    error.remedy = "check the spelling";
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
  const fs::path target = without_links(path), folder = folder_of(target);
  std::error_code ignored;
  if (target.filename().empty() || fs::is_directory(target, ignored))
    return not_written(path, "a folder", "the name of a file", "choose another name");
  if (fs::is_symlink(target, ignored))
    return not_written(path, "a link that leads nowhere", "a plain file, or none yet", "choose another name");
  if (!fs::is_directory(folder, ignored))
    return not_written(path, "its folder does not exist", "a folder that exists",
                       "check the spelling, or make the folder first");
  if (fs::exists(target, ignored) && !fs::is_regular_file(target, ignored))
    return not_written(path, "a pipe, a device or a socket of that name", "a plain file, or none yet",
                       "choose another name");
  if (::access(folder.c_str(), W_OK) != 0) return cannot_write(path, errno);
  if (fs::exists(target, ignored) && ::access(target.c_str(), W_OK) != 0)
    return not_written(path, "a file of that name that is protected against writing",
                       "one that may be replaced", "choose another name");
  return std::nullopt;
}

Status write_atomically(const std::string& path, const std::function<Status(const std::string&)>& write) {
  if (Status error = check_writable(path)) return error;
  const fs::path target = without_links(path), temporary = temporary_for(target);
  remove_abandoned(target);
  const Unfinished unfinished(temporary.string());
  Status status = write(temporary.string());
  struct stat older {};
  if (!status && ::stat(target.c_str(), &older) == 0) ::chmod(temporary.c_str(), older.st_mode & 07777);
  if (!status)
    if (const int number = sync_path(temporary, O_RDONLY)) status = cannot_write(path, number);
  if (!status)
    if (const int number = move_into_place(temporary, target)) status = cannot_write(path, number);
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

fs::path without_slash(const fs::path& path) { return path.has_filename() ? path : path.parent_path(); }

}  // namespace

Status check_new_folder(const std::string& path) {
  const fs::path target = without_slash(path), folder = folder_of(target);
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(target, ignored)))
    return Error{"there is something of that name already", file_name(target.string()) + "/", "",
                 "the name of a new folder", "choose another name, or remove it first"};
  if (!fs::is_directory(folder, ignored))
    return not_written(path, "its folder does not exist", "a folder that exists",
                       "check the spelling, or make the folder first");
  return ::access(folder.c_str(), W_OK) != 0 ? Status(cannot_write(path, errno)) : std::nullopt;
}

Status write_folder_atomically(const std::string& path, const std::vector<std::string>& files,
                               const std::function<Status(const std::string&)>& write, int numbered) {
  if (Status refused = check_new_folder(path)) return refused;
  const fs::path target = without_slash(path);
  std::error_code error;
  const fs::path made = temporary_for(target);
  remove_abandoned(target);
  if (::mkdir(made.c_str(), 0755) != 0) return cannot_write(path, errno);
  std::vector<std::unique_ptr<Unfinished>> unfinished;
  unfinished.push_back(std::make_unique<Unfinished>(made.string()));
  for (const std::string& file : files)
    unfinished.push_back(std::make_unique<Unfinished>((made / file).string(), numbered));
  Status status = write(made.string());
  if (!status) sync_folder(made);
  if (!status)
    if (const int number = move_into_place(made, target)) status = cannot_write(path, number);
  if (status) fs::remove_all(made, error);
  return status;
}

Status make_folder(const std::string& path) {
  std::error_code failed;
  fs::create_directories(path, failed);
  if (!failed) return std::nullopt;
  Error error = cannot_write(path, failed.value());
  error.what = "the folder cannot be made";
  return error;
}

void remove_unfinished() noexcept { Unfinished::remove_all(); }

}  // namespace trephine::data_tools
