// TraversalAudit: compares the traversal of volume/ with the exact judge on adversarial rays.
#pragma once

#include <cstdint>
#include <string>

namespace trephine::verify {

struct TraversalAudit {
  std::uint64_t rays = 0;
  std::uint64_t voxels = 0;
  std::uint64_t mismatches = 0;          ///< rays with a wrong voxel, face or order
  std::uint64_t reverse_mismatches = 0;  ///< rays that visit other voxels, or another order, if reversed
  double worst_t_ulp = 0;                ///< largest error of an entry parameter, in units of 2^-52
  std::string first_mismatch;            ///< family, coordinates and numbers of voxels
};

/// Audits rays first .. first + count - 1 of `seed`. threads 0 = all cores.
TraversalAudit audit_traversal(std::uint64_t first, std::uint64_t count, std::uint64_t seed, int threads = 0);

}  // namespace trephine::verify
