#include "volume/fields/crease_sheets.h"

namespace trephine::volume {

void CreaseSheets::load(int sheet, const glm::ivec3& v, Samples& samples) const noexcept {
  const Brick& brick = *brick_of(v);
  const glm::ivec3 low = v - (v & (SampleBrick::k_edge - 1));
  const Mask below = (Mask{1} << sheet) - 1;
  std::size_t n = 0;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const std::size_t index = Brick::point_index(v + glm::ivec3(x, y, z), low);
        const auto before = static_cast<std::size_t>(std::popcount(brick.points.at(index) & below));
        samples[n++] = brick.samples[brick.first[brick.points.rank(index)] + before];
      }
}

std::size_t CreaseSheets::bytes() const noexcept {
  std::size_t total = table_.size() * sizeof table_[0];
  for (const auto& brick : table_)
    if (brick)
      total += sizeof(Brick) + brick->cubes.bytes() + brick->points.bytes() +
               brick->first.capacity() * sizeof(std::uint32_t) + brick->samples.capacity() * sizeof(float);
  return total;
}

}  // namespace trephine::volume
