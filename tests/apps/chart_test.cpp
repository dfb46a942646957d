// Charts as SVG and CSV.
#include "apps/view/chart.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

using namespace trephine;

namespace {

view::Chart forces() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {.title = "Force < 3 N",
          .x_label = "time, s",
          .y_label = "force, N",
          .series = {{.name = "first \"a\"", .x = {0, 5, 10}, .y = {0, nan, 4}, .is_line = true},
                     {.name = "short", .x = {1}, .y = {1}, .is_line = true},
                     {.name = "dots", .x = {5}, .y = {2}}}};
}

std::size_t count(const std::string& text, const std::string& words) {
  std::size_t n = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++n;
  return n;
}

}  // namespace

TEST(Chart, SvgPlacesPointsByTheAxes) {
  const std::string svg = view::svg_of(forces(), 600, 400);
  // Ten seconds and 4 N span the axes, which are lines from the corner of the plot.
  double left = 0, bottom = 0, right = 0, top = 0;
  const std::size_t line = svg.find("<polyline points=\"");
  ASSERT_NE(line, std::string::npos);
  ASSERT_EQ(
      std::sscanf(svg.c_str() + line, "<polyline points=\"%lf,%lf %lf,%lf\"", &left, &bottom, &right, &top),
      4);
  EXPECT_LT(left, right);
  EXPECT_LT(top, bottom);  // y points down
  char x_axis[100];
  std::snprintf(x_axis, sizeof x_axis, "<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"#5a5a5a\"", left, bottom,
                right, bottom);
  EXPECT_NE(svg.find(x_axis), std::string::npos) << svg;
  char dot[100];
  std::snprintf(dot, sizeof dot, "cx=\"%.2f\" cy=\"%.2f\"", 0.5 * (left + right), 0.5 * (top + bottom));
  EXPECT_NE(svg.find(dot), std::string::npos) << svg;
  EXPECT_EQ(count(svg, "<polyline"), 1u) << "a line of one point is omitted";
  EXPECT_EQ(count(svg, "short"), 0u);
  EXPECT_EQ(count(svg, "nan"), 0u);
  EXPECT_NE(svg.find("Force &lt; 3 N"), std::string::npos);
  EXPECT_NE(svg.find("first &quot;a&quot;"), std::string::npos);
}

TEST(Chart, LogarithmicAxesHaveTicksAtDecades) {
  view::Chart chart = forces();
  chart.is_x_log = chart.is_y_log = true;
  chart.series = {{.name = "line", .x = {0, 0.5, 20}, .y = {1, 1, 100}, .is_line = true}};
  const std::string svg = view::svg_of(chart, 600, 400);
  for (const char* tick : {">0.1<", ">1<", ">10<", ">100<"})
    EXPECT_NE(svg.find(tick), std::string::npos) << tick;
  EXPECT_EQ(count(svg, "inf"), 0u);
}

TEST(Chart, EqualValuesAndNoValuesAreDrawn) {
  for (const std::vector<double>& y : {std::vector<double>{3, 3}, std::vector<double>{}}) {
    view::Chart chart = forces();
    chart.series = {{.name = "flat", .x = std::vector<double>(y.size(), 2), .y = y, .is_line = true}};
    const std::string svg = view::svg_of(chart, 600, 400);
    EXPECT_EQ(count(svg, "nan") + count(svg, "inf"), 0u) << svg;
    EXPECT_EQ(count(svg, "</svg>"), 1u);
  }
}

TEST(Chart, CsvHasEveryPoint) {
  EXPECT_EQ(view::csv_of(forces()),
            "series,\"time, s\",\"force, N\"\n\"first \"\"a\"\"\",0,0\n\"first \"\"a\"\"\",5,nan\n"
            "\"first \"\"a\"\"\",10,4\n\"short\",1,1\n\"dots\",5,2\n");
}
