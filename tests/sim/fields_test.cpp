// Fields of structs: as bytes, as words, and checked against their ranges.
#include "sim/api/fields.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace trephine::sim {
namespace {

enum class Spin : std::uint8_t { forward, reverse, still };
constexpr std::string_view k_spins[] = {"forward", "reverse", "still"};

/// One field of each type.
struct Everything {
  bool is_on = false;
  std::int64_t count = 3;
  double radius = 2;
  glm::dvec3 at{0.0};
  Id body;
  Spin spin = Spin::still;
  std::string note;
  std::vector<double> weights;
  std::vector<glm::dvec3> path;
  std::vector<Id> parts;
  friend bool operator==(const Everything&, const Everything&) = default;
};
constexpr Field k_everything[] = {
    field<&Everything::is_on>("on"),
    field<&Everything::count>("count", {.low = 0, .high = 9}),
    field<&Everything::radius>("radius", {.unit = "mm", .low = 0.1, .high = 30, .help = "of the ball"}),
    field<&Everything::at>("at", {.unit = "mm", .low = -1e6, .high = 1e6}),
    field<&Everything::body>("body"),
    field<&Everything::spin>("spin", {.choices = k_spins}),
    field<&Everything::note>("note"),
    field<&Everything::weights>("weights", {.low = 0}),
    field<&Everything::path>("path", {.unit = "mm"}),
    field<&Everything::parts>("parts")};
constexpr Schema k_schema{"everything", 2, k_everything};

Everything some() {
  return {true,          7,      0.1 + 0.2,     {1.5, -2, 1e-9},        {41},
          Spin::reverse, "burr", {0.25, 1e300}, {{1, 2, 3}, {4, 5, 6}}, {{1}, {2}, {4'000'000'000u}}};
}

std::string bytes_of(const Everything& value) {
  std::string bytes;
  encode_fields(k_schema, &value, bytes);
  return bytes;
}

TEST(Fields, RoundTripThroughBytesAndWords) {
  for (const Everything& value : {Everything{}, some()}) {
    Everything back, spoken;
    const Status from_bytes = decode_fields(k_schema, &back, bytes_of(value));
    EXPECT_FALSE(from_bytes) << from_bytes->message();
    EXPECT_EQ(back, value);
    EXPECT_EQ(bytes_of(back), bytes_of(value));
    const std::string words = to_words(k_schema, &value);
    const Status from_text = from_words(k_schema, &spoken, words);
    EXPECT_FALSE(from_text) << words << from_text->message();
    EXPECT_EQ(spoken, value) << words;
  }
  // Words may be in any order; other fields keep their values; numbers are exact to the bit.
  Everything value;
  EXPECT_FALSE(from_words(k_schema, &value, "  path=1,2,3;4,5,6 radius=0.30000000000000004\tspin=forward "));
  EXPECT_EQ(value.radius, 0.1 + 0.2);
  EXPECT_EQ(value.path.size(), 2u);
  EXPECT_EQ(value.spin, Spin::forward);
  EXPECT_EQ(value.count, 3);
}

struct Remark {
  std::string text;
  double weight = 1;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&Remark::text>("text"), field<&Remark::weight>("weight")};
    static constexpr Schema table{"remark", 1, fields};
    return table;
  }
};

TEST(Fields, TextsWithSpacesAreQuoted) {
  for (const char* text : {"", "short", "viscous damping=0.01", " ", "a=b", "a \"quoted\" word", "\"",
                           "C:\\new", "two\nlines", "ends with \\", "\ttab"}) {
    const Remark said{text, 2};
    Remark read;
    const std::string words = to_words(Remark::schema(), &said);
    const Status error = from_words(Remark::schema(), &read, words);
    EXPECT_FALSE(error) << words << ": " << error->message();
    EXPECT_EQ(read.text, text);
    EXPECT_EQ(read.weight, 2);
  }
  Remark read;
  EXPECT_TRUE(from_words(Remark::schema(), &read, "text=two words"));
  EXPECT_TRUE(from_words(Remark::schema(), &read, "text=\"no end"));
  EXPECT_TRUE(from_words(Remark::schema(), &read, "text=\"ends\"early weight=1"));
}

TEST(Fields, ValuesOutOfRangeAreRefusedByName) {
  const auto refused = [](const char* words, const char* field, const char* expected) {
    Everything value;
    const Status error = from_words(k_schema, &value, words);
    ASSERT_TRUE(error.has_value()) << words;
    EXPECT_NE(error->message().find(field), std::string::npos) << error->message();
    EXPECT_NE(error->message().find(expected), std::string::npos) << error->message();
  };
  refused("radius=2 count=1 radius=2", "everything radius", "at most once");
  refused("radius=31", "everything radius", "0.1 to 30 mm");
  refused("radius=nan", "everything radius", "number");
  refused("radius=2mm", "everything radius", "number");
  refused("count=10", "everything count", "0 to 9");
  refused("count=1.5", "everything count", "integer");
  refused("at=1,2", "everything at", "point");
  refused("at=1,2,3,4", "everything at", "point");
  refused("at=1,2,2e6", "everything at", "three numbers");
  refused("spin=sideways", "everything spin", "forward, reverse, still");
  refused("weights=1,-1", "everything weights", "0 or more");
  refused("weights=1,,2", "everything weights", "numbers");
  refused("weights=1,", "everything weights", "numbers");
  refused("parts=1,-2", "everything parts", "ids");
  refused("diameter=3", "diameter", "on, count, radius");
  refused("radius", "radius", "NAME=VALUE");
  refused("on=maybe", "everything on", "flag");
  // The bytes of a file may contain values that no words produce.
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 0.0}) {
    Everything value = some(), back;
    value.radius = bad;
    EXPECT_TRUE(check_fields(k_schema, &value).has_value());
    EXPECT_TRUE(decode_fields(k_schema, &back, bytes_of(value)).has_value());
  }
  Everything value = some();
  value.spin = static_cast<Spin>(3);
  EXPECT_TRUE(check_fields(k_schema, &value).has_value());
  value = some();
  value.path[1].y = std::nan("");
  EXPECT_TRUE(check_fields(k_schema, &value).has_value());
}

