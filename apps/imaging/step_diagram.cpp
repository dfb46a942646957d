#include "apps/imaging/step_diagram.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <string_view>

#include "apps/workbench/text.h"
#include "volume/base/text.h"

namespace trephine::imaging {

using glm::dvec2;
using volume::ProcedureStep;
using volume::StepTransition;
using volume::SurgicalProcedure;

namespace {

// All sizes are in pixels.
constexpr double k_margin = 20, k_box_width = 270, k_padding = 12, k_lane = 14, k_port = 16, k_gap = 30;
constexpr double k_title = 15, k_words = 13, k_small = 12, k_label_width = 250;
constexpr double k_line = 1.3;                 // line height, as a multiple of the font size
constexpr double k_head = 9, k_half_head = 4;  // length and half width of an arrow's head
constexpr double k_apart = 8;                  // between two arrows of one lane
constexpr double k_indent = 10;                // from a box to its label

/// Returns an upper bound of the width of a character in DejaVu Sans, as a multiple of the font size.
double width_of(std::string_view character) {
  constexpr std::string_view k_narrow = "ijlI|.,:;'! ", k_medium = "ftr()[]-/\"", k_wide = "mwMWQOGD%@=<>+";
  if (character.size() > 1) return 0.9;
  if (k_narrow.find(character) != std::string_view::npos) return 0.34;
  if (k_medium.find(character) != std::string_view::npos) return 0.46;
  if (k_wide.find(character) != std::string_view::npos) return 1;
  return character[0] >= 'A' && character[0] <= 'Z' ? 0.78 : 0.66;
}

/// Calls use(character) for each character of UTF-8 text.
template <class Use>
void for_each_character(std::string_view text, const Use& use) {
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at + 1;
    while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0u) == 0x80) ++end;
    use(text.substr(at, end - at));
    at = end;
  }
}

double width_of(std::string_view text, double size, bool is_bold) {
  double width = 0;
  for_each_character(text, [&](std::string_view character) { width += width_of(character); });
  return width * size * (is_bold ? 1.12 : 1);
}

