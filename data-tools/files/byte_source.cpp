#include "data-tools/files/byte_source.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace trephine::data_tools {

std::unique_ptr<ByteSource> ByteSource::open(const std::string& path) {
  std::unique_ptr<ByteSource> source(new ByteSource);
  source->file_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // opening a pipe must not block
  struct stat info {};
  if (source->file_ < 0 || ::fstat(source->file_, &info) != 0 || !S_ISREG(info.st_mode)) return nullptr;
  source->size_ = static_cast<std::uint64_t>(info.st_size);
  return source;
}

std::unique_ptr<ByteSource> ByteSource::of(std::shared_ptr<const std::string> bytes) {
  std::unique_ptr<ByteSource> source(new ByteSource);
  source->size_ = bytes->size();
  source->bytes_ = std::move(bytes);
  return source;
}

ByteSource::~ByteSource() {
  if (file_ >= 0) ::close(file_);
}

bool ByteSource::read(std::uint64_t offset, void* destination, std::size_t count) const {
  if (offset > size_ || count > size_ - offset) return false;
  if (bytes_) {
    std::memcpy(destination, bytes_->data() + offset, count);
    return true;
  }
  char* next = static_cast<char*>(destination);
  while (count > 0) {
    const ssize_t count_read = ::pread(file_, next, count, static_cast<off_t>(offset));
    if (count_read < 0 && errno == EINTR) continue;
    if (count_read <= 0) return false;
    next += count_read, offset += static_cast<std::uint64_t>(count_read),
        count -= static_cast<std::size_t>(count_read);
  }
  return true;
}

}  // namespace trephine::data_tools
