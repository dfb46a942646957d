// Channel: wait-free snapshot of one writer's newest value for several readers.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace trephine {

/// For one writer and up to k_readers readers. A value stays alive until every reader that could have adopted
/// it has adopted a later value, or was closed.
template <class T>
class Channel {
 public:
  static constexpr int k_readers = 8;

  explicit Channel(std::shared_ptr<const T> first)
      : newest_owner_(std::move(first)), newest_(newest_owner_.get()) {}
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;

  /// Writer only. Frees the values that no reader can access any more.
  void publish(std::shared_ptr<const T> value) {
    newest_.store(value.get());
    // A reader whose epoch is this or later has loaded `newest_` after the store above.
    const std::uint64_t epoch = epoch_.fetch_add(1) + 1;
    retired_.emplace_back(epoch, std::exchange(newest_owner_, std::move(value)));
    reclaim();
  }
  /// Writer only. Number of values not yet freed, the newest included.
  int alive_count() const noexcept { return static_cast<int>(retired_.size()) + 1; }

  /// Opens a reader. Returns its number for adopt() and close_reader(); -1 if k_readers readers are open. Not
  /// for the servo thread.
  int open_reader() noexcept {
    for (int i = 0; i < k_readers; ++i)
      if (!readers_[static_cast<std::size_t>(i)].is_open.exchange(true)) return i;
    return -1;
  }
  void close_reader(int reader) noexcept {
    readers_[static_cast<std::size_t>(reader)].epoch.store(0);
    readers_[static_cast<std::size_t>(reader)].is_open.store(false);
  }
  /// Returns the newest value, valid until this reader adopts again or closes. Wait-free: two loads, one
  /// store.
  const T* adopt(int reader) noexcept {
    readers_[static_cast<std::size_t>(reader)].epoch.store(epoch_.load());
    return newest_.load();
  }

 private:
  struct alignas(64) Reader {
    std::atomic<std::uint64_t> epoch{0};  ///< 0: no value adopted
    std::atomic<bool> is_open{false};
  };
  void reclaim() {
    std::uint64_t oldest = epoch_.load();
    for (const Reader& reader : readers_) {
      const std::uint64_t epoch = reader.epoch.load();
      if (epoch != 0) oldest = std::min(oldest, epoch);
    }
    std::erase_if(retired_, [oldest](const auto& entry) { return entry.first <= oldest; });
  }

  std::shared_ptr<const T> newest_owner_;
  std::atomic<const T*> newest_;
  std::atomic<std::uint64_t> epoch_{1};
  std::array<Reader, k_readers> readers_;
  std::vector<std::pair<std::uint64_t, std::shared_ptr<const T>>> retired_;
};

}  // namespace trephine
