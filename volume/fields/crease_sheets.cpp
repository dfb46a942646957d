#include "volume/fields/crease_sheets.h"

namespace trephine::volume {

std::size_t CreaseSheets::bytes() const noexcept {
  std::size_t total = table_.size() * sizeof table_[0];
  for (const auto& brick : table_)
    if (brick)
      total += sizeof(Brick) + brick->cubes.size() * sizeof(Cube) + brick->samples.size() * sizeof(Samples);
  return total;
}

}  // namespace trephine::volume
