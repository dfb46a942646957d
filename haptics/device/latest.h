// Latest: a value that one thread writes and others read, without locks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>

namespace trephine::haptics {

/// The latest value of one writer, for any number of readers (a sequence lock). Neither side waits: a reader
/// that meets the writer four times in a row returns nothing. T is copied word by word.
template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit Latest(const T& value = T()) noexcept { set(value); }

  /// Call on one thread.
  void set(const T& value) noexcept {
    std::array<std::uint64_t, k_words> words{};
    std::memcpy(words.data(), static_cast<const void*>(&value), sizeof(T));
    const std::uint64_t sequence = sequence_.load(std::memory_order_relaxed);
    // A reader that reads a new word also reads the odd number: each word publishes it.
    sequence_.store(sequence + 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < k_words; ++i) words_[i].store(words[i], std::memory_order_release);
    sequence_.store(sequence + 2, std::memory_order_release);
  }
  /// Returns nothing if the writer was active during each of the attempts.
  std::optional<T> get() const noexcept {
    constexpr int k_attempts = 4;
    for (int attempt = 0; attempt < k_attempts; ++attempt) {
      const std::uint64_t before = sequence_.load(std::memory_order_acquire);
      std::array<std::uint64_t, k_words> words;
      for (std::size_t i = 0; i < k_words; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      if (before % 2 != 0 || sequence_.load(std::memory_order_relaxed) != before) continue;
      std::optional<T> value(std::in_place);
      std::memcpy(static_cast<void*>(&*value), words.data(), sizeof(T));
      return value;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t k_words = (sizeof(T) + 7) / 8;
  std::atomic<std::uint64_t> sequence_{0};  ///< odd while the writer is active
  std::array<std::atomic<std::uint64_t>, k_words> words_{};
};

}  // namespace trephine::haptics
