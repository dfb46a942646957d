// ByteSource: random access to the bytes of a file or of unpacked data in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace trephine::data_tools {

/// Several threads may read one source.
class ByteSource {
 public:
  /// Opens a file; null if it cannot be read or is not a plain file.
  static std::unique_ptr<ByteSource> open(const std::string& path);
  /// Returns a source of bytes in memory.
  static std::unique_ptr<ByteSource> of(std::shared_ptr<const std::string> bytes);
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  std::uint64_t size() const noexcept { return size_; }
  bool is_file() const noexcept { return file_ >= 0; }
  /// Reads `count` bytes at `offset`; false if there are fewer bytes or they cannot be read.
  bool read(std::uint64_t offset, void* destination, std::size_t count) const;

 private:
  ByteSource() = default;
  int file_ = -1;
  std::shared_ptr<const std::string> bytes_;
  std::uint64_t size_ = 0;
};

}  // namespace trephine::data_tools
