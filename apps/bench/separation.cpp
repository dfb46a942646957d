#include "apps/bench/separation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "apps/bench/measure.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/cuts/removal.h"
#include "volume/cuts/separation.h"
#include "volume/cuts/solid_parts.h"

namespace trephine::bench {

namespace {

SeparationRow measure(double voxel, double burr) {
  constexpr int k_strokes = 60;
  constexpr double k_smallest = 50;  // mm3
  data_tools::PhantomOptions options;
  options.spacing_mm = glm::dvec3(voxel);
  const auto scan = std::make_shared<volume::Volume>(data_tools::make_phantom("head", options).value());
  const volume::Shape bone{"bone", 300};
  const volume::Field field(*scan, bone);
  const volume::Occupancy bits = volume::Occupancy::build(*scan, bone);
  const auto lattice = volume::CutLattice::for_burr(*scan, burr).value();
  volume::RemovalEditor editor(std::make_shared<const volume::Version>(scan, lattice), {field});
  SeparationRow row{voxel, burr, lattice.per_voxel().x};
  std::vector<double> times;
  const double sample = lattice.frame().voxel_mm3();
  for (int i = 0; i < k_strokes; ++i) {
    const auto before = editor.freeze();
    // A ring of 40 mm over the left frontal lobe, through all of the vault.
    const auto along = [](double step) {
      const double a = 2 * 3.14159265358979323846 * step / k_strokes;
      return glm::normalize(glm::dvec3(0.31 + 0.26 * std::cos(a), -0.13 + 0.26 * std::sin(a), 1));
    };
    for (double r = 125; r > 60; r -= 0.4 * burr)
      editor.remove({r * along(i), r * along(i + 1), 0.5 * burr, false});
    const auto after = editor.freeze();
    const auto begin = Clock::now();
    const volume::Separation result =
        volume::detect_detachment(field, bits, *before, *after,
                                  {.min_samples = static_cast<std::int64_t>(std::ceil(k_smallest / sample))});
    times.push_back(1e3 * seconds_since(begin));
    ++row.strokes;
    row.held += result.kind == volume::Separation::Kind::connected;
    row.detached += result.kind == volume::Separation::Kind::detached;
    row.pending += result.kind == volume::Separation::Kind::pending;
    const auto whole = Clock::now();
    const volume::SolidParts parts(field, bits, *after);
    row.complete_ms = 1e3 * seconds_since(whole);
    const bool is_loose =
        std::any_of(parts.parts().begin(), parts.parts().end(), [&](const volume::SolidParts::Part& part) {
          return part.is_detached && static_cast<double>(part.samples) * sample >= k_smallest;
        });
    row.wrong += result.kind != volume::Separation::Kind::pending &&
                 is_loose != (result.kind == volume::Separation::Kind::detached);
    if (is_loose) break;
  }
  std::sort(times.begin(), times.end());
  row.p50_ms = times[times.size() / 2];
  row.p99_ms = times[(times.size() * 99 + 99) / 100 - 1];
  return row;
}

}  // namespace

std::vector<SeparationRow> run_separation_benchmark() {
  return {measure(0.6, 6), measure(1, 10), measure(0.6, 2.3), measure(1, 4.5)};
}

}  // namespace trephine::bench
