#include "apps/imaging/pane_worker.h"

#include <utility>

#include "apps/workbench/clock.h"

namespace trephine::imaging {

PaneWorker::PaneWorker(std::size_t panes) : requests_(panes), finished_(panes) {}

PaneWorker::~PaneWorker() {
  {
    const std::lock_guard guard(lock_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PaneWorker::request(std::size_t pane, Make make, std::uint64_t stamp) {
  {
    const std::lock_guard guard(lock_);
    counters_.superseded += requests_[pane].first != nullptr;
    requests_[pane] = {std::move(make), stamp};
    if (!thread_.joinable()) thread_ = std::thread(&PaneWorker::run, this);
  }
  changed_.notify_all();
}

void PaneWorker::forget(std::size_t pane) {
  const std::lock_guard guard(lock_);
  requests_[pane] = {};
  finished_[pane].reset();
}

std::optional<PaneWorker::FinishedImage> PaneWorker::take(std::size_t pane) {
  const std::lock_guard guard(lock_);
  return std::exchange(finished_[pane], std::nullopt);
}

bool PaneWorker::is_idle() const {
  const std::lock_guard guard(lock_);
  for (const auto& [request, stamp] : requests_)
    if (request) return false;
  for (const std::optional<FinishedImage>& image : finished_)
    if (image) return false;
  return !working_;
}

bool PaneWorker::is_busy(std::size_t pane) const {
  const std::lock_guard guard(lock_);
  return requests_[pane].first || finished_[pane] || working_ == pane;
}

PaneWorker::Counters PaneWorker::counters() const {
  const std::lock_guard guard(lock_);
  return counters_;
}

void PaneWorker::run() {
  std::unique_lock guard(lock_);
  for (;;) {
    std::size_t pane = requests_.size();
    for (std::size_t i = 0; i < requests_.size() && pane == requests_.size(); ++i)
      if (requests_[(next_ + i) % requests_.size()].first) pane = (next_ + i) % requests_.size();
    if (is_stopping_) return;
    if (pane == requests_.size()) {
      changed_.wait(guard);
      continue;
    }
    next_ = pane + 1;
    const auto [make, stamp] = std::exchange(requests_[pane], {});
    working_ = pane;
    guard.unlock();
    const auto start = workbench::Clock::now();
    Result<Panel> panel = make();
    const double ms = 1e3 * workbench::seconds_since(start);
    guard.lock();
    working_.reset();
    ++counters_.finished;
    finished_[pane] = FinishedImage{std::move(panel), ms, stamp};
  }
}

}  // namespace trephine::imaging
