// Ring: queue of fixed size from one thread to another, wait-free on both ends.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

namespace trephine::haptics {

/// One producer, one consumer. Capacity is rounded up to a power of two; T is copied.
template <class T>
class Ring {
 public:
  Ring(Ring&& other) noexcept : slots_(std::move(other.slots_)), mask_(other.mask_) {}  ///< before first use
  explicit Ring(std::size_t capacity) {
    std::size_t size = 1;
    while (size < capacity) size *= 2;
    slots_ = std::make_unique<T[]>(size);
    mask_ = size - 1;
  }
  /// Producer: adds a value. Returns false, and writes nothing, when the ring is full.
  bool push(const T& value) noexcept {
    const std::size_t at = written_.load(std::memory_order_relaxed);
    if (at - read_.load(std::memory_order_acquire) > mask_) return false;
    slots_[at & mask_] = value;
    written_.store(at + 1, std::memory_order_release);
    return true;
  }
  /// Producer: size() is the number of values that the consumer has not read yet. room() is the number of
  /// further values that push() accepts.
  std::size_t size() const noexcept {
    return written_.load(std::memory_order_relaxed) - read_.load(std::memory_order_acquire);
  }
  std::size_t room() const noexcept { return capacity() - size(); }
  std::size_t capacity() const noexcept { return mask_ + 1; }
  /// Consumer: reads the next value. Returns false if there is no new value.
  bool pop(T& value) noexcept {
    const std::size_t at = read_.load(std::memory_order_relaxed);
    if (at == written_.load(std::memory_order_acquire)) return false;
    value = slots_[at & mask_];
    read_.store(at + 1, std::memory_order_release);
    return true;
  }

 private:
  std::unique_ptr<T[]> slots_;
  std::size_t mask_ = 0;
  alignas(64) std::atomic<std::size_t> written_{0};
  alignas(64) std::atomic<std::size_t> read_{0};
};

}  // namespace trephine::haptics
