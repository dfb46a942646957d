// Thread that makes images for panes: the newest request of each, in turn.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "apps/imaging/panel.h"
#include "volume/error.h"

namespace trephine::imaging {

/// Only its destructor waits for it, for the image in progress.
class PaneWorker {
 public:
  using Make = std::function<volume::Result<Panel>()>;
  struct Made {
    volume::Result<Panel> panel;
    double milliseconds = 0;  ///< that it took
    std::uint64_t stamp = 0;  ///< of its request
  };
  struct Counters {
    std::uint64_t made = 0, superseded = 0;  ///< images; requests that a newer one replaced
  };

  explicit PaneWorker(std::size_t panes);
  ~PaneWorker();
  PaneWorker(const PaneWorker&) = delete;
  PaneWorker& operator=(const PaneWorker&) = delete;

  /// Drawing thread. Replaces a request of the same pane that was not begun. The thread begins with the
  /// first one. `stamp`: what it is given back with.
  void request(std::size_t pane, Make make, std::uint64_t stamp = 0);
  /// Cancels what this pane requested and got; an image in progress is finished all the same.
  void forget(std::size_t pane);
  /// A pane's newest image, once.
  std::optional<Made> take(std::size_t pane);
  /// Has it neither requests nor images, in progress or not taken yet?
  bool is_idle() const;
  Counters counters() const;

 private:
  void run();

  mutable std::mutex lock_;
  std::condition_variable changed_;
  std::vector<std::pair<Make, std::uint64_t>> requests_;
  std::vector<std::optional<Made>> made_;
  Counters counters_;
  std::size_t next_ = 0;  ///< whose turn it is
  bool is_working_ = false, is_stopping_ = false;
  std::thread thread_;
};

}  // namespace trephine::imaging
