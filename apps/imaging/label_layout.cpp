#include "apps/imaging/label_layout.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <numeric>
#include <utility>

namespace trephine::imaging {

using glm::dvec2;

namespace {

bool contains(const PictureBox& box, const dvec2& p) noexcept {
  return p.x >= box.low.x && p.x <= box.high.x && p.y >= box.low.y && p.y <= box.high.y;
}

double cross(const dvec2& a, const dvec2& b) noexcept { return a.x * b.y - a.y * b.x; }

/// Returns true if two segments cross; segments that share an end do not.
bool cross_each_other(const Segment& a, const Segment& b) noexcept {
  const dvec2 u = a[1] - a[0], v = b[1] - b[0];
  return cross(u, b[0] - a[0]) * cross(u, b[1] - a[0]) < 0 &&
         cross(v, a[0] - b[0]) * cross(v, a[1] - b[0]) < 0;
}

/// Maps positions of a panel, which is fitted into an area, to pixels.
struct Fit {
  dvec2 centre;
  double pixels_per_mm, scale;  ///< `scale`: pixels of the area per pixel of the image
  PictureBox picture;

  Fit(const Panel& panel, double width, double height)
      : centre(0.5 * dvec2(width, height)),
        scale(std::min(width / std::max(panel.columns, 1), height / std::max(panel.rows, 1))) {
    pixels_per_mm = scale / std::max(panel.mm_per_pixel, 1e-9);
    const dvec2 half = 0.5 * scale * dvec2(panel.columns, panel.rows);
    picture = {centre - half, centre + half};
  }
  dvec2 operator()(const dvec2& mm) const { return centre + pixels_per_mm * mm; }
};

/// Returns the markers of a plan: a closed line smaller than `small` (pixels) as its box, other lines as
/// segments.
LabelLayout::Obstacles markers_of(const Panel& panel, const Fit& fit, double small) {
  LabelLayout::Obstacles markers;
  for (const Panel::Line& line : panel.lines) {
    if (!line.is_marker || line.points.empty()) continue;
    PictureBox box{dvec2(1e300), dvec2(-1e300)};
    for (const dvec2& p : line.points) box = {glm::min(box.low, fit(p)), glm::max(box.high, fit(p))};
    if (line.is_closed && std::max(box.high.x - box.low.x, box.high.y - box.low.y) < small) {
      markers.boxes.push_back({box.low - 1.0, box.high + 1.0});
      continue;
    }
    const std::size_t count = line.points.size();
    for (std::size_t i = 0; i + (line.is_closed ? 0 : 1) < count; ++i)
      markers.segments.push_back({fit(line.points[i]), fit(line.points[(i + 1) % count])});
  }
  return markers;
}

}  // namespace

bool overlap(const PictureBox& a, const PictureBox& b, double gap) noexcept {
  return a.low.x < b.high.x + gap && b.low.x < a.high.x + gap && a.low.y < b.high.y + gap &&
         b.low.y < a.high.y + gap;
}

/// Clips the segment by the four edges (Liang and Barsky 1984).
bool passes(const Segment& segment, const PictureBox& box) noexcept {
  const dvec2 along = segment[1] - segment[0];
  double from = 0, to = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double low = box.low[axis] - segment[0][axis], high = box.high[axis] - segment[0][axis];
    if (along[axis] == 0) {
      if (low >= 0 || high <= 0) return false;
      continue;
    }
    const double a = low / along[axis], b = high / along[axis];
    from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
  }
  constexpr double k_rounding = 1e-9;  // a segment that ends at an edge does not pass through the box
  return to - from > k_rounding || (along.x == 0 && along.y == 0);
}

void LabelLayout::Obstacles::add(const Obstacles& more) {
  boxes.insert(boxes.end(), more.boxes.begin(), more.boxes.end());
  segments.insert(segments.end(), more.segments.begin(), more.segments.end());
}

LabelLayout::LabelLayout(const PictureBox& picture, Obstacles obstacles, double gap)
    : picture_(picture), obstacles_(std::move(obstacles)), gap_(gap) {}

bool LabelLayout::is_free(const PictureBox& box) const noexcept {
  return std::none_of(labels_.begin(), labels_.end(),
                      [&](const PictureBox& other) { return overlap(box, other, gap_); }) &&
         std::none_of(obstacles_.boxes.begin(), obstacles_.boxes.end(),
                      [&](const PictureBox& other) { return overlap(box, other); }) &&
         std::none_of(obstacles_.segments.begin(), obstacles_.segments.end(),
                      [&](const Segment& line) { return passes(line, box); }) &&
         std::none_of(leads_.begin(), leads_.end(), [&](const Segment& lead) { return passes(lead, box); });
}

