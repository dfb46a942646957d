// Value: a plain struct of any type that has a table of its fields.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "sim/api/fields.h"

namespace trephine::sim {

/// Construction, copy and destruction of a struct with `static const Schema& schema()`.
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

/// Owns a struct that has a schema. Copies are deep.
class Value {
 public:
  Value() noexcept = default;  ///< empty
  template <HasSchema T>
  Value(T value) : type_(&value_type<T>()), object_(new T(std::move(value))) {}
  Value(const Value& other)
      : type_(other.type_), object_(other.object_ ? type_->copy(other.object_) : nullptr) {}
  Value(Value&& other) noexcept : type_(other.type_), object_(std::exchange(other.object_, nullptr)) {}
  Value& operator=(Value other) noexcept {
    std::swap(type_, other.type_);
    std::swap(object_, other.object_);
    return *this;
  }
  ~Value() {
    if (object_) type_->destroy(object_);
  }
  /// Returns a value with the struct's defaults.
  static Value of(const ValueType& type) {
    Value result;
    result.type_ = &type;
    result.object_ = type.make();
    return result;
  }
  /// Error on broken bytes, or a value out of its range.
  static Result<Value> from_bytes(const ValueType& type, std::string_view bytes);

  bool is_empty() const noexcept { return object_ == nullptr; }
  bool is_of(const ValueType& type) const noexcept { return object_ != nullptr && type_ == &type; }
  /// Requires a non-empty value, as do schema() and name().
  const ValueType& type() const noexcept { return *type_; }
  const Schema& schema() const noexcept { return *type_->schema; }
  std::string_view name() const noexcept { return schema().name; }
  const void* data() const noexcept { return object_; }
  void* data() noexcept { return object_; }
  /// Returns null if the value is empty or contains another struct.
  template <HasSchema T>
  const T* as() const noexcept {
    return is_of(value_type<T>()) ? static_cast<const T*>(object_) : nullptr;
  }
  template <HasSchema T>
  T* as() noexcept {
    return is_of(value_type<T>()) ? static_cast<T*>(object_) : nullptr;
  }

  Status check() const { return check_fields(schema(), object_); }
  std::string bytes() const;
  /// Returns the fields as text: "radius=2 at=1,2,3". Requires a non-empty value.
  std::string words() const { return to_words(schema(), object_); }
  Status set(std::string_view words) { return from_words(schema(), object_, words); }
  friend bool operator==(const Value& a, const Value& b);

 private:
  const ValueType* type_ = nullptr;
  void* object_ = nullptr;
};

}  // namespace trephine::sim
