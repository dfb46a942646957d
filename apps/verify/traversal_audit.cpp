#include "apps/verify/traversal_audit.h"

#include <cmath>
#include <cstdio>
#include <mutex>
#include <thread>
#include <vector>

#include "apps/verify/exact_traversal.h"
#include "volume/scan/traversal.h"

namespace trephine::verify {

namespace {

void audit_ray(std::uint64_t number, std::uint64_t seed, TraversalAudit& audit) {
  const AdversarialRay ray = adversarial_ray(number, seed);
  const glm::dvec3 start(ray.start[0], ray.start[1], ray.start[2]), end(ray.end[0], ray.end[1], ray.end[2]);
  const std::array<int, 3> low{0, 0, 0}, high{7, 5, 6};
  const std::vector<ExactVisit> truth = exact_traversal(ray.start, ray.end, low, high);
  const volume::VoxelBox box{{0, 0, 0}, {7, 5, 6}};
  std::vector<volume::VoxelVisit> forward, backward;
  volume::traverse(start, end, box, [&](const volume::VoxelVisit& v) { return forward.push_back(v), true; });
  volume::traverse(end, start, box, [&](const volume::VoxelVisit& v) { return backward.push_back(v), true; });

  bool is_same = forward.size() == truth.size();
  for (std::size_t i = 0; is_same && i < truth.size(); ++i) {
    const auto& s = forward[i];
    const auto& t = truth[i];
    for (int a = 0; a < 3; ++a) is_same = is_same && s.voxel[a] == t.voxel[static_cast<std::size_t>(a)];
    is_same = is_same && s.face.axis == t.axis && s.face.step == t.step && s.t_exit >= s.t_enter;
    if (i > 0) is_same = is_same && s.t_enter >= forward[i - 1].t_enter && s.t_enter == forward[i - 1].t_exit;
    const double error =
        static_cast<double>(std::fabs(static_cast<long double>(s.t_enter) - t.t_enter)) / 0x1p-52;
    audit.worst_t_ulp = std::max(audit.worst_t_ulp, error);
  }
  bool is_same_back = backward.size() == forward.size();
  for (std::size_t i = 0; is_same_back && i < forward.size(); ++i)
    is_same_back = forward[i].voxel == backward[forward.size() - 1 - i].voxel;
  ++audit.rays;
  audit.voxels += truth.size();
  audit.mismatches += is_same ? 0 : 1;
  audit.reverse_mismatches += is_same_back ? 0 : 1;
  if ((!is_same || !is_same_back) && audit.first_mismatch.empty()) {
    char text[400];
    std::snprintf(text, sizeof text, "ray %llu (%s): %a %a %a -> %a %a %a, %zu voxels, expected %zu",
                  static_cast<unsigned long long>(number),
                  ray_family_name(static_cast<int>(number % k_ray_families)), start.x, start.y, start.z,
                  end.x, end.y, end.z, forward.size(), truth.size());
    audit.first_mismatch = text;
  }
}

}  // namespace

TraversalAudit audit_traversal(std::uint64_t first, std::uint64_t count, std::uint64_t seed, int threads) {
  const auto workers = threads > 0 ? static_cast<std::uint64_t>(threads)
                                   : std::max<std::uint64_t>(1, std::thread::hardware_concurrency());
  TraversalAudit total;
  std::mutex lock;
  {
    std::vector<std::jthread> pool;
    for (std::uint64_t w = 0; w < workers; ++w)
      pool.emplace_back([&, w] {
        TraversalAudit part;
        for (std::uint64_t n = first + w; n < first + count; n += workers) audit_ray(n, seed, part);
        const std::lock_guard guard(lock);
        total.rays += part.rays;
        total.voxels += part.voxels;
        total.mismatches += part.mismatches;
        total.reverse_mismatches += part.reverse_mismatches;
        total.worst_t_ulp = std::max(total.worst_t_ulp, part.worst_t_ulp);
        if (total.first_mismatch.empty()) total.first_mismatch = part.first_mismatch;
      });
  }
  return total;
}

}  // namespace trephine::verify