/// Returns true if a lead crosses a label, another lead, or a box other than that of its own marker.
bool LabelLayout::is_crossed(const Segment& lead, const dvec2& anchor) const noexcept {
  return std::any_of(labels_.begin(), labels_.end(),
                     [&](const PictureBox& box) { return passes(lead, box); }) ||
         std::any_of(obstacles_.boxes.begin(), obstacles_.boxes.end(),
                     [&](const PictureBox& box) { return !contains(box, anchor) && passes(lead, box); }) ||
         std::any_of(leads_.begin(), leads_.end(),
                     [&](const Segment& other) { return cross_each_other(lead, other); });
}

std::optional<LabelLayout::Place> LabelLayout::place(const Request& request) {
  constexpr double k_near = 8;         // pixels; a label nearer to its marker has no lead
  constexpr double k_crossing = 1000;  // cost of a crossed lead, pixels of distance
  const dvec2 room = picture_.high - picture_.low - request.size;
  if (room.x < 0 || room.y < 0) return std::nullopt;
  const dvec2 start = glm::clamp(request.preferred, picture_.low, picture_.low + room);
  // Search outward from the preferred position: rows alternately above and below it, and in each row columns
  // alternately to its right and left.
  const double step = std::max(2.0, 0.25 * request.size.y);
  const auto offset = [&](int i) { return (i % 2 == 0 ? -0.5 : 0.5) * step * (i + i % 2); };
  std::optional<Place> best;
  double least = 1e300;
  for (int row = 0; std::abs(offset(row)) <= room.y + step && std::abs(offset(row)) < least; ++row)
    for (int column = 0;; ++column) {
      const dvec2 moved(offset(column), offset(row));
      double cost = std::abs(moved.x) + std::abs(moved.y);
      if (std::abs(moved.x) > room.x + step || cost >= least) break;
      const PictureBox box{start + moved, start + moved + request.size};
      if (glm::any(glm::lessThan(box.low, picture_.low)) ||
          glm::any(glm::greaterThan(box.high, picture_.high)))
        continue;
      if (request.limit) {
        const double side = request.is_left ? -1 : 1;
        const double past = side * (*request.limit - (request.is_left ? box.high.x : box.low.x));
        if (past > 0.5 * request.size.x) continue;
        cost += 2 * std::max(0.0, past);
      }
      if (contains({box.low + 1e-9, box.high - 1e-9}, request.anchor) || cost >= least || !is_free(box))
        continue;
      Place found{box};
      const dvec2 edge = glm::clamp(request.anchor, box.low, box.high), line = edge - request.anchor;
      const double distance = glm::length(line);
      if (distance > request.longest) continue;
      if (distance > request.radius + k_near) {
        found.lead = Segment{request.anchor + request.radius / distance * line, edge};
        if (is_crossed(*found.lead, request.anchor)) cost += k_crossing;
      }
      if (cost < least) least = cost, best = found;
    }
  if (best) {
    labels_.push_back(best->box);
    if (best->lead) leads_.push_back(*best->lead);
  }
  return best;
}

