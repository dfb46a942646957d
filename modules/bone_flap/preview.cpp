#include "modules/bone_flap/preview.h"

#include <glm/geometric.hpp>

#include "modules/bone_flap/evaluation.h"
#include "sim/work.h"

namespace trephine::bone_flap {

using glm::dvec3;

namespace {

/// Preview of a flap, or the reason of its failure.
struct SeenFlap final : sim::JobResult {
  FlapSettings seen;  ///< of it what a preview shows
  double area = 0;
  std::uint64_t hash() const override {
    volume::MixHash all;
    sim::add_value(all, seen);
    all.add(area);
    return all.value();
  }
};

std::shared_ptr<const sim::JobResult> run_preview(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const PreviewFlap*>(parameters);
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  const FlapSettings& drawn = *input.state.settings_of<FlapSettings>();
  auto made = std::make_shared<SeenFlap>();
  const Depth depth = depth_of({});
  Pyramid pyramid;
  Sheet sheet;
  Trouble trouble;
  bool is_any = make_pyramid(anchors_of(request, drawn), request.distance, bone, pyramid, trouble) &&
                sheet.make(pyramid, bone, width_of(request.saw), depth, trouble);
  if (is_any && sheet.wall_mm2(bone, *input.state.world.version) <
                    0.01 * sheet.wall_mm2(bone, volume::Version(input.anatomy.base))) {
    trouble = {"nothing is there to be cut: it was cut before", pyramid.centre_world};
    is_any = false;
  }
  if (!is_any) {
    made->seen.trouble = trouble.why;
    made->seen.trouble_at = trouble.at_world;
    return made;
  }
  constexpr double k_step = 3;  // mm
  const Sheet::Lid lid = sheet.lid(bone, k_step);
  FlapSettings& seen = made->seen;
  seen.lid_rings = static_cast<std::int64_t>(lid.grid[0].size()) - 1;
  for (std::size_t i = 0; i < lid.rim.size(); ++i) {
    seen.lid.insert(seen.lid.end(), lid.grid[i].begin(), lid.grid[i].end());
    seen.depth.push_back(sheet.place(sheet.lines()[lid.rim[i]], sheet.lines()[lid.rim[i]].from));
  }
  made->area = sheet.outer_mm2(bone);
  seen.preview = "flap of " + whole(made->area) + " mm\u00b2";
  FlapWorld saw;
  saw.width = width_of(request.saw), saw.outline = sheet.outline(), saw.floor = sheet.floor();
  for (const Near& one : nearness_of(saw, input.forbidden))
    if (one.mm < 0 && !one.is_stripped())
      seen.preview += "\nthe saw would go " + tenths(-one.mm) + " mm into " + one.structure;
  return made;
}

/// It shows the outline that was asked about.
bool is_of_outline(const void* parameters, const sim::OperationState& input, const sim::OperationState& now) {
  return !static_cast<const PreviewFlap*>(parameters)->anchors.empty() ||
         input.settings_of<FlapSettings>()->anchors == now.settings_of<FlapSettings>()->anchors;
}

void adopt_preview(const void* parameters, const sim::JobResult& result, sim::ModuleWork& work) {
  const FlapSettings& seen = static_cast<const SeenFlap&>(result).seen;
  FlapSettings& settings = work.change_settings<FlapSettings>();
  const auto& request = *static_cast<const PreviewFlap*>(parameters);
  const std::vector<dvec3> asked = anchors_of(request, settings);
  settings.tried = seen.trouble.empty() ? std::vector<dvec3>() : asked;
  settings.trouble = seen.trouble;
  settings.trouble_at = seen.trouble_at;
  settings.lid = seen.lid;
  settings.lid_rings = seen.lid_rings;
  settings.depth = seen.depth;
  settings.preview = seen.preview;
  const bool is_any = seen.trouble.empty();
  work.raise_event(FlapSeen{static_cast<const SeenFlap&>(result).area, is_any ? seen.preview : seen.trouble},
                   is_any ? seen.lid[0] : seen.trouble_at);
}

volume::Status check_preview(const void* parameters, const haptics::TouchScene& anatomy) {
  return sim::check_shape_of_pieces(anatomy, static_cast<const PreviewFlap*>(parameters)->item,
                                    "preview-flap item");
}

}  // namespace

void forget_preview(FlapSettings& settings) {
  settings.lid.clear();
  settings.depth.clear();
  settings.preview.clear();
  settings.lid_rings = 0;
}

const sim::JobType& preview_job() {
  static const sim::JobType job{&sim::value_type<PreviewFlap>(), run_preview, is_of_outline, adopt_preview,
                                check_preview};
  return job;
}

sim::Overlay look_of_preview(const FlapSettings& shown) {
  sim::Overlay preview;
  const auto rings = static_cast<std::size_t>(shown.lid_rings);
  const std::size_t lines = shown.depth.size();
  if (lines == 0 || shown.lid.size() != lines * (rings + 1)) return preview;  // a file that was tampered with
  dvec3 deepest(0);
  for (const dvec3& p : shown.depth) deepest += p / static_cast<double>(lines);
  const dvec3 out = glm::normalize(shown.lid[0] - deepest);
  const auto at = [&](std::size_t line, std::size_t ring) {
    return shown.lid[line % lines * (rings + 1) + ring] + 0.6 * out;
  };
  for (std::size_t i = 0; i < lines; ++i) {
    for (std::size_t k = 0; k < rings; ++k) {
      preview.skin.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
      if (k > 0) preview.skin.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
    }
    const dvec3 &deep = shown.depth[i], &next = shown.depth[(i + 1) % lines];
    preview.skin.push_back({at(i, rings), deep, at(i + 1, rings)});
    preview.skin.push_back({at(i + 1, rings), deep, next});
    preview.lines.push_back({at(i, rings), at(i + 1, rings)});
    preview.lines.push_back({deep, next});
  }
  preview.labels.push_back({shown.lid[0] + 4.0 * out, shown.preview});
  return preview;
}

}  // namespace trephine::bone_flap
