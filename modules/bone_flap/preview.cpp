#include "modules/bone_flap/preview.h"

#include <glm/geometric.hpp>

#include "modules/bone_flap/evaluation.h"
#include "sim/api/work.h"

namespace trephine::bone_flap {

using glm::dvec3;

namespace {

/// Preview of a flap, or the reason why the cut would fail.
struct PreviewResult final : sim::JobResult {
  FlapPreview preview;
  double area = 0;
  std::uint64_t hash() const override {
    MixHash mix;
    sim::add_value(mix, preview);
    mix.add(area);
    return mix.value();
  }
};

std::shared_ptr<const sim::JobResult> run_preview(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const PreviewFlap*>(parameters);
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  auto output = std::make_shared<PreviewResult>();
  const SawLimits limits = limits_of({});
  const auto pyramid = make_pyramid(anchors_of(request, input.state), request.distance, bone);
  CutSurface surface;
  LocatedStatus error;
  if (!pyramid)
    error = pyramid.error();
  else
    error = surface.make(pyramid.value(), bone, width_of(request.saw), limits);
  if (!error && surface.wall_mm2(bone, *input.state.undoable.version) <
                    0.01 * surface.wall_mm2(bone, volume::Version(input.anatomy.base)))
    error = LocatedError{k_no_bone_to_cut, pyramid.value().centre_world};
  if (error) {
    output->preview.failed_anchors = anchors_of(request, input.state);
    output->preview.problem = error->reason;
    output->preview.problem_at = error->position_world;
    return output;
  }
  constexpr double k_step = 3;  // mm
  const CutSurface::OuterSurface lid = surface.outer_surface(bone, k_step);
  FlapPreview& preview = output->preview;
  preview.lid_rings = static_cast<std::int64_t>(lid.grid[0].size()) - 1;
  for (std::size_t i = 0; i < lid.rim.size(); ++i) {
    preview.lid.insert(preview.lid.end(), lid.grid[i].begin(), lid.grid[i].end());
    preview.depth.push_back(surface.point_at(surface.lines()[lid.rim[i]], surface.lines()[lid.rim[i]].from));
  }
  output->area = surface.outer_mm2(bone);
  preview.summary = "flap of " + tenths(output->area / 100) + " cm\u00b2";
  FlapState cut;
  cut.width = width_of(request.saw), cut.outline = surface.outline(), cut.floor = surface.floor();
  for (const StructureClearance& clearance : clearances_of(cut, input.forbidden))
    if (clearance.mm < 0 && !clearance.is_stripped())
      preview.summary += "\nthe saw would go " + tenths(-clearance.mm) + " mm into " + clearance.structure;
  return output;
}

/// Returns true if the outline of the request is unchanged.
bool is_current(const void* parameters, const sim::OperationState& input,
                const sim::OperationState& current) {
  const auto& request = *static_cast<const PreviewFlap*>(parameters);
  return !request.outline.empty() || !request.anchors.empty() ||
         input.persistent_of<FlapSettings>()->anchors == current.persistent_of<FlapSettings>()->anchors;
}

void adopt_preview(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  FlapPreview& preview = work.change_result<FlapPreview>();
  preview = static_cast<const PreviewResult&>(result).preview;
  const bool is_valid = preview.problem.empty();
  work.raise_event(FlapPreviewed{static_cast<const PreviewResult&>(result).area,
                                 is_valid ? preview.summary : preview.problem},
                   is_valid ? preview.lid[0] : preview.problem_at);
}

Status check_preview(const void* parameters, const haptics::TouchScene& anatomy) {
  return sim::check_shape_of_pieces(anatomy, static_cast<const PreviewFlap*>(parameters)->item,
                                    "preview-flap item");
}

}  // namespace

void forget_preview(FlapPreview& preview) {
  preview.lid.clear();
  preview.depth.clear();
  preview.summary.clear();
  preview.lid_rings = 0;
}

const sim::JobType& preview_job() {
  static const sim::JobType job{&sim::value_type<PreviewFlap>(), run_preview, is_current, adopt_preview,
                                check_preview};
  return job;
}

sim::Overlay preview_overlay(const FlapPreview& preview) {
  sim::Overlay overlay;
  const auto rings = static_cast<std::size_t>(preview.lid_rings);
  const std::size_t lines = preview.depth.size();
  if (lines == 0 || preview.lid.size() != lines * (rings + 1)) return overlay;  // inconsistent file
  dvec3 deepest(0);
  for (const dvec3& p : preview.depth) deepest += p / static_cast<double>(lines);
  const dvec3 normal = glm::normalize(preview.lid[0] - deepest);
  const auto at = [&](std::size_t line, std::size_t ring) {
    return preview.lid[line % lines * (rings + 1) + ring] + 0.6 * normal;
  };
  for (std::size_t i = 0; i < lines; ++i) {
    for (std::size_t k = 0; k < rings; ++k) {
      overlay.translucent_triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
      if (k > 0) overlay.translucent_triangles.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
    }
    const dvec3 &bottom = preview.depth[i], &next_bottom = preview.depth[(i + 1) % lines];
    overlay.translucent_triangles.push_back({at(i, rings), bottom, at(i + 1, rings)});
    overlay.translucent_triangles.push_back({at(i + 1, rings), bottom, next_bottom});
    overlay.lines.push_back({at(i, rings), at(i + 1, rings)});
    overlay.lines.push_back({bottom, next_bottom});
  }
  overlay.labels.push_back({preview.lid[0] + 4.0 * normal, preview.summary});
  return overlay;
}

}  // namespace trephine::bone_flap
