#include "sim/api/event.h"

#include <cstring>

namespace trephine::sim {

const Schema& FaultEvent::schema() {
  static constexpr Field fields[] = {field<&FaultEvent::names>("names"),
                                     field<&FaultEvent::is_cleared>("cleared")};
  static constexpr Schema table{"fault", 1, fields};
  return table;
}

const Schema& JobDiscarded::schema() {
  static constexpr Field fields[] = {field<&JobDiscarded::job>("job"),
                                     field<&JobDiscarded::reason>("reason")};
  static constexpr Schema table{"job-discarded", 1, fields};
  return table;
}

const Schema& StepEntered::schema() {
  static constexpr Field fields[] = {field<&StepEntered::step>("step")};
  static constexpr Schema table{"step-entered", 1, fields};
  return table;
}

const Schema& StepRefused::schema() {
  static constexpr Field fields[] = {field<&StepRefused::step>("step"),
                                     field<&StepRefused::request>("request"),
                                     field<&StepRefused::reason>("reason")};
  static constexpr Schema table{"step-refused", 1, fields};
  return table;
}

const Schema& BodyAdded::schema() {
  static constexpr Field fields[] = {field<&BodyAdded::body>("body"),
                                     field<&BodyAdded::size>("size", {.unit = "mm3"})};
  static constexpr Schema table{"body-added", 1, fields};
  return table;
}

const Schema& PieceFreed::schema() {
  static constexpr Field fields[] = {field<&PieceFreed::body>("body"),
                                     field<&PieceFreed::size>("size", {.unit = "mm3"})};
  static constexpr Schema table{"piece-freed", 1, fields};
  return table;
}

const Schema& DebrisFreed::schema() {
  static constexpr Field fields[] = {field<&DebrisFreed::count>("count"),
                                     field<&DebrisFreed::size>("size", {.unit = "mm3"})};
  static constexpr Schema table{"debris-freed", 1, fields};
  return table;
}

void add_bytes(MixHash& hash, std::string_view bytes) noexcept {
  hash.add(std::uint64_t{bytes.size()});
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), sizeof(std::uint64_t)))) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), std::min(bytes.size(), sizeof word));
    hash.add(word);
  }
}

void add_value(MixHash& hash, const Value& value) {
  add_bytes(hash, value.is_empty() ? std::string_view() : value.name());
  add_bytes(hash, value.is_empty() ? std::string() : value.bytes());
}

void Chronicle::add(Event event) {
  hash_.add(event.tick);
  hash_.add(std::uint64_t{event.hand});
  for (int a = 0; a < 3; ++a) hash_.add(event.position_world[a]);
  add_value(hash_, event.value);
  newest_.push_back(std::move(event));
  if (newest_.size() < k_chunk) return;
  full_.push_back(std::make_shared<const std::vector<Event>>(std::exchange(newest_, {})));
}

std::uint64_t Chronicle::hash() const noexcept {
  MixHash result = hash_;
  result.add(undos);
  result.add(redos);
  return result.value();
}

}  // namespace trephine::sim
