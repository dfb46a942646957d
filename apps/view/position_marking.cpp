#include "apps/view/position_marking.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <utility>

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr double k_same = 0.05;  // mm; a second click at a position does not mark it again

std::string text_of(const char* format, double number) {
  char text[40];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

double length_of(const PositionMarking::Positions& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += glm::length(line[i] - line[i - 1]);
  return length;
}

}  // namespace

void PositionMarking::begin(Request request, std::function<void(const Positions&)> done) {
  request_ = std::move(request);
  positions_.clear();
  done_ = std::move(done);
}

void PositionMarking::add(const dvec3& at) {
  if (!is_active() || (!positions_.empty() && glm::length(at - positions_.back()) < k_same)) return;
  positions_.push_back(at);
  if (positions_.size() >= request_.most) finish();
}

void PositionMarking::remove_last() {
  if (positions_.empty()) return cancel();
  positions_.pop_back();
}

bool PositionMarking::finish() {
  if (!is_active() || positions_.size() < request_.least) return false;
  const auto done = std::exchange(done_, nullptr);
  done(std::exchange(positions_, {}));
  return true;
}

void PositionMarking::cancel() {
  done_ = nullptr;
  positions_.clear();
}

std::string PositionMarking::prompt() const {
  if (!is_active()) return "";
  const std::string number = std::to_string(positions_.size() + 1);
  std::string text = request_.title + ": click ";
  text += request_.most == 1 ? "a position" : "position " + number;
  if (request_.most == request_.least && request_.most > 1) text += " of " + std::to_string(request_.most);
  text += ". ";
  if (positions_.size() >= request_.least) text += "Enter finishes. ";
  text += positions_.empty() ? "Esc cancels." : "Backspace removes the last one, Esc cancels.";
  return text;
}

sim::Overlays PositionMarking::overlays(const std::optional<dvec3>& next) const {
  if (!is_active()) return {};
  sim::Overlay overlay;
  overlay.kind = sim::Overlay::Kind::warning;
  Positions line = positions_;
  if (next && line.size() < request_.most) line.push_back(*next);
  const bool is_outline = request_.quantity == Request::Quantity::outline && line.size() > 2;
  if (is_outline) line.push_back(line.front());
  for (std::size_t i = 1; i < line.size(); ++i) overlay.lines.push_back({line[i - 1], line[i]});
  for (const dvec3& at : positions_) overlay.handles.push_back({at, {}});
  if (request_.quantity == Request::Quantity::angle) {
    if (line.size() == 3) {
      const dvec3 a = line[0] - line[1], b = line[2] - line[1];
      const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
      overlay.labels.push_back({line[1], text_of("%.1f\u00b0", glm::degrees(angle))});
    }
  } else if (line.size() > 1) {
    const dvec3 end = is_outline ? line[line.size() - 2] : line.back();
    const char* format = is_outline                                         ? "outline %.1f mm"
                         : request_.quantity == Request::Quantity::straight ? "straight %.1f mm"
                                                                            : "%.1f mm";
    overlay.labels.push_back({end, text_of(format, length_of(line))});
  }
  return {overlay};
}

}  // namespace trephine::view
