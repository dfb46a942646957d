// PaneWorker: a thread that renders images for panes. It takes the panes in turn, and renders the newest
// request of each.
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
#include "volume/base/error.h"

namespace trephine::imaging {

/// Runs requests on its own thread. Only the destructor blocks, until the image in progress is finished.
class PaneWorker {
 public:
  using Make = std::function<Result<Panel>()>;
  struct FinishedImage {
    Result<Panel> panel;
    double milliseconds = 0;  ///< duration of rendering
    std::uint64_t stamp = 0;  ///< stamp of the request
  };
  struct Counters {
    std::uint64_t finished = 0, superseded = 0;  ///< finished images; requests replaced by newer ones
  };

  explicit PaneWorker(std::size_t panes);
  ~PaneWorker();
  PaneWorker(const PaneWorker&) = delete;
  PaneWorker& operator=(const PaneWorker&) = delete;

  /// Requests an image, from the drawing thread. Replaces a pending request of the same pane. The first
  /// request starts the worker's thread. `stamp`: returned with the image.
  void request(std::size_t pane, Make make, std::uint64_t stamp = 0);
  /// Discards the pending request and the finished image of a pane. An image in progress is still finished,
  /// and take() then returns it.
  void forget(std::size_t pane);
  /// Returns the newest finished image of a pane and removes it; nullopt if there is no finished image.
  std::optional<FinishedImage> take(std::size_t pane);
  /// True if there are no pending requests, no image in progress and no image that was not yet fetched.
  bool is_idle() const;
  /// True if a pane has a pending request, an image in progress, or an image that was not yet fetched.
  bool is_busy(std::size_t pane) const;
  Counters counters() const;

 private:
  void run();

  mutable std::mutex lock_;
  std::condition_variable changed_;
  std::vector<std::pair<Make, std::uint64_t>> requests_;
  std::vector<std::optional<FinishedImage>> finished_;
  Counters counters_;
  std::size_t next_ = 0;                ///< next pane in turn
  std::optional<std::size_t> working_;  ///< pane of the image in progress
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace trephine::imaging
