// bench depth: touch by depth images, the published tables redone.
#include "apps/trephine/bench_parts.h"
#include "tests/bench/depth.h"

namespace trephine::app {

volume::Status bench_depth(const BenchArguments& arguments, Outcome& outcome) {
  Json& json = outcome.json;
  outcome.text =
      "A resting place by a local occupancy map of 2 mm, us (published ones in brackets)\n"
      "resolution  map by the rule  in memory            never stored         error mm\n";
  json["lomi"] = Json::array();
  for (const bench::LomiRow& row : bench::run_lomi_benchmark()) {
    outcome.text +=
        format_text("%7.1f mm  %5d^3 (%2d^3)    %8.2f (%3.0f)       %8.2f (%2.0f)        %.4f\n",
                    row.resolution, row.voxels, row.published_voxels, row.physical_us,
                    row.published_physical_us, row.abstract_us, row.published_abstract_us, row.error);
    json["lomi"].push_back({{"resolution_mm", row.resolution},
                            {"voxels", row.voxels},
                            {"physical_us", row.physical_us},
                            {"abstract_us", row.abstract_us},
                            {"error_rms_mm", row.error}});
  }
  outcome.text +=
      "\nThe proxy's voxel of 0.2 mm divided n times by 27\n"
      "n   0.2/3^n mm (text)   2/3^n mm (table)       us (published)   error mm\n";
  json["levels"] = Json::array();
  for (const bench::LevelRow& row : bench::run_level_benchmark()) {
    outcome.text += format_text("%d   %12.5f   %16.5f   %12.2f (%2.0f)       %.4f\n", row.level, row.step,
                                row.published_step, row.us, row.published_us, row.error);
    json["levels"].push_back(
        {{"level", row.level}, {"step_mm", row.step}, {"us", row.us}, {"error_rms_mm", row.error}});
  }
  outcome.text += "\nModels touched 1 mm deep; published: 60 to 62 us a step, CHAI3D 22 to 430 ms\n";
  json["models"] = Json::array();
  for (const bench::ModelRow& row : bench::run_depth_models(arguments.is_quick)) {
    outcome.text += format_text(
        "%d triangles; images of 20 mm in 100^2 %.2f ms, of all in 0.2 mm %.1f ms\n"
        "  %-8s %15s %12s %12s %12s %12s\n",
        row.triangles, row.clip_ms, row.whole_ms, "method", "made before, ms", "p50, us", "p99.9, us",
        "rms, mm", "worst, mm");
    Json methods = Json::array();
    for (const bench::ModelRow::Method& m : row.methods) {
      outcome.text += format_text("  %-8s %15.1f %12.2f %12.2f %12.5f %12.5f\n", m.name.c_str(), m.ready_ms,
                                  m.p50, m.p999, m.error, m.worst);
      methods.push_back({{"name", m.name},
                         {"made_before_ms", m.ready_ms},
                         {"step_us", {{"p50", m.p50}, {"p999", m.p999}}},
                         {"error_rms_mm", m.error},
                         {"error_worst_mm", m.worst}});
    }
    json["models"].push_back({{"triangles", row.triangles},
                              {"clip_images_ms", row.clip_ms},
                              {"whole_images_ms", row.whole_ms},
                              {"methods", methods}});
  }
  outcome.text +=
      "\nA model that moves at 400 mm/s and swells, drawn 100 times a second around a hand that presses on "
      "it\n"
      "triangles   shape to force, ms: p50   p99     step, us: p50   p99.9     rms, mm   worst, mm   "
      "passed\n";
  json["deforming"] = Json::array();
  for (const bench::DeformRow& row : bench::run_depth_deforming(arguments.is_quick)) {
    outcome.text +=
        format_text("%9d   %23.1f %5.1f   %14.2f %7.2f   %9.5f %11.5f %8ld\n", row.triangles, row.set_p50_ms,
                    row.set_p99_ms, row.step_p50_us, row.step_p999_us, row.error, row.worst, row.passed);
    json["deforming"].push_back({{"triangles", row.triangles},
                                 {"shape_to_force_ms", {{"p50", row.set_p50_ms}, {"p99", row.set_p99_ms}}},
                                 {"step_us", {{"p50", row.step_p50_us}, {"p999", row.step_p999_us}}},
                                 {"error_rms_mm", row.error},
                                 {"error_worst_mm", row.worst},
                                 {"passed", row.passed}});
  }
  return std::nullopt;
}

}  // namespace trephine::app
