#include "haptics/device/pose_path.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>
#include <string_view>

#include "volume/base/text.h"

namespace trephine::haptics {

glm::dquat unit_of(const glm::dquat& q) noexcept {
  const double length = glm::length(q);
  return length > 1e-3 && std::isfinite(length) ? q / length : glm::dquat(1, 0, 0, 0);
}

glm::dvec3 turn_between(const glm::dquat& from, const glm::dquat& to) noexcept {
  const glm::dquat turn = to * glm::conjugate(from);
  return (turn.w < 0 ? -2.0 : 2.0) * glm::dvec3(turn.x, turn.y, turn.z);
}

Pose rounded_to_grid(Pose pose) noexcept {
  const auto snap = [](double& v, double grid) { v = std::nearbyint(v / grid) * grid + 0.0; };
  for (int a = 0; a < 3; ++a) snap(pose.position_world[a], k_position_grid);
  for (double* part : {&pose.orientation.w, &pose.orientation.x, &pose.orientation.y, &pose.orientation.z})
    snap(*part, k_rotation_grid);
  return pose;
}

namespace {

constexpr std::array<std::string_view, 14> k_columns{
    "t", "x", "y", "z", "qx", "qy", "qz", "qw", "button", "buttons", "axis1", "axis2", "axis3", "axis4"};
constexpr std::size_t k_button = 8, k_buttons = 9, k_axis = 10;
constexpr const char* k_expected = "t,x,y,z[,qx,qy,qz,qw][,button or buttons][,axis1 to axis4]";

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    std::string_view cell = line.substr(0, comma);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t' || cell.back() == '\r'))
      cell.remove_suffix(1);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// Returns the column of the file for each of k_columns; -1 for missing ones.
Result<std::array<int, k_columns.size()>> read_header(std::string_view line, const std::string& where) {
  std::array<int, k_columns.size()> column;
  column.fill(-1);
  const std::vector<std::string_view> names = split(line);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto it = std::find(k_columns.begin(), k_columns.end(), names[i]);
    if (it == k_columns.end() || column[static_cast<std::size_t>(it - k_columns.begin())] >= 0)
      return Error{.what = "the path has an unknown or repeated column",
                   .where = where + ", line 1",
                   .found = std::string(names[i].substr(0, 40)),
                   .expected = k_expected,
                   .remedy = "name the columns in the first line"};
    column[static_cast<std::size_t>(it - k_columns.begin())] = static_cast<int>(i);
  }
  std::string missing;
  for (std::size_t i = 0; i < 4; ++i)
    if (column[i] < 0) missing += (missing.empty() ? "" : ", ") + std::string(k_columns[i]);
  const auto quaternions =
      std::count_if(column.begin() + 4, column.begin() + 8, [](int c) { return c >= 0; });
  if (!missing.empty() || (quaternions != 0 && quaternions != 4))
    return Error{.what = "the path lacks columns",
                 .where = where + ", line 1",
                 .found = missing.empty() ? "part of a quaternion" : "no column " + missing,
                 .expected = k_expected,
                 .remedy = "name the columns in the first line, for example t,x,y,z"};
  if (column[k_button] >= 0 && column[k_buttons] >= 0)
    return Error{.what = "the path has two columns of buttons",
                 .where = where + ", line 1",
                 .found = "button and buttons",
                 .expected = "one of them"};
  return column;
}

}  // namespace

Result<PosePath> PosePath::from_samples(std::vector<Sample> samples, const std::string& where) {
  if (samples.empty())
    return Error{
        .what = "the path has no samples", .where = where, .found = "0 rows", .expected = "at least one"};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    const std::string at = where + ", sample " + std::to_string(i + 1);
    for (const double v : {s.t, s.pose.position_world.x, s.pose.position_world.y, s.pose.position_world.z})
      if (!std::isfinite(v) || std::abs(v) > 1e6)
        return Error{.what = "a time or position of the path is out of range",
                     .where = at,
                     .found = std::to_string(v),
                     .expected = "-1e6 to 1e6 (s, mm)",
                     .remedy = "convert times to seconds and positions to mm"};
    for (const float axis : s.pose.axes)
      if (!(std::abs(axis) <= Pose::k_farthest_axis))
        return Error{.what = "the path has an axis out of range",
                     .where = at,
                     .found = std::to_string(axis),
                     .expected = "-1e6 to 1e6"};
    const glm::dquat& q = s.pose.orientation;
    const double length = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    constexpr double k_rounding =
        0.02;  // deviation of the squared length: rounding of numbers with two digits
    if (!(std::abs(length - 1) < k_rounding))
      return Error{.what = "the path has an invalid orientation",
                   .where = at,
                   .found = "a quaternion of length " + rounded_text(std::sqrt(length)),
                   .expected = "a unit quaternion",
                   .remedy = length > 0 ? "divide its four numbers by their length" : ""};
    if (i > 0 && !(s.t > samples[i - 1].t))
      return Error{.what = "the times of the path are not increasing",
                   .where = at,
                   .found = rounded_text(s.t) + " s after " + rounded_text(samples[i - 1].t) + " s",
                   .expected = "strictly rising times",
                   .remedy = "sort the rows and drop repeated times"};
  }
  PosePath path;
  path.samples_ = std::move(samples);
  return path;
}

