// Buffer: fixed-size array with uninitialized elements, so that large volumes are written only once.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

namespace trephine {

/// Allocates `bytes`; from 4 MiB up in huge pages where the system has them (one page fault per 2 MiB
/// instead of per 4 KiB). Release with std::free. Throws std::bad_alloc.
void* allocate_pages(std::size_t bytes);

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  Buffer() = default;
  explicit Buffer(std::size_t count)
      : data_(static_cast<T*>(allocate_pages(count * sizeof(T)))), count_(count) {}
  /// Returns a read-only view of memory of another owner, which must keep it unchanged while the view exists.
  static Buffer borrow(const T* data, std::size_t count) {
    Buffer buffer;
    // Callers expose borrowed memory only through const volumes.
    buffer.data_ = {const_cast<T*>(data), Free{false}};
    buffer.count_ = count;
    return buffer;
  }
  Buffer(Buffer&& other) noexcept : data_(std::move(other.data_)), count_(std::exchange(other.count_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    data_ = std::move(other.data_);
    count_ = std::exchange(other.count_, 0);
    return *this;
  }

  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  std::size_t size() const { return count_; }
  bool is_empty() const { return count_ == 0; }
  std::size_t bytes() const { return count_ * sizeof(T); }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  const T& operator[](std::size_t i) const { return data_.get()[i]; }
  std::span<T> span() { return {data_.get(), count_}; }
  std::span<const T> span() const { return {data_.get(), count_}; }

 private:
  struct Free {
    bool is_owned = true;
    void operator()(T* p) const noexcept {
      if (is_owned) std::free(p);
    }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t count_ = 0;
};

}  // namespace trephine
