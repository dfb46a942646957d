#include "sim/api/value.h"

namespace trephine::sim {

Result<Value> Value::from_bytes(const ValueType& type, std::string_view bytes) {
  Value result = of(type);
  if (Status error = decode_fields(*type.schema, result.object_, bytes)) return *error;
  return result;
}

std::string Value::bytes() const {
  std::string result;
  encode_fields(schema(), object_, result);
  return result;
}

bool operator==(const Value& a, const Value& b) {
  if (a.is_empty() || b.is_empty()) return a.is_empty() == b.is_empty();
  return a.type_ == b.type_ && a.bytes() == b.bytes();
}

}  // namespace trephine::sim
