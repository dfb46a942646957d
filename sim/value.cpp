#include "sim/value.h"

namespace trephine::sim {

volume::Result<Value> Value::from_bytes(const ValueType& type, std::string_view bytes) {
  Value made = of(type);
  if (volume::Status error = decode_fields(*type.schema, made.held_, bytes)) return *error;
  return made;
}

std::string Value::bytes() const {
  std::string all;
  encode_fields(schema(), held_, all);
  return all;
}

bool operator==(const Value& a, const Value& b) {
  if (a.is_empty() || b.is_empty()) return a.is_empty() == b.is_empty();
  return a.type_ == b.type_ && a.bytes() == b.bytes();
}

}  // namespace trephine::sim