/// Splits a text into lines that are not wider than `width`, at spaces if possible.
std::vector<std::string> wrapped(std::string_view text, double width, double size, bool is_bold = false) {
  std::vector<std::string> lines(1);
  std::size_t space = std::string::npos;  // in the last line
  for_each_character(text, [&](std::string_view character) {
    const bool is_limit = lines.back().ends_with("≥") || lines.back().ends_with("≤");
    if (character == " " && !is_limit) space = lines.back().size();
    lines.back() += character;
    if (width_of(lines.back(), size, is_bold) <= width) return;
    std::string rest(character);
    if (space != std::string::npos) {
      rest = lines.back().substr(space + 1);
      lines.back().resize(space);
    } else {
      lines.back().resize(lines.back().size() - character.size());
    }
    lines.push_back(std::move(rest));
    space = std::string::npos;
  });
  return lines;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// An arrow from a step to another one, on the right side if it leads forward, else on the left.
struct Edge {
  std::size_t from = 0, to = 0;
  std::vector<std::string> label;
  bool is_straight = false;  ///< down to the next box, in the middle
  bool is_right = false;
  double from_y = 0, to_y = 0;
  std::size_t lane = 0;

  std::size_t span() const { return from > to ? from - to : to - from; }
  double label_height() const { return k_words * k_line * static_cast<double>(label.size()); }
  double low() const { return std::min(from_y, to_y); }
  double high() const { return std::max(from_y, to_y); }
};

class Layout {
 public:
  explicit Layout(const SurgicalProcedure& procedure) : procedure_(procedure) {
    add_edges();
    for (const Edge& edge : edges_)
      for (const std::string& line : edge.label) {
        const double width = width_of(line, k_words, false) + 2 * k_indent;
        double& column = edge.is_right ? right_column_ : left_column_;
        column = std::max(column, edge.is_straight ? width - k_box_width / 2 : width);
      }
  }

  StepDiagram make() {
    // Vertical positions, and therefore lanes, do not depend on the horizontal position of the boxes.
    double y = k_margin;
    const std::vector<std::string> heading =
        wrapped(procedure_.title.empty() ? procedure_.name : procedure_.title, k_box_width, k_title, true);
    const double heading_y = y;
    y += static_cast<double>(heading.size()) * k_title * k_line + 2 * k_dot;
    const double start_y = y;
    y += k_gap;
    std::vector<double> tops, heights;
    for (std::size_t s = 0; s < procedure_.steps.size(); ++s) {
      tops.push_back(y);
      heights.push_back(place_ports(s, y));
      y += heights.back() + gap_below(s);
    }
    const double left = k_margin + left_column_ + k_lane * static_cast<double>(add_lanes(false)),
                 right = left + k_box_width;
    diagram_.width = right + right_column_ + k_lane * static_cast<double>(add_lanes(true)) + k_margin;
    diagram_.height = tops.back() + heights.back() + k_margin;

    add_lines(heading, {left, heading_y}, k_title, true, false);
    diagram_.start = {left + k_box_width / 2, start_y};
    diagram_.arrows.push_back({{diagram_.start, {diagram_.start.x, tops.front()}}});
    for (std::size_t s = 0; s < tops.size(); ++s) {
      diagram_.boxes.push_back(
          {{{left, tops[s]}, {right, tops[s] + heights[s]}}, procedure_.steps[s].is_end});
      add_words(procedure_.steps[s], {left + k_padding, tops[s] + k_padding});
    }
    for (const Edge& edge : edges_) add_arrow(edge);
    return std::move(diagram_);
  }

 private:
  void add_edges() {
    for (std::size_t s = 0; s < procedure_.steps.size(); ++s) {
      bool has_straight = false;
      for (const StepTransition& transition : procedure_.steps[s].transitions) {
        Edge& edge = edges_.emplace_back();
        edge.from = s, edge.to = static_cast<std::size_t>(procedure_.find(transition.to));
        edge.is_straight = edge.to == s + 1 && !has_straight;
        edge.is_right = edge.to > s;
        has_straight = has_straight || edge.is_straight;
        for (const std::string& line : words_of(transition))
          for (std::string& part : wrapped(line, k_label_width, k_words))
            edge.label.push_back(std::move(part));
      }
    }
  }

  /// Lines of text in the box of a step.
  struct Line {
    std::string words;
    double size;
    bool is_bold, is_grey;
  };
  static std::vector<Line> lines_of(const ProcedureStep& step) {
    std::vector<Line> lines;
    const auto add = [&](const std::string& text, double size, bool is_bold) {
      for (std::string& line : wrapped(text, k_box_width - 2 * k_padding, size, is_bold))
        lines.push_back({std::move(line), size, is_bold, !is_bold});
    };
    add(step.title.empty() ? step.name : step.title, k_title, true);
    add(step.name + (step.is_end ? " (end)" : ""), k_small, false);
    if (!step.instruments.empty()) add("instruments: " + joined(step.instruments), k_small, false);
    if (!step.commands.empty()) add("commands: " + joined(step.commands), k_small, false);
    if (!step.on_entry.empty()) add("on entry: " + joined(step.on_entry), k_small, false);
    return lines;
  }

  /// Assigns vertical positions to the ends of the arrows at the sides of a box, from its top downward, so
  /// that few arrows cross. Returns the height of the box.
  double place_ports(std::size_t s, double top) {
    double height = 2 * k_padding;
    for (const Line& line : lines_of(procedure_.steps[s])) height += line.size * k_line;
    for (const bool is_right : {false, true}) {
      std::vector<Edge*> in, out;
      for (Edge& edge : edges_) {
        if (edge.is_straight || edge.is_right != is_right) continue;
        if (edge.to == s) in.push_back(&edge);
        if (edge.from == s) out.push_back(&edge);
      }
      const auto is_shorter = [](const Edge* a, const Edge* b) { return a->span() < b->span(); };
      const auto is_longer = [](const Edge* a, const Edge* b) { return a->span() > b->span(); };
      double y = top + k_padding / 2;
      const auto enter = [&] {
        for (Edge* edge : in) edge->to_y = y + k_port / 2, y += k_port;
      };
      const auto leave = [&] {
        for (Edge* edge : out) y += edge->label_height() + 4, edge->from_y = y, y += 6;
      };
      if (is_right) {
        std::stable_sort(in.begin(), in.end(), is_shorter),
            std::stable_sort(out.begin(), out.end(), is_longer);
        enter(), leave();
      } else {
        std::stable_sort(in.begin(), in.end(), is_longer),
            std::stable_sort(out.begin(), out.end(), is_shorter);
        leave(), enter();
      }
      height = std::max(height, y - top + k_padding / 2);
    }
    return height;
  }

  double gap_below(std::size_t s) const {
    for (const Edge& edge : edges_)
      if (edge.is_straight && edge.from == s) return std::max(k_gap, edge.label_height() + 2 * k_head);
    return k_gap;
  }

  /// Assigns the arrows of a side to vertical lanes. Short arrows are nearest to the boxes. Returns the
  /// number of lanes.
  std::size_t add_lanes(bool is_right) {
    std::vector<Edge*> side;
    for (Edge& edge : edges_)
      if (!edge.is_straight && edge.is_right == is_right) side.push_back(&edge);
    std::stable_sort(side.begin(), side.end(), [](const Edge* a, const Edge* b) {
      return a->high() - a->low() < b->high() - b->low();
    });
    std::size_t lanes = 0;
    for (std::size_t i = 0; i < side.size(); ++i) {
      const auto is_taken = [&](std::size_t lane) {
        return std::any_of(side.begin(), side.begin() + static_cast<std::ptrdiff_t>(i),
                           [&](const Edge* other) {
                             return other->lane == lane && other->low() < side[i]->high() + k_apart &&
                                    side[i]->low() < other->high() + k_apart;
                           });
      };
      while (is_taken(side[i]->lane)) ++side[i]->lane;
      lanes = std::max(lanes, side[i]->lane + 1);
    }
    return lanes;
  }

  void add_lines(const std::vector<std::string>& lines, dvec2 at, double size, bool is_bold,
                 bool is_at_right) {
    for (const std::string& line : lines) {
      const double width = width_of(line, size, is_bold);
      const double left = is_at_right ? at.x - width : at.x;
      diagram_.texts.push_back(
          {line, {{left, at.y}, {left + width, at.y + size * k_line}}, size, is_bold, false, is_at_right});
      at.y += size * k_line;
    }
  }

  void add_words(const ProcedureStep& step, dvec2 at) {
    for (const Line& line : lines_of(step)) {
      add_lines({line.words}, at, line.size, line.is_bold, false);
      diagram_.texts.back().is_grey = line.is_grey;
      at.y += line.size * k_line;
    }
  }

  void add_arrow(const Edge& edge) {
    const PictureBox &from = diagram_.boxes[edge.from].area, &to = diagram_.boxes[edge.to].area;
    if (edge.is_straight) {
      const double x = (from.low.x + from.high.x) / 2, middle = (from.high.y + to.low.y) / 2;
      diagram_.arrows.push_back({{{x, from.high.y}, {x, to.low.y}}});
      add_lines(edge.label, {x + k_indent, middle - edge.label_height() / 2}, k_words, false, false);
      return;
    }
    const double lanes = k_lane * (static_cast<double>(edge.lane) + 0.5);
    const double side = edge.is_right ? from.high.x : from.low.x,
                 lane = edge.is_right ? side + right_column_ + lanes : side - left_column_ - lanes;
    diagram_.arrows.push_back(
        {{{side, edge.from_y}, {lane, edge.from_y}, {lane, edge.to_y}, {side, edge.to_y}}});
    add_lines(edge.label,
              {edge.is_right ? side + k_indent : side - k_indent, edge.from_y - 2 - edge.label_height()},
              k_words, false, !edge.is_right);
  }

  const SurgicalProcedure& procedure_;
  std::vector<Edge> edges_;
  double left_column_ = 2 * k_indent, right_column_ = 2 * k_indent;
  StepDiagram diagram_;
};

std::string rectangle(const PictureBox& area, const char* style) {
  return workbench::format_text("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" rx=\"4\" %s/>\n",
                                area.low.x, area.low.y, area.high.x - area.low.x, area.high.y - area.low.y,
                                style);
}

}  // namespace

