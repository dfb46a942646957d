// Rows: text and JSON of the same values.
#include "apps/cli/rows.h"

#include <gtest/gtest.h>
#include <limits>

namespace trephine::cli {
namespace {

TEST(Rows, LinePrintsTheValuesOfJson) {
  Rows rows;
  rows.json["outline"] = {{"length_mm", 61.25}, {"holes", 2}, {"is_closed", true}, {"covered", 0.4567}};
  rows.json["at"] = {1.5, -2, 0.04};
  rows.print("{outline/length_mm:.1f} mm, {outline/holes} holes, closed: {outline/is_closed}, at {at:.1f}");
  rows.print("{outline/covered:.1%} covered, first {at/0:6.2f}|");
  EXPECT_EQ(rows.text, "61.2 mm, 2 holes, closed: yes, at 1.5, -2.0, 0.0\n45.7 % covered, first   1.50|\n");
}

TEST(Rows, RowComesBeforeTheReport) {
  Rows rows;
  rows.json["name"] = "report";
  rows.json["saw_mm"] = 0.5;
  rows.print("{name}, {saw_mm} mm", {{"name", "piece"}});
  EXPECT_EQ(rows.text, "piece, 0.5 mm\n");
  EXPECT_EQ(rows.json["name"], "report");
}

TEST(Rows, AddedRowIsALineWithItsUnit) {
  Rows rows;
  rows.add("triangles", std::size_t{1234567});
  rows.add("removed_mm3_total", 12345.6);
  rows.add("mesh_seconds", 0.01234);
  rows.add("seconds", 2);
  EXPECT_EQ(rows.text, "triangles: 1234567\nremoved total: 12346 mm³\nmesh: 0.0123 s\nseconds: 2 s\n");
  EXPECT_EQ(rows.json["triangles"], 1234567);
  EXPECT_EQ(rows.json["mesh_seconds"], 0.01234);
}

TEST(Rows, ValuesThatAreNotFiniteAreUnknown) {
  Rows rows;
  rows.json["nan"] = std::numeric_limits<double>::quiet_NaN();
  rows.json["inf"] = -std::numeric_limits<double>::infinity();
  rows.json["null"] = nullptr;
  rows.print("{nan:.1f} {inf:.1%} {null} {missing} {missing/key:.2f}");
  EXPECT_EQ(rows.text, "unknown unknown unknown unknown unknown\n");
  EXPECT_EQ(rows.json.dump(), R"({"nan":null,"inf":null,"null":null})");
}

TEST(Rows, NamesCannotControlTheOutput) {
  Rows rows;
  rows.json["name"] = "a\x1b[31m\n{seconds}\"";
  rows.json["seconds"] = 3;
  rows.print("{name}: {seconds} s");
  EXPECT_EQ(rows.text, "a\\x1b[31m\\x0a{seconds}\": 3 s\n");
  EXPECT_EQ(rows.json.dump(), R"({"name":"a\u001b[31m\n{seconds}\"","seconds":3})");
}

TEST(Rows, TableAlignsItsColumns) {
  Rows rows;
  rows.json["size"] = 64;
  rows.json["rows"] = {{{"by", "ours"}, {"ms", 1.5}, {"ratio", nullptr}},
                       {{"by", "µ"}, {"ms", 120}, {"ratio", 8.25}}};
  rows.print_table(rows.json["rows"],
                   "program = {by} | image, ms = {ms:.2f} | ratio = {ratio:.1f} | note = of {size}");
  EXPECT_EQ(rows.text,
            "program  image, ms  ratio  note\n"
            "ours          1.50      -  of 64\n"
            "µ           120.00    8.2  of 64\n");
}

}  // namespace
}  // namespace trephine::cli