Result<PosePath> PosePath::read_csv(std::istream& in, const std::string& where) {
  std::string line;
  if (!std::getline(in, line))
    return Error{
        .what = "the path is empty", .where = where, .found = "no first line", .expected = k_expected};
  if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
  Result<std::array<int, k_columns.size()>> header = read_header(line, where);
  if (!header) return header.error();
  const std::array<int, k_columns.size()>& column = header.value();
  const std::size_t width = split(line).size();

  std::vector<Sample> samples;
  for (int number = 2; std::getline(in, line); ++number) {
    if (line.empty() || line == "\r") continue;
    const std::string at = where + ", line " + std::to_string(number);
    const std::vector<std::string_view> cells = split(line);
    if (cells.size() != width)
      return Error{.what = "a row of the path has a wrong number of columns",
                   .where = at,
                   .found = std::to_string(cells.size()),
                   .expected = std::to_string(width)};
    std::array<double, k_columns.size()> value{0, 0, 0, 0, 0, 0, 0, 1, 1};
    for (std::size_t c = 0; c < value.size(); ++c) {
      if (column[c] < 0) continue;
      const std::string_view cell = cells[static_cast<std::size_t>(column[c])];
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value[c]);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value[c]))
        return Error{.what = "a cell of the path is not a number",
                     .where = at + ", column " + std::string(k_columns[c]),
                     .found = std::string(cell.substr(0, 40)),
                     .expected = "a finite number, such as 1.5"};
    }
    if (value[k_button] != 0 && value[k_button] != 1)
      return Error{.what = "a button is neither 0 nor 1",
                   .where = at,
                   .found = std::to_string(value[k_button]),
                   .expected = "0 or 1"};
    const double bits = column[k_buttons] < 0 ? value[k_button] : value[k_buttons];
    if (!(bits >= 0 && bits <= 0xffffffffu && bits == std::floor(bits)))
      return Error{.what = "invalid buttons",
                   .where = at,
                   .found = std::to_string(bits),
                   .expected = "a whole number from 0 to 4294967295"};
    Pose pose{{value[1], value[2], value[3]},
              glm::dquat(value[7], value[4], value[5], value[6]),
              static_cast<std::uint32_t>(bits)};
    for (std::size_t a = 0; a < pose.axes.size(); ++a) {
      if (std::abs(value[k_axis + a]) > static_cast<double>(Pose::k_farthest_axis))
        return Error{.what = "an axis is out of range",
                     .where = at + ", column " + std::string(k_columns[k_axis + a]),
                     .found = std::to_string(value[k_axis + a]),
                     .expected = "-1e6 to 1e6"};
      pose.axes[a] = static_cast<float>(value[k_axis + a]);
    }
    samples.push_back({value[0], pose});
    if (samples.size() > 1 && !(samples.back().t > samples[samples.size() - 2].t))
      return Error{.what = "the times of the path are not increasing",
                   .where = at,
                   .found = std::string(cells[static_cast<std::size_t>(column[0])]) + " s",
                   .expected = "strictly rising times",
                   .remedy = "sort the rows and drop repeated times"};
  }
  return from_samples(std::move(samples), where);
}

Pose PosePath::at(double t) const noexcept {
  if (!(t > samples_.front().t)) return samples_.front().pose;  // also for a time that is not a number
  if (t >= samples_.back().t) return samples_.back().pose;
  const auto after = std::upper_bound(samples_.begin(), samples_.end(), t,
                                      [](double time, const Sample& s) { return time < s.t; });
  const auto before = after - 1;
  const double f = (t - before->t) / (after->t - before->t);
  Pose pose = before->pose;
  pose.position_world += f * (after->pose.position_world - before->pose.position_world);
  // Normalized linear interpolation along the shorter arc: + - * / and sqrt only.
  glm::dquat to = after->pose.orientation;
  if (glm::dot(pose.orientation, to) < 0) to = -to;
  pose.orientation = glm::normalize(pose.orientation * (1 - f) + to * f);
  for (std::size_t a = 0; a < pose.axes.size(); ++a)
    pose.axes[a] += static_cast<float>(f) * (after->pose.axes[a] - pose.axes[a]);
  return pose;
}

void PosePath::write_csv(std::ostream& out) const {
  const auto put = [&out](double v, char end) {
    char text[40];
    const auto [last, error] = std::to_chars(text, text + sizeof text, v);
    out.write(text, last - text);
    out.put(end);
  };
  // Unused values get no columns.
  bool has_more_buttons = false, has_axes = false;
  for (const Sample& s : samples_) {
    has_more_buttons = has_more_buttons || s.pose.buttons > 1;
    has_axes = has_axes || s.pose.axes != std::array<float, 4>{};
  }
  out << "t,x,y,z,qx,qy,qz,qw," << (has_more_buttons ? "buttons" : "button")
      << (has_axes ? ",axis1,axis2,axis3,axis4\n" : "\n");
  for (const Sample& s : samples_) {
    const glm::dquat& q = s.pose.orientation;
    for (const double v :
         {s.t, s.pose.position_world.x, s.pose.position_world.y, s.pose.position_world.z, q.x, q.y, q.z, q.w})
      put(v, ',');
    put(s.pose.buttons, has_axes ? ',' : '\n');
    for (std::size_t a = 0; has_axes && a < s.pose.axes.size(); ++a)
      put(static_cast<double>(s.pose.axes[a]), a + 1 < s.pose.axes.size() ? ',' : '\n');
  }
}

std::vector<double> servo_times(const PosePath& path, double rate_hz) {
  const double start = path.start_time(), end = path.end_time();
  const auto steps = static_cast<std::size_t>(std::floor((end - start) * rate_hz + 1e-9));
  std::vector<double> times;
  times.reserve(steps + 2);
  for (std::size_t i = 0; i <= steps; ++i)
    times.push_back(std::min(end, start + static_cast<double>(i) / rate_hz));
  if (times.back() < end - 1e-9 / rate_hz) times.push_back(end);
  times.back() = std::min(times.back(), end);
  return times;
}

}  // namespace trephine::haptics
