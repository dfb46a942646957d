// Tables of fields: the members of a plain struct, listed once, and from that its bytes, its checks, its
// words. Commands, parameters of instruments and events are such structs.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "volume/error.h"

namespace trephine::sim {

/// Names something of an operation: a body, a structure, a hand. Never used twice; 0: none.
struct Id {
  std::uint32_t value = 0;
  friend bool operator==(const Id&, const Id&) = default;
};

/// Member of a struct; by its alternative the field's type. A choice is an enum of one byte.
using FieldPlace = std::variant<bool*, std::int64_t*, double*, glm::dvec3*, Id*, std::uint8_t*, std::string*,
                                std::vector<double>*, std::vector<glm::dvec3>*, std::vector<Id>*>;

/// Properties of a field in addition to its type.
struct FieldInfo {
  std::string_view unit = {};  ///< "mm", "N"; empty: none
  double low = -std::numeric_limits<double>::max(), high = std::numeric_limits<double>::max();
  std::span<const std::string_view> choices = {};  ///< names of an enum's values, from 0 on
  std::string_view help = {};                      ///< half a sentence, for people
  std::string_view label = {};                     ///< what people call it; empty: its name
  bool is_expert = false;                          ///< a window shows it only on request
  /// Kind of name in a text, so that a window offers those that there are.
  enum class Names : std::uint8_t { any, label, branch } names = Names::any;
};

struct Field {
  std::string_view name;
  FieldInfo info;
  std::size_t type;  ///< which alternative of FieldPlace
  FieldPlace (*place)(void* of) noexcept;
};

namespace detail {
template <class Value, class Variant>
struct IndexIn;
template <class Value, class... Places>
struct IndexIn<Value, std::variant<Places...>> {
  static constexpr std::size_t k_index = [] {
    std::size_t i = 0, found = sizeof...(Places);
    ((found = std::is_same_v<Value*, Places> ? i : found, ++i), ...);
    return found;
  }();
  static_assert(k_index < sizeof...(Places), "no field can be of this type");
};
template <class T>
struct MemberOf;
template <class Struct, class Value>
struct MemberOf<Value Struct::*> {
  using Of = Struct;
  using Type = Value;
};
}  // namespace detail

/// A row of a table: field<&Cut::radius>("radius", {.unit = "mm", .low = 0.1, .high = 30}).
template <auto k_member>
constexpr Field field(std::string_view name, FieldInfo info = {}) {
  using Of = typename detail::MemberOf<decltype(k_member)>::Of;
  using Type = typename detail::MemberOf<decltype(k_member)>::Type;
  using Kept = std::conditional_t<std::is_enum_v<Type>, std::uint8_t, Type>;
  static_assert(sizeof(Kept) == sizeof(Type), "a choice is an enum of one byte");
  return {name, info, detail::IndexIn<Kept, FieldPlace>::k_index, [](void* of) noexcept -> FieldPlace {
            return reinterpret_cast<Kept*>(&(static_cast<Of*>(of)->*k_member));
          }};
}

/// A struct by name. `version` is raised when the meaning of a field changes; fields may be added at the end.
struct Schema {
  std::string_view name;
  std::uint32_t version = 1;
  std::span<const Field> fields = {};
};

/// The fields of a struct and of one that is it and more.
std::vector<Field> joined(std::span<const Field> first, std::span<const Field> more);

/// Longest lists and texts that are taken from a file.
inline constexpr std::size_t k_longest_list = 1 << 16;

/// Error when a value is out of its field's range, or no number; it names struct, field, value and range.
volume::Status check_fields(const Schema& schema, const void* value);

/// Canonical bytes: the same for the same value, on every machine. Appended.
void encode_fields(const Schema& schema, const void* value, std::string& out);
/// Sets `value`, which was made with its defaults: fields that an older program did not write keep them, and
/// what a newer one wrote after the known fields is left out. Error on broken bytes, or a value that
/// check_fields() refuses; `value` is then half set.
volume::Status decode_fields(const Schema& schema, void* value, std::string_view bytes);

/// "radius=2 at=1,2,3 mode=fast", for people and scripts.
std::string to_words(const Schema& schema, const void* value);
/// Value of one field as text, without its name: "2".
std::string to_words(const Field& field, const void* value);
/// Reads fields in any order; those that are not named stay as they are. Error names what was not
/// understood, and the fields. Texts with spaces stand in quotes.
volume::Status from_words(const Schema& schema, void* value, std::string_view words);

/// Names, types and units of the fields, for a file's header: what a program that does not know the struct
/// can say of it. "drill 1: at point mm, radius number mm".
std::string describe(const Schema& schema);

}  // namespace trephine::sim