TEST(Fields, BrokenBytesAreAtMostAnError) {
  const std::string whole = bytes_of(some());
  int errors = 0;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    Everything value;
    errors += decode_fields(k_schema, &value, std::string_view(whole).substr(0, length)).has_value();
  }
  // Bytes that end between two fields are valid, like those of an older program with fewer fields.
  EXPECT_EQ(errors, static_cast<int>(whole.size() - std::size(k_everything)));
  std::mt19937 random(3);
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = whole;
    for (unsigned k = 0, n = 1 + random() % 4; k < n; ++k)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    Everything value;
    if (decode_fields(k_schema, &value, bytes)) continue;
    ++read;
    ASSERT_FALSE(check_fields(k_schema, &value).has_value());
  }
  EXPECT_GT(read, 1000);
  EXPECT_LT(read, 19000);
}

/// Version 1 of the struct had three fields.
TEST(Fields, AFieldAddedLaterKeepsItsDefault) {
  const Schema before{"everything", 1, std::span(k_everything).first(3)};
  const Everything value = some();
  std::string bytes;
  encode_fields(before, &value, bytes);
  Everything now;
  ASSERT_FALSE(decode_fields(k_schema, &now, bytes).has_value());
  EXPECT_EQ(now.radius, value.radius);
  EXPECT_EQ(now.spin, Spin::still);
  // An older program ignores the fields that it does not know.
  Everything then;
  ASSERT_FALSE(decode_fields(before, &then, bytes_of(value)).has_value());
  EXPECT_EQ(then.count, 7);
  EXPECT_EQ(then.note, "");
  EXPECT_EQ(describe(before), "everything 1: on flag, count integer, radius number mm");
  EXPECT_EQ(describe(Schema{"undo", 1, {}}), "undo 1:");
}

}  // namespace
}  // namespace trephine::sim
