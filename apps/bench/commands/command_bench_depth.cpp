// bench depth: touch by depth images, and the published tables reproduced.
#include <algorithm>
#include <filesystem>
#include <utility>

#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/depth.h"
#include "apps/bench/depth_images.h"
#include "apps/view/render_window.h"
#include "data-tools/meshes/mesh_reading.h"

namespace trephine::bench {

using namespace cli;

namespace {

bench::DrawTarget make_draw_target(int pixels) {
  bench::DrawTarget on;
  auto surface = view::make_offscreen(pixels, pixels);
  if (!surface) return on;
  on.window = surface.value()->window();
  on.surface = {surface.value().release(), [](void* one) { delete static_cast<view::DrawSurface*>(one); }};
  return on;
}

/// Returns a value as JSON; null below 0, for a missing peer.
Json json_or_null(double value) { return value < 0 ? Json(nullptr) : Json(value); }

void report_images(bool is_quick, Outcome& outcome) {
  Json& json = outcome.json;
  json["images"] = Json::array();
  for (const bench::ImagesRow& row : bench::run_depth_images(is_quick, make_draw_target))
    json["images"].push_back(
        {{"triangles", row.triangles},
         {"pixels", row.pixels},
         {"ours_ms", row.ours_ms},
         {"embree_tree_ms", json_or_null(row.embree_build_ms)},
         {"embree_first_hits_ms", json_or_null(row.embree_ms)},
         {"gl_first_ms", json_or_null(row.gl_first_ms)},
         {"gl_ms", json_or_null(row.gl_ms)},
         {"embree_different_pixels",
          row.embree_differing_pixels < 0 ? Json(nullptr) : Json(row.embree_differing_pixels)},
         {"gl_different_pixels", row.gl_differing_pixels < 0 ? Json(nullptr) : Json(row.gl_differing_pixels)},
         {"moved_different_pixels", row.moved_differing_pixels}});
  outcome.print("\nSix images of 20 mm around the touch, ms; ours: every layer, without preprocessing");
  outcome.print_table(
      json["images"],
      "triangles = {triangles} | pixels = {pixels}^2 | ours = {ours_ms:.2f} | "
      "Embree: its tree = {embree_tree_ms:.1f} | first hits = {embree_first_hits_ms:.2f} | "
      "pixels that differ = {embree_different_pixels} | VTK's depth buffer: first = {gl_first_ms:.1f} | "
      "then = {gl_ms:.1f} | pixels that differ = {gl_different_pixels} | differ if ours is shifted by a pixel (check) = {moved_different_pixels}");
  Json table = Json::array();
  json["edits"] = Json::array();
  for (const bench::EditRow& row : bench::run_depth_edits(is_quick)) {
    json["edits"].push_back({{"burr_mm", row.burr},
                             {"all_ms", row.all_ms},
                             {"update_us", row.update_us},
                             {"net_ms", row.net_ms},
                             {"triangles", row.triangles},
                             {"embree_tree_ms", json_or_null(row.embree_ms)}});
    table.push_back(json["edits"].back());
    table.back()["ratio"] = row.embree_ms < 0 ? Json() : Json(1e3 * row.embree_ms / row.update_us);
  }
  outcome.print("\nSix images of rows of voxels, updated after a burr removed matter");
  outcome.print_table(table,
                      "burr, mm = {burr_mm:.0f} | whole, ms = {all_ms:.2f} | "
                      "changed rows, us = {update_us:.1f} | the chunk's net, ms = {net_ms:.2f} | "
                      "Embree's tree of this net, ms = {embree_tree_ms:.2f} | ratio = {ratio:.0f}");
  table = Json::array();
  json["frames"] = Json::array();
  for (const bench::FrameRow& row : bench::run_frame_times(is_quick, make_draw_target)) {
    json["frames"].push_back({{"triangles", row.triangles},
                              {"slices", row.samples_across},
                              {"draw_ms", json_or_null(row.draw_ms)},
                              {"voxels_us", row.voxel_touch_us},
                              {"depth_images_ms", json_or_null(row.depth_ms)},
                              {"drawn_again_ms", json_or_null(row.redraw_ms)},
                              {"feedback_ms", json_or_null(row.feedback_ms)}});
    table.push_back(json["frames"].back());
    table.back()["of"] = row.triangles > 0 ? format_text("%d triangles", row.triangles)
                                           : format_text("%d slices", row.samples_across);
  }
  outcome.print(
      "\nA frame of 512^2 pixels, and its haptic cost: OpenHaptics draws again or searches all triangles");
  outcome.print_table(
      table,
      "surface or volume = {of} | drawn, ms = {draw_ms:.1f} | "
      "16 steps of touch on voxels, us = {voxels_us:.1f} | depth images, ms = {depth_images_ms:.2f} | "
      "drawn again and read, ms = {drawn_again_ms:.1f} | search of all triangles, ms = {feedback_ms:.2f}");
}

void report_shell(bool is_quick, Outcome& outcome) {
  Json& rows = outcome.json["shell"] = Json::array();
  for (const bench::DepthShellRow& row : bench::run_depth_shell(is_quick))
    rows.push_back({{"triangles", row.triangles},
                    {"points", row.points},
                    {"pushing", row.pushing},
                    {"mean_us", row.mean_us},
                    {"p999_us", row.p999_us},
                    {"published_us", row.published_us},
                    {"force_error_percent", row.error_percent}});
  outcome.print("\nA tool of points (six degrees of freedom) on a ball, 1 mm deep, pixels of 0.2 mm");
  outcome.print_table(
      rows,
      "triangles = {triangles} | points = {points} | in matter = {pushing:.0f} | mean, us = {mean_us:.0f} | "
      "p99.9, us = {p999_us:.0f} | published mean, us = {published_us:.0f} | "
      "error of the force, % = {force_error_percent:.2f}");
}

void report_falls(bool is_quick, Outcome& outcome) {
  Json& rows = outcome.json["falls"] = Json::array();
  std::string columns = "object = {object} | wall, mm = {wall_mm:.1f} | steps = {steps}";
  for (const bench::FallRow& row : bench::run_depth_falls(is_quick)) {
    Json methods = Json::array();
    for (const auto& m : row.methods) {
      if (rows.empty()) {
        const std::string method = "methods/" + std::to_string(methods.size());
        columns += " | " + m.name + " = {" + method + "/passed} ({" + method + "/steps_in_contact})";
      }
      methods.push_back({{"name", m.name}, {"passed", m.passed}, {"steps_in_contact", m.contact_steps}});
    }
    rows.push_back(
        {{"object", row.object}, {"wall_mm", row.wall}, {"steps", row.steps}, {"methods", methods}});
  }
  outcome.print(
      "\nWalls passed in random steps of up to 1.7 m/s, pixels of 0.2 mm (steps in contact in brackets)");
  outcome.print_table(rows, columns);
}

/// Returns the model of a file, or the models of all files of a folder, with holes closed and scaled to 100
/// mm.
Result<std::vector<bench::BenchModel>> real_models(const std::string& source) {
  namespace fs = std::filesystem;
  std::vector<bench::BenchModel> models;
  if (source.empty()) return models;
  std::vector<fs::path> files{source};
  std::error_code ignored;
  if (fs::is_directory(source, ignored)) {
    files.clear();
    for (const auto& entry : fs::directory_iterator(source, ignored))
      if (entry.is_regular_file() && data_tools::is_polygon_model(entry.path().string()))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    if (files.empty())
      return Error{.what = "no polygonal models",
                   .found = "a folder without models",
                   .expected = "models",
                   .remedy = "pass a folder of .ply, .obj, .stl or .vtk files, or one of these"};
  }
  for (const fs::path& file : files) {
    auto read = data_tools::read_polygon_model(file.string());
    if (!read) return read.error();
    bench::BenchModel model{"model " + std::to_string(models.size() + 1), std::move(read.value().vertices),
                            std::move(read.value().triangles)};
    bench::fit(model, 100);
    if (const int holes = bench::close_holes(model); holes > 0)
      model.name += format_text(" (%d hole%s closed)", holes, holes > 1 ? "s" : "");
    models.push_back(std::move(model));
  }
  return models;
}

}  // namespace

Status bench_depth(const BenchArguments& arguments, Outcome& outcome) {
  Json& json = outcome.json;
  Json table = Json::array();
  json["lomi"] = Json::array();
  for (const bench::LomiRow& row : bench::run_lomi_benchmark()) {
    json["lomi"].push_back({{"resolution_mm", row.resolution},
                            {"voxels", row.voxels},
                            {"physical_us", row.physical_us},
                            {"abstract_us", row.abstract_us},
                            {"error_rms_mm", row.error}});
    table.push_back(json["lomi"].back());
    table.back().update({{"published_voxels", row.published_voxels},
                         {"published_physical_us", row.published_physical_us},
                         {"published_abstract_us", row.published_abstract_us}});
  }
  outcome.print("Resting position by a local occupancy map of 2 mm, us (published figures in brackets)");
  outcome.print_table(table,
                      "resolution, mm = {resolution_mm:.1f} | "
                      "map by Kim's rule = {voxels}^3 ({published_voxels}^3) | "
                      "in memory = {physical_us:.2f} ({published_physical_us:.0f}) | "
                      "never stored = {abstract_us:.2f} ({published_abstract_us:.0f}) | "
                      "error, mm = {error_rms_mm:.4f}");
  table = Json::array();
  json["levels"] = Json::array();
  for (const bench::LevelRow& row : bench::run_level_benchmark()) {
    json["levels"].push_back(
        {{"level", row.level}, {"step_mm", row.step}, {"us", row.us}, {"error_rms_mm", row.error}});
    table.push_back(json["levels"].back());
    table.back().update({{"published_step_mm", row.published_step}, {"published_us", row.published_us}});
  }
  outcome.print(
      "\nThe proxy's voxel of 0.2 mm divided n times by 27; Kim et al. 2009 give two sizes, in text and table");
  outcome.print_table(table,
                      "n = {level} | 0.2/3^n mm (text) = {step_mm:.5f} | "
                      "2/3^n mm (table) = {published_step_mm:.5f} | "
                      "us (published) = {us:.2f} ({published_us:.0f}) | error, mm = {error_rms_mm:.4f}");
  report_shell(arguments.is_quick, outcome);
  const auto real = real_models(arguments.source);
  if (!real) return real.error();
  outcome.print(
      "\nModels touched 1 mm deep; Kim et al. 2009: 60 to 62 us per step; CHAI3D's tree takes 22 to 430 ms");
  json["models"] = Json::array();
  for (const bench::ModelRow& row : bench::run_depth_models(arguments.is_quick, real.value())) {
    Json methods = Json::array();
    for (const bench::ModelRow::Method& m : row.methods)
      methods.push_back({{"name", m.name},
                         {"preparation_ms", m.ready_ms},
                         {"step_us", {{"p50", m.p50}, {"p999", m.p999}}},
                         {"error_rms_mm", m.error},
                         {"error_worst_mm", m.worst}});
    json["models"].push_back({{"name", row.name},
                              {"triangles", row.triangles},
                              {"clip_images_ms", row.clip_ms},
                              {"whole_images_ms", row.complete_ms},
                              {"methods", methods}});
    outcome.print(
        "{name}, {triangles} triangles; three images of 20 mm with 100^2 pixels: {clip_images_ms:.2f} ms; of the whole "
        "model with pixels of 0.2 mm: {whole_images_ms:.1f} ms",
        json["models"].back());
    outcome.print_table(
        methods,
        "method = {name} | prepared, ms = {preparation_ms:.1f} | p50, us = {step_us/p50:.2f} | "
        "p99.9, us = {step_us/p999:.2f} | rms, mm = {error_rms_mm:.5f} | "
        "worst, mm = {error_worst_mm:.5f}");
  }
  json["deforming"] = Json::array();
  for (const bench::DeformRow& row : bench::run_depth_deforming(arguments.is_quick))
    json["deforming"].push_back({{"triangles", row.triangles},
                                 {"shape_to_force_ms", {{"p50", row.set_p50_ms}, {"p99", row.set_p99_ms}}},
                                 {"step_us", {{"p50", row.step_p50_us}, {"p999", row.step_p999_us}}},
                                 {"error_rms_mm", row.error},
                                 {"error_worst_mm", row.worst},
                                 {"passed", row.passed}});
  outcome.print(
      "\nA model that moves at 400 mm/s and swells, drawn 100 times per second around a hand that presses on "
      "it");
  outcome.print_table(json["deforming"],
                      "triangles = {triangles} | shape to force, ms: p50 = {shape_to_force_ms/p50:.1f} | "
                      "p99 = {shape_to_force_ms/p99:.1f} | step, us: p50 = {step_us/p50:.2f} | "
                      "p99.9 = {step_us/p999:.2f} | rms, mm = {error_rms_mm:.5f} | "
                      "worst, mm = {error_worst_mm:.5f} | passed = {passed}");
  report_falls(arguments.is_quick, outcome);
  report_images(arguments.is_quick, outcome);
  return std::nullopt;
}

}  // namespace trephine::bench
