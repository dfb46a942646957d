// A fixed array that is not cleared when made, so that big volumes are touched once.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace trephine::volume {

template <class T>
class Buffer {
 public:
  Buffer() = default;
  explicit Buffer(std::size_t count) : data_(std::make_unique_for_overwrite<T[]>(count)), count_(count) {}

  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  std::size_t size() const { return count_; }
  bool is_empty() const { return count_ == 0; }
  std::size_t bytes() const { return count_ * sizeof(T); }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::span<T> span() { return {data_.get(), count_}; }
  std::span<const T> span() const { return {data_.get(), count_}; }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t count_ = 0;
};

}  // namespace trephine::volume
