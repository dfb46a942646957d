// Field and Schema: a table that lists the members of a plain struct once. Bytes, checks and words of the
// struct follow from this table. Commands, parameters of instruments and events are such structs.
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

/// Pointer to a member of a struct. The alternative of the variant gives the type of the field. A choice,
/// which is an enum of one byte, uses std::uint8_t*.
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
  std::size_t most_values = 0;  ///< of a list: most values that a window lets the user enter; 0:
                                ///< any number. check_fields() does not check it
  bool is_expert = false;       ///< shown in a window only on request
  /// Kind of name that a text field contains. A window offers the existing names of this kind. Outlines and
  /// trajectories are those of the plan; an approach is an outline or a trajectory.
  enum class Names : std::uint8_t { any, label, bone_label, outline, trajectory, approach, branch };
  Names names = Names::any;
  /// Text that a window shows for an empty name or the id 0; empty: a name is required.
  std::string_view empty_choice = {};
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

/// Table of a struct. `version` increases when the meaning of a field changes. Fields may be added at the end
/// without a new version.
struct Schema {
  std::string_view name;
  std::uint32_t version = 1;
  std::span<const Field> fields = {};
};

/// Returns the fields of a struct, followed by those that an extended struct adds.
std::vector<Field> joined(std::span<const Field> first, std::span<const Field> more);

/// Largest number of elements of a list, and of bytes of a text.
inline constexpr std::size_t k_longest_list = 1 << 16;

/// Returns an error if a value is out of its field's range or not a number, or if a list or text is too long.
/// The error names struct, field, value and range.
Status check_fields(const Schema& schema, const void* value);

/// Appends canonical bytes: equal values give equal bytes on every machine.
void encode_fields(const Schema& schema, const void* value, std::string& out);
/// Sets the fields of `value`, which must contain its defaults: fields that an older program did not write
/// keep their defaults. Bytes after the known fields, which a newer program wrote, are ignored. Error if the
/// bytes are broken, or check_fields() refuses the value; `value` is then partly set.
Status decode_fields(const Schema& schema, void* value, std::string_view bytes);

/// Returns all fields as text for users and scripts, such as "radius=2 at=1,2,3 mode=fast".
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