std::vector<PlacedLabel> place_labels(const Panel& panel, const LabelSpace& space) {
  const Fit fit(panel, space.width, space.height);
  LabelLayout::Obstacles obstacles = markers_of(panel, fit, 1.5 * space.line);
  obstacles.boxes.insert(obstacles.boxes.end(), space.occupied.begin(), space.occupied.end());
  const PictureBox area{glm::max(fit.picture.low, dvec2(0)),
                        glm::min(fit.picture.high, dvec2(space.width, space.height))};
  LabelLayout layout(area, std::move(obstacles), 1);

  // Labels of markers to the left of `middle` are on the left, others on the right. It is the middle of the
  // markers, or the picture's centre if all markers are on one side of this centre.
  std::vector<PlacedLabel> placed(panel.labels.size());
  std::vector<std::size_t> order;
  double low = 1e300, high = -1e300;
  for (std::size_t i = 0; i < panel.labels.size(); ++i) {
    const dvec2 at = fit(panel.labels[i].point);
    if (!contains(area, at)) continue;
    low = std::min(low, at.x), high = std::max(high, at.x);
    order.push_back(i);
  }
  const double middle = fit.centre.x < low || fit.centre.x > high ? fit.centre.x : 0.5 * (low + high);
  const auto from_middle = [&](std::size_t i) { return fit(panel.labels[i].point).x - middle; };
  // Labels of the outermost markers are placed first, next to their markers. Later labels avoid them.
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(from_middle(a)) > std::abs(from_middle(b)) + 1e-6;
  });

  constexpr double k_gap = 3;  // pixels between a marker and its label
  const auto request = [&](std::size_t i, const std::string& text) {
    const Panel::Label& label = panel.labels[i];
    LabelLayout::Request r;
    r.anchor = fit(label.point), r.radius = fit.pixels_per_mm * label.radius;
    r.size = {space.width_of(text), space.line};
    const bool is_in_middle = std::abs(from_middle(i)) <= std::max(1.0, r.radius);
    r.is_left = is_in_middle ? label.is_to_left : from_middle(i) < 0;
    if (!is_in_middle) r.limit = middle;
    const double out = r.radius + k_gap;
    r.preferred = r.anchor + dvec2(r.is_left ? -out - r.size.x : out, -0.5 * r.size.y);
    return r;
  };
  std::vector<std::size_t> without_room;
  for (const std::size_t i : order) {
    const std::string text = space.shown_text(panel.labels[i].text);
    if (const auto found = layout.place(request(i, text)))
      placed[i] = {text, 0, found->box, found->lead};
    else
      without_room.push_back(i);
  }
  std::sort(without_room.begin(), without_room.end());
  int number = space.first_number;
  for (const std::size_t i : without_room) {
    const std::string text = std::to_string(number);
    if (const auto found = layout.place(request(i, text)))
      placed[i] = {text, number++, found->box, found->lead};
  }
  return placed;
}

std::size_t least_covering(const Panel& panel, double width, double height,
                           std::span<const PictureBox> candidates, std::span<const PictureBox> occupied) {
  const auto columns = static_cast<std::size_t>(panel.columns), rows = static_cast<std::size_t>(panel.rows);
  if (candidates.empty() || columns * rows == 0 || panel.pixels.size() != columns * rows) return 0;
  const Fit fit(panel, width, height);
  const auto pixel = [&](std::size_t column, std::size_t row) {
    return panel.pixels[column + columns * row];
  };
  std::map<Panel::Colour, int> border;
  for (std::size_t c = 0; c < columns; ++c) ++border[pixel(c, 0)], ++border[pixel(c, rows - 1)];
  for (std::size_t r = 0; r < rows; ++r) ++border[pixel(0, r)], ++border[pixel(columns - 1, r)];
  const Panel::Colour background =
      std::max_element(border.begin(), border.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      })->first;
  const auto is_background = [&](const Panel::Colour& colour) {
    constexpr int k_alike = 24;
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(colour[i] - background[i]) > k_alike) return false;
    return true;
  };
  // Area of the image's contents that a box would cover, in pixels. Markers of the plan and other texts count
  // much more.
  const auto covered = [&](const PictureBox& box) {
    constexpr double k_step = 3, k_marker = 100;
    double area = 0;
    for (double y = box.low.y; y < box.high.y; y += k_step)
      for (double x = box.low.x; x < box.high.x; x += k_step) {
        const dvec2 at = (dvec2(x, y) - fit.picture.low) / fit.scale;
        if (at.x < 0 || at.y < 0 || at.x >= panel.columns || at.y >= panel.rows) continue;
        if (!is_background(pixel(static_cast<std::size_t>(at.x), static_cast<std::size_t>(at.y))))
          area += k_step * k_step;
      }
    for (const Panel::Line& line : panel.lines) {
      if (!line.is_marker) continue;
      for (const dvec2& p : line.points) area += contains(box, fit(p)) ? k_marker : 0;
    }
    for (const PictureBox& other : occupied) {
      const dvec2 common =
          glm::max(glm::min(box.high, other.high) - glm::max(box.low, other.low), dvec2(0.0));
      area += 10 * common.x * common.y;
    }
    return area;
  };
  std::size_t best = 0;
  double least = covered(candidates[0]);
  const double limit = 0.5 * least;
  for (std::size_t i = 1; i < candidates.size(); ++i)
    if (const double area = covered(candidates[i]); area < limit && area < least) least = area, best = i;
  return best;
}

}  // namespace trephine::imaging
