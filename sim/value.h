// A plain struct that has a table of its fields, whichever struct it is.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "sim/fields.h"

namespace trephine::sim {

/// Construction, copy and destruction of a struct that holds `static const Schema& schema()`.
struct ValueType {
  const Schema* schema;
  void* (*make)();
  void* (*copy)(const void*);
  void (*destroy)(void*) noexcept;
};
template <class T>
const ValueType& value_type() noexcept {
  static const ValueType type{&T::schema(), []() -> void* { return new T; },
                              [](const void* v) -> void* { return new T(*static_cast<const T*>(v)); },
                              [](void* v) noexcept { delete static_cast<T*>(v); }};
  return type;
}

template <class T>
concept HasSchema = requires {
  { T::schema() } -> std::same_as<const Schema&>;
};

/// A value: a copy is another one.
class Value {
 public:
  Value() noexcept = default;  ///< none
  template <HasSchema T>
  Value(T value) : type_(&value_type<T>()), held_(new T(std::move(value))) {}
  Value(const Value& other) : type_(other.type_), held_(other.held_ ? type_->copy(other.held_) : nullptr) {}
  Value(Value&& other) noexcept : type_(other.type_), held_(std::exchange(other.held_, nullptr)) {}
  Value& operator=(Value other) noexcept {
    std::swap(type_, other.type_);
    std::swap(held_, other.held_);
    return *this;
  }
  ~Value() {
    if (held_) type_->destroy(held_);
  }
  /// With the struct's defaults.
  static Value of(const ValueType& type) {
    Value made;
    made.type_ = &type;
    made.held_ = type.make();
    return made;
  }
  /// Error on broken bytes, or a value out of its range.
  static volume::Result<Value> from_bytes(const ValueType& type, std::string_view bytes);

  bool is_empty() const noexcept { return held_ == nullptr; }
  bool is_of(const ValueType& type) const noexcept { return held_ != nullptr && type_ == &type; }
  /// These ask for a value that is not empty.
  const ValueType& type() const noexcept { return *type_; }
  const Schema& schema() const noexcept { return *type_->schema; }
  std::string_view name() const noexcept { return schema().name; }
  const void* data() const noexcept { return held_; }
  void* data() noexcept { return held_; }
  /// Null when it is another struct.
  template <HasSchema T>
  const T* as() const noexcept {
    return is_of(value_type<T>()) ? static_cast<const T*>(held_) : nullptr;
  }
  template <HasSchema T>
  T* as() noexcept {
    return is_of(value_type<T>()) ? static_cast<T*>(held_) : nullptr;
  }

  volume::Status check() const { return check_fields(schema(), held_); }
  std::string bytes() const;
  /// "radius=2 at=1,2,3".
  std::string words() const { return to_words(schema(), held_); }
  volume::Status set(std::string_view words) { return from_words(schema(), held_, words); }
  friend bool operator==(const Value& a, const Value& b);

 private:
  const ValueType* type_ = nullptr;
  void* held_ = nullptr;
};

}  // namespace trephine::sim
