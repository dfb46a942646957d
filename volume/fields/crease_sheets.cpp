#include "volume/fields/crease_sheets.h"

namespace trephine::volume {

namespace {

/// Returns the lowest lattice point of the brick of v.
glm::ivec3 low_of(const glm::ivec3& v) { return v - (v & (SampleBrick::k_edge - 1)); }

}  // namespace

float CreaseSheets::sample(int sheet, const glm::ivec3& cube, const glm::ivec3& v) const noexcept {
  return brick_of(cube)->sample(sheet, Brick::point_index(v, low_of(cube)));
}

void CreaseSheets::load(int sheet, const glm::ivec3& v, Samples& samples) const noexcept {
  const Brick& brick = *brick_of(v);
  const glm::ivec3 low = low_of(v);
  std::size_t n = 0;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        samples[n++] = brick.sample(sheet, Brick::point_index(v + glm::ivec3(x, y, z), low));
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
