// Field and Schema: the members of a plain struct, listed once, from which its bytes, checks and words
// follow. Commands, parameters of instruments and events are such structs.
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

#include "volume/base/error.h"

namespace trephine::sim {

/// Identifies an object of an operation: a body, a job, an effect. Never reused; 0: unset.
struct Id {
  std::uint32_t value = 0;
  friend bool operator==(const Id&, const Id&) = default;
};

/// Pointer to a struct's member; its alternative is the field's type. A choice is an enum of one byte.
using FieldPointer =
    std::variant<bool*, std::int64_t*, double*, glm::dvec3*, Id*, std::uint8_t*, std::string*,
                 std::vector<double>*, std::vector<glm::dvec3>*, std::vector<Id>*>;

/// Properties of a field in addition to its type.
struct FieldInfo {
  std::string_view unit = {};  ///< "mm", "N"; empty: no unit
  double low = -std::numeric_limits<double>::max(), high = std::numeric_limits<double>::max();
  std::span<const std::string_view> choices = {};  ///< names of an enum's values, from 0 on
  std::string_view help = {};                      ///< fragment of a sentence, for users
  std::string_view label = {};                     ///< name shown to users; empty: the field's name
  std::size_t most_values = 0;                     ///< of a list, in a window; not checked; 0: any number
  bool is_expert = false;                          ///< shown in a window only on request
  /// Kind of name that a text field holds: a window then offers the existing ones. Outlines and trajectories
  /// are those of the plan; an approach is one or the other.
  enum class Names : std::uint8_t { any, label, bone_label, outline, trajectory, approach, branch };
  Names names = Names::any;
  std::string_view empty_choice = {};  ///< of an empty name or the id 0, for users; empty: a name is required
};

struct Field {
  std::string_view name;
  FieldInfo info;
  std::size_t type;  ///< index of the alternative of FieldPointer
  FieldPointer (*pointer_in)(void* object) noexcept;
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

/// Row of a table: field<&Cut::radius>("radius", {.unit = "mm", .low = 0.1, .high = 30}).
template <auto k_member>
constexpr Field field(std::string_view name, FieldInfo info = {}) {
  using Of = typename detail::MemberOf<decltype(k_member)>::Of;
  using Type = typename detail::MemberOf<decltype(k_member)>::Type;
  using Stored = std::conditional_t<std::is_enum_v<Type>, std::uint8_t, Type>;
  static_assert(sizeof(Stored) == sizeof(Type), "a choice is an enum of one byte");
  return {name, info, detail::IndexIn<Stored, FieldPointer>::k_index,
          [](void* object) noexcept -> FieldPointer {
            return reinterpret_cast<Stored*>(&(static_cast<Of*>(object)->*k_member));
          }};
}

/// Table of a struct. `version` is raised when the meaning of a field changes; fields may be added at the
/// end.
struct Schema {
  std::string_view name;
  std::uint32_t version = 1;
  std::span<const Field> fields = {};
};

/// Returns the fields of a struct, followed by those that an extended struct adds.
std::vector<Field> joined(std::span<const Field> first, std::span<const Field> more);

/// Longest list or text that is read from a file.
inline constexpr std::size_t k_longest_list = 1 << 16;

/// Error if a value is out of its field's range or not a number; it names struct, field, value and range.
Status check_fields(const Schema& schema, const void* value);

/// Appends canonical bytes: the same for equal values, on every machine.
void encode_fields(const Schema& schema, const void* value, std::string& out);
/// Sets `value`, which contains its defaults: fields that an older program did not write keep them, and bytes
/// of a newer program after the known fields are ignored. Error on broken bytes, or a value that
/// check_fields() refuses; `value` is then partly set.
Status decode_fields(const Schema& schema, void* value, std::string_view bytes);

/// Returns "radius=2 at=1,2,3 mode=fast", for users and scripts.
std::string to_words(const Schema& schema, const void* value);
/// Returns the value of one field as text, without its name: "2".
std::string to_words(const Field& field, const void* value);
/// Reads fields in any order; fields that are not named keep their values. The error names the unknown word
/// and the known fields. Texts with spaces are quoted.
Status from_words(const Schema& schema, void* value, std::string_view words);

/// Returns names, types and units of the fields, for a file's header, so that a program that does not know
/// the struct can describe it: "drill 1: at point mm, radius number mm".
std::string describe(const Schema& schema);

}  // namespace trephine::sim
