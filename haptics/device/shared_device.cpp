#include "haptics/device/shared_device.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <new>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace trephine::haptics {

namespace {

constexpr std::size_t k_size = 4096;

std::string file_of(int index) {
  return "/dev/shm/trephine-virtual-" + std::to_string(::getuid()) + "-" + std::to_string(index);
}

Error failed(const char* what, int index, const char* remedy) {
  return Error{.what = what,
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
    return failed("the shared memory of a virtual device cannot be created", index,
                  "check that this user may write to /dev/shm");
  if (::flock(memory->descriptor_, LOCK_EX | LOCK_NB) != 0)
    return failed("a virtual device with this index is already open", index,
                  "close its window, or choose another index");
  if (::ftruncate(memory->descriptor_, k_size) != 0)
    return failed("the shared memory of a virtual device cannot be created", index, "free space in /dev/shm");
  void* const address = ::mmap(nullptr, k_size, PROT_READ | PROT_WRITE, MAP_SHARED, memory->descriptor_, 0);
  if (address == MAP_FAILED)
    return failed("the shared memory of a virtual device cannot be created", index, "close other programs");
  memory->file_ = file;
  memory->block_ = new (address) Block{};
  memory->block_->layout = k_layout;
  std::memcpy(memory->block_->magic, k_magic, sizeof k_magic);
  return memory;
}

Result<std::shared_ptr<SharedDeviceMemory>> SharedDeviceMemory::open(int index) {
  std::shared_ptr<SharedDeviceMemory> memory(new SharedDeviceMemory);
  memory->descriptor_ = open_own(file_of(index), 0);
  struct stat status {};
  if (memory->descriptor_ < 0 || !has_host(memory->descriptor_) ||
      ::fstat(memory->descriptor_, &status) != 0 || status.st_size < static_cast<off_t>(k_size))
    return failed("the virtual device is not open", index, "start it: trephine virtual-device");
  void* const address = ::mmap(nullptr, k_size, PROT_READ | PROT_WRITE, MAP_SHARED, memory->descriptor_, 0);
  if (address == MAP_FAILED)
    return failed("the memory of the virtual device cannot be read", index, "close other programs");
  memory->block_ = static_cast<Block*>(address);
  if (std::memcmp(memory->block_->magic, k_magic, sizeof k_magic) != 0 || memory->block_->layout != k_layout)
    return failed("the virtual device is of another version", index, "start it with this version");
  return memory;
}

bool SharedDeviceMemory::exists(int index) {
  const int descriptor = open_own(file_of(index), 0);
  if (descriptor < 0) return false;
  const bool result = has_host(descriptor);
  ::close(descriptor);
  return result;
}

SharedDeviceMemory::~SharedDeviceMemory() {
  if (block_) ::munmap(block_, k_size);
  if (!file_.empty()) ::unlink(file_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
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
  if (const auto next = memory_->pose().get(); next && (!has_pose_ || next->count != last_.count))
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
  memory_->wrench().set(shared);
}

}  // namespace trephine::haptics