std::vector<std::string> words_of(const StepTransition& transition) {
  std::vector<std::string> lines;
  if (!transition.on.empty()) lines.push_back("on " + transition.on);
  for (const volume::StepCondition& condition : transition.conditions) {
    std::string text = condition.measurement;
    if (condition.minimum && condition.maximum)
      text.append(" ").append(text_of(*condition.minimum)).append(" to ").append(text_of(*condition.maximum));
    else if (condition.minimum)
      text.append(" ≥ ").append(text_of(*condition.minimum));
    else if (condition.maximum)
      text.append(" ≤ ").append(text_of(*condition.maximum));
    lines.push_back(std::move(text));
  }
  return lines;
}

StepDiagram step_diagram(const SurgicalProcedure& procedure) { return Layout(procedure).make(); }

std::array<dvec2, 3> head_of(const StepDiagram::Arrow& arrow) {
  const dvec2 tip = arrow.points.back();
  const dvec2 ahead = glm::normalize(tip - arrow.points[arrow.points.size() - 2]), across{-ahead.y, ahead.x};
  const dvec2 back = tip - k_head * ahead;
  return {tip, back + k_half_head * across, back - k_half_head * across};
}

std::string svg_of(const StepDiagram& diagram) {
  std::string svg = workbench::format_text(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\" "
      "font-family=\"Arial, Helvetica, sans-serif\">\n"
      "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
      diagram.width, diagram.height, diagram.width, diagram.height);
  for (const StepDiagram::Box& box : diagram.boxes) {
    svg += rectangle(box.area, "fill=\"#eef3f8\" stroke=\"#404040\" stroke-width=\"1.5\"");
    if (box.is_end)
      svg += rectangle({box.area.low + k_double_line, box.area.high - k_double_line},
                       "fill=\"none\" stroke=\"#404040\"");
  }
  const auto add_points = [&svg](std::span<const dvec2> points) {
    for (const dvec2& p : points) svg += workbench::format_text("%.1f,%.1f ", p.x, p.y);
  };
  for (const StepDiagram::Arrow& arrow : diagram.arrows) {
    svg += "<polyline points=\"";
    add_points(arrow.points);
    svg += "\" fill=\"none\" stroke=\"#404040\" stroke-width=\"1.2\"/>\n<polygon points=\"";
    add_points(head_of(arrow));
    svg += "\" fill=\"#404040\"/>\n";
  }
  svg += workbench::format_text("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%g\" fill=\"#404040\"/>\n",
                                diagram.start.x, diagram.start.y, k_dot);
  for (const StepDiagram::Text& text : diagram.texts) {
    constexpr double k_descent = 0.35;  // baseline above the lower edge, as a multiple of the font size
    svg += workbench::format_text(
        "<text x=\"%.1f\" y=\"%.1f\" font-size=\"%g\"%s%s%s>",
        text.is_at_right ? text.area.high.x : text.area.low.x, text.area.high.y - k_descent * text.size,
        text.size, text.is_bold ? " font-weight=\"bold\"" : "", text.is_grey ? " fill=\"#606060\"" : "",
        text.is_at_right ? " text-anchor=\"end\"" : "");
    svg += workbench::escape_svg(text.words) + "</text>\n";
  }
  return svg + "</svg>\n";
}

}  // namespace trephine::imaging
