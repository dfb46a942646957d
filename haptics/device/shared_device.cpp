#include "haptics/device/shared_device.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace trephine::haptics {

namespace {

constexpr std::size_t k_size = 4096;

std::string file_of(int index) {
  return "/dev/shm/trephine-virtual-" + std::to_string(::getuid()) + "-" + std::to_string(index);
}

struct Header {
  std::array<char, 8> magic{'T', 'R', 'E', 'P', 'H', 'D', 'E', 'V'};
  std::uint32_t layout = 1, reserved = 0;
};

/// Returns true if a file begins with the header.
bool is_device_file(int descriptor) {
  Header header;
  const Header expected;
  return ::pread(descriptor, &header, sizeof header, 0) == static_cast<ssize_t>(sizeof header) &&
         header.magic == expected.magic && header.layout == expected.layout;
}

Error failed(std::string what, int index, const char* remedy) {
  return Error{.what = std::move(what),
               .where = "shared device",
               .found = "device " + std::to_string(index),
               .remedy = remedy,
               .kind = ErrorKind::missing_here};
}

/// Opens a file that belongs to this user; -1 on failure.
int open_own(const std::string& file, int flags) {
  const int descriptor = ::open(file.c_str(), flags | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600);
  struct stat status {};
  if (descriptor >= 0 &&
      (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != ::getuid())) {
    ::close(descriptor);
    return -1;
  }
  return descriptor;
}

/// Returns true if a process holds the lock of the file.
bool has_host(int descriptor) {
  if (::flock(descriptor, LOCK_SH | LOCK_NB) != 0) return errno == EWOULDBLOCK;
  ::flock(descriptor, LOCK_UN);
  return false;
}

}  // namespace

Result<std::shared_ptr<SharedDeviceMemory>> SharedDeviceMemory::create(int index) {
  std::shared_ptr<SharedDeviceMemory> memory(new SharedDeviceMemory);
  const std::string file = file_of(index);
  memory->descriptor_ = open_own(file, O_CREAT);
  if (memory->descriptor_ < 0)
    return failed("the file of the virtual device cannot be created: " + file, index,
                  "remove what has this name, or check that this user may write to /dev/shm");
  if (::flock(memory->descriptor_, LOCK_EX | LOCK_NB) != 0)
    return failed("a virtual device with this index is already open", index,
                  "close its window, or choose another index");
  struct stat status {};
  const bool is_foreign = ::fstat(memory->descriptor_, &status) != 0 ||
                          (status.st_size > 0 && !is_device_file(memory->descriptor_));
  if (is_foreign)
    return failed("another file has the name of the virtual device: " + file, index,
                  "remove the file, or choose another index");
  // Zero first: a wrench of an earlier program must not act.
  const std::array<char, k_size> zero{};
  Header header;
  if (::ftruncate(memory->descriptor_, 0) != 0 ||
      ::pwrite(memory->descriptor_, zero.data(), zero.size(), 0) != static_cast<ssize_t>(zero.size()) ||
      ::pwrite(memory->descriptor_, &header, sizeof header, 0) != static_cast<ssize_t>(sizeof header))
    return failed("the file of the virtual device cannot be written", index, "free space in /dev/shm");
  memory->file_ = file;
  return memory;
}

Result<std::shared_ptr<SharedDeviceMemory>> SharedDeviceMemory::open(int index) {
  std::shared_ptr<SharedDeviceMemory> memory(new SharedDeviceMemory);
  memory->descriptor_ = open_own(file_of(index), 0);
  if (memory->descriptor_ < 0 || !has_host(memory->descriptor_))
    return failed("the virtual device is not open", index, "start it: trephine virtual-device");
  if (!is_device_file(memory->descriptor_))
    return failed("the virtual device is of another version", index, "start it with this version");
  struct flock client {};
  client.l_type = F_WRLCK, client.l_whence = SEEK_SET, client.l_start = k_wrench, client.l_len = 1;
  if (::fcntl(memory->descriptor_, F_OFD_SETLK, &client) != 0)
    return failed("another program uses the virtual device", index,
                  "close that program, or start a second device: trephine virtual-device --index 1");
  return memory;
}

bool SharedDeviceMemory::exists(int index) {
  const int descriptor = open_own(file_of(index), 0);
  if (descriptor < 0) return false;
  const bool result = has_host(descriptor) && is_device_file(descriptor);
  ::close(descriptor);
  return result;
}

SharedDeviceMemory::~SharedDeviceMemory() {
  if (!file_.empty()) ::unlink(file_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
}

void SharedDeviceMemory::set(long at, const void* value, std::size_t bytes) noexcept {
  // A short write, as on a full disk, leaves an odd sequence, and the reader gets nothing.
  const std::uint64_t odd = sequence_ + 1, even = sequence_ = sequence_ + 2;
  if (::pwrite(descriptor_, &odd, sizeof odd, at) != static_cast<ssize_t>(sizeof odd)) return;
  if (::pwrite(descriptor_, value, bytes, at + 8) != static_cast<ssize_t>(bytes)) return;
  if (::pwrite(descriptor_, &even, sizeof even, at) != static_cast<ssize_t>(sizeof even)) return;
}

bool SharedDeviceMemory::get(long at, void* value, std::size_t bytes) const noexcept {
  constexpr int k_attempts = 4;
  for (int attempt = 0; attempt < k_attempts; ++attempt) {
    std::uint64_t before = 0, after = 0;
    if (::pread(descriptor_, &before, sizeof before, at) != static_cast<ssize_t>(sizeof before) ||
        ::pread(descriptor_, value, bytes, at + 8) != static_cast<ssize_t>(bytes) ||
        ::pread(descriptor_, &after, sizeof after, at) != static_cast<ssize_t>(sizeof after))
      return false;
    if (before == after && before % 2 == 0) return before != 0;
  }
  return false;
}

Status SharedDevice::open() {
  close();
  auto memory = SharedDeviceMemory::open(index_);
  if (!memory) return memory.error();
  memory_ = std::move(memory).value();
  wrenches_ = 0;
  last_ = {};
  has_pose_ = false;
  return std::nullopt;
}

void SharedDevice::close() noexcept {
  if (!memory_) return;
  write({});
  memory_.reset();
}

bool SharedDevice::read(double t, Pose& pose) noexcept {
  constexpr double k_silent = 0.1;  // s
  if (!memory_) return false;
  if (const auto next = memory_->pose(); next && (!has_pose_ || next->count != last_.count))
    last_ = *next, counted_at_ = t, has_pose_ = true;
  if (!has_pose_ || t - counted_at_ > k_silent) return false;
  const glm::dvec3 position(last_.position[0], last_.position[1], last_.position[2]);
  // Another program may write anything.
  constexpr double k_farthest = 1e4;  // mm
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(position[a]) <= k_farthest)) return false;
  pose.position_world = position;
  pose.orientation =
      unit_of({last_.orientation[0], last_.orientation[1], last_.orientation[2], last_.orientation[3]});
  pose.buttons = static_cast<std::uint32_t>(last_.buttons);
  return true;
}

void SharedDevice::write(const Wrench& wrench) noexcept {
  if (!memory_) return;
  SharedWrench shared{++wrenches_, {}, {}};
  for (int a = 0; a < 3; ++a)
    shared.force[a] = wrench.force_world[a], shared.torque[a] = wrench.torque_world[a];
  memory_->set_wrench(shared);
}

}  // namespace trephine::haptics
