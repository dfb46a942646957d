// Inputs of DirectImage: checks and helpers for transfer functions and cameras.
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "volume/imaging/direct_image.h"

namespace trephine::volume {

using glm::dvec3;

namespace {

std::string number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", v);
  return text;
}

}  // namespace

Status check(const TransferFunction& function) {
  for (std::size_t i = 0; i < function.size(); ++i) {
    const TransferPoint& p = function[i];
    const std::string where = "point " + std::to_string(i + 1) + " of the transfer function";
    if (!std::isfinite(p.value) || (i > 0 && !(p.value > function[i - 1].value)))
      return Error{.what = "the values of the transfer function do not increase",
                   .where = where,
                   .found = number(p.value),
                   .expected = "a finite value above the previous one",
                   .remedy = "sort the points by value, without equal values"};
    for (const double c : {p.colour.x, p.colour.y, p.colour.z, p.opacity})
      if (!(c >= 0 && c <= 1))
        return Error{.what = "a colour or an opacity is out of range",
                     .where = where,
                     .found = number(c),
                     .expected = "0 to 1"};
  }
  if (function.empty())
    return Error{.what = "the transfer function is transparent everywhere",
                 .where = "transfer function",
                 .found = "no points",
                 .expected = "at least one point",
                 .remedy = "add a point with an opacity above 0"};
  return std::nullopt;
}

std::optional<ValueWindow> window_of_opacity(const TransferFunction& function, double min_opacity) {
  // Runs of visible values end at points of the function or between two of them.
  struct Run {
    double low, high;
    bool is_unbounded;
  };
  std::optional<Run> best, current;
  const auto close = [&](double high, bool is_unbounded) {
    if (!current) return;
    current->high = high, current->is_unbounded = is_unbounded;
    if (!best || is_unbounded ||
        (!best->is_unbounded && current->high - current->low > best->high - best->low))
      best = current;
    current.reset();
  };
  for (std::size_t i = 0; i < function.size(); ++i) {
    const TransferPoint& p = function[i];
    const bool is_visible = p.opacity >= min_opacity && p.opacity > 0;
    if (i > 0 && is_visible != current.has_value()) {
      const TransferPoint& q = function[i - 1];
      const double crossing =
          q.value + (min_opacity - q.opacity) / (p.opacity - q.opacity) * (p.value - q.value);
      if (is_visible)
        current = Run{crossing, crossing, false};
      else
        close(crossing, false);
    } else if (is_visible && !current) {
      current = Run{p.value, p.value, false};
    }
  }
  if (current) close(function.back().value, true);
  if (!best) return std::nullopt;
  return ValueWindow{best->low, best->is_unbounded ? std::nullopt : std::optional<double>(best->high)};
}

Camera::Ray Camera::ray(double i, double j) const noexcept {
  const double x = pixel() * (i - 0.5 * (columns - 1)), y = pixel() * (0.5 * (rows - 1) - j);
  const dvec3 offset = x * right() + y * up;
  if (distance <= 0) return {at + offset, forward};
  return {at, glm::normalize(distance * forward + offset)};
}

Status check(const Camera& camera) {
  for (const dvec3* v : {&camera.at, &camera.forward, &camera.up})
    if (!(glm::dot(*v, *v) < 1e12))
      return Error{.what = "the position or a direction of the camera is out of range",
                   .where = "camera",
                   .found = "a value that is not finite or above 1000 m",
                   .expected = "finite coordinates below 1000 m"};
  if (std::abs(glm::length(camera.forward) - 1) > 1e-6 || std::abs(glm::length(camera.up) - 1) > 1e-6 ||
      std::abs(glm::dot(camera.forward, camera.up)) > 1e-6)
    return Error{.what = "the directions of the camera are not orthogonal unit vectors",
                 .where = "camera",
                 .expected = "orthogonal unit vectors"};
  if (!(camera.height > 1e-3 && camera.height < 1e5) || !(camera.distance >= 0 && camera.distance < 1e5) ||
      camera.columns < 1 || camera.rows < 1 || camera.columns > 8192 || camera.rows > 8192)
    return Error{.what = "the image size or the distance of the camera is out of range",
                 .where = "camera",
                 .found = "height " + number(camera.height) + " mm, distance " + number(camera.distance) +
                          " mm, " + std::to_string(camera.columns) + " x " + std::to_string(camera.rows) +
                          " pixels",
                 .expected = "a height of 0.001 mm to 100 m, a distance of 0 to 100 m, 1 to 8192 pixels"};
  return std::nullopt;
}

}  // namespace trephine::volume
