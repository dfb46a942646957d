// Request of a ray-cast image: transfer functions and cameras.
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/direct_image.h"

namespace trephine::volume {

using glm::dvec3;

namespace {

std::string number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", v);
  return text;
}

}  // namespace

Status check(const Ramp& ramp) {
  for (std::size_t i = 0; i < ramp.size(); ++i) {
    const RampPoint& p = ramp[i];
    const std::string where = "point " + std::to_string(i + 1) + " of the ramp";
    if (!std::isfinite(p.value) || (i > 0 && !(p.value > ramp[i - 1].value)))
      return Error{"the values of a ramp must rise", where, number(p.value), "a number above the one before",
                   ""};
    for (const double c : {p.colour.x, p.colour.y, p.colour.z, p.opacity})
      if (!(c >= 0 && c <= 1))
        return Error{"a colour or an opacity is out of range", where, number(c), "0 to 1", ""};
  }
  if (ramp.empty()) return Error{"the ramp shows nothing", "ramp", "no points", "one or more", ""};
  return std::nullopt;
}

std::optional<ValueWindow> window_of_opacity(const Ramp& ramp, double least) {
  // Ends of runs are points of the ramp, or lie between two.
  struct Run {
    double low, high;
    bool goes_on;
  };
  std::optional<Run> best, now;
  const auto close = [&](double high, bool goes_on) {
    if (!now) return;
    now->high = high, now->goes_on = goes_on;
    if (!best || goes_on || (!best->goes_on && now->high - now->low > best->high - best->low)) best = now;
    now.reset();
  };
  for (std::size_t i = 0; i < ramp.size(); ++i) {
    const RampPoint& p = ramp[i];
    const bool is_seen = p.opacity >= least && p.opacity > 0;
    if (i > 0 && is_seen != now.has_value()) {
      const RampPoint& q = ramp[i - 1];
      const double at = q.value + (least - q.opacity) / (p.opacity - q.opacity) * (p.value - q.value);
      if (is_seen)
        now = Run{at, at, false};
      else
        close(at, false);
    } else if (is_seen && !now) {
      now = Run{p.value, p.value, false};
    }
  }
  if (now) close(ramp.back().value, true);
  if (!best) return std::nullopt;
  return ValueWindow{best->low, best->goes_on ? std::nullopt : std::optional<double>(best->high)};
}

Eye::Ray Eye::ray(double i, double j) const noexcept {
  const double x = pixel() * (i - 0.5 * (columns - 1)), y = pixel() * (0.5 * (rows - 1) - j);
  const dvec3 beside = x * right() + y * up;
  if (distance <= 0) return {at + beside, forward};
  return {at, glm::normalize(distance * forward + beside)};
}

Status check(const Eye& eye) {
  for (const dvec3* v : {&eye.at, &eye.forward, &eye.up})
    if (!(glm::dot(*v, *v) < 1e12))
      return Error{"the eye is nowhere", "eye", "no number", "finite numbers, mm", ""};
  if (std::abs(glm::length(eye.forward) - 1) > 1e-6 || std::abs(glm::length(eye.up) - 1) > 1e-6 ||
      std::abs(glm::dot(eye.forward, eye.up)) > 1e-6)
    return Error{"the eye's directions are not of length 1 at right angles", "eye", "", "unit vectors", ""};
  if (!(eye.height > 1e-3 && eye.height < 1e5) || !(eye.distance >= 0 && eye.distance < 1e5) ||
      eye.columns < 1 || eye.rows < 1 || eye.columns > 8192 || eye.rows > 8192)
    return Error{
        "the picture's size is out of range", "eye",
        number(eye.height) + " mm, " + std::to_string(eye.columns) + " x " + std::to_string(eye.rows),
        "0.001 mm to 100 m, 1 to 8192 pixels", ""};
  return std::nullopt;
}

}  // namespace trephine::volume
