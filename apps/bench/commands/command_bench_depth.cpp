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

bench::DrawOn draw_on(int pixels) {
  bench::DrawOn on;
  auto surface = view::make_offscreen(pixels, pixels);
  if (!surface) return on;
  on.window = surface.value()->window();
  on.surface = {surface.value().release(), [](void* one) { delete static_cast<view::DrawSurface*>(one); }};
  return on;
}

/// Text of a value; "-" below 0, for a missing peer.
std::string cell(double value, const char* form) { return value < 0 ? "-" : format_text(form, value); }
Json put(double value) { return value < 0 ? Json(nullptr) : Json(value); }

void report_images(bool is_quick, Outcome& outcome) {
  Json& json = outcome.json;
  outcome.text +=
      "\nSix images of 20 mm around the touch, ms; ours: every layer, without preprocessing\n"
      "triangles   pixels    ours    Embree: its tree   first hits   apart    VTK's depth buffer: first     "
      "then   apart   (ours moved by a pixel)\n";
  json["images"] = Json::array();
  for (const bench::ImagesRow& row : bench::run_depth_images(is_quick, draw_on)) {
    outcome.text += format_text(
        "%9d   %4d^2  %7.2f   %15s   %10s   %5s   %25s   %6s   %5s   (%ld)\n", row.triangles, row.pixels,
        row.ours_ms, cell(row.embree_build_ms, "%.1f").c_str(), cell(row.embree_ms, "%.2f").c_str(),
        cell(static_cast<double>(row.embree_apart), "%.0f").c_str(), cell(row.gl_first_ms, "%.1f").c_str(),
        cell(row.gl_ms, "%.1f").c_str(), cell(static_cast<double>(row.gl_apart), "%.0f").c_str(),
        row.moved_apart);
    json["images"].push_back({{"triangles", row.triangles},
                              {"pixels", row.pixels},
                              {"ours_ms", row.ours_ms},
                              {"embree_tree_ms", put(row.embree_build_ms)},
                              {"embree_first_hits_ms", put(row.embree_ms)},
                              {"gl_first_ms", put(row.gl_first_ms)},
                              {"gl_ms", put(row.gl_ms)},
                              {"embree_apart", row.embree_apart < 0 ? Json(nullptr) : Json(row.embree_apart)},
                              {"gl_apart", row.gl_apart < 0 ? Json(nullptr) : Json(row.gl_apart)},
                              {"moved_apart", row.moved_apart}});
  }
  outcome.text +=
      "\nSix images of 256^2 rows of voxels after a burr touched them\n"
      "burr, mm   whole, ms          changed rows, us   the chunk's net, ms   Embree's tree of it, ms   "
      "ratio\n";
  json["edits"] = Json::array();
  for (const bench::EditRow& row : bench::run_depth_edits(is_quick)) {
    outcome.text +=
        format_text("%8.0f   %12.2f   %20.1f   %19.2f   %23s   %s\n", row.burr, row.all_ms, row.update_us,
                    row.net_ms, cell(row.embree_ms, "%.2f").c_str(),
                    cell(row.embree_ms < 0 ? -1 : 1e3 * row.embree_ms / row.update_us, "%.0f").c_str());
    json["edits"].push_back({{"burr_mm", row.burr},
                             {"all_ms", row.all_ms},
                             {"update_us", row.update_us},
                             {"net_ms", row.net_ms},
                             {"triangles", row.triangles},
                             {"embree_tree_ms", put(row.embree_ms)}});
  }
  outcome.text +=
      "\nA frame of 512^2 pixels, and its haptic cost: OpenHaptics draws again or searches all "
      "triangles\n"
      "surface or volume     drawn, ms   voxels touched, us   depth images, ms   drawn again and read, ms   "
      "all triangles, ms\n";
  json["frames"] = Json::array();
  for (const bench::FrameRow& row : bench::run_frame_times(is_quick, draw_on)) {
    const std::string what =
        row.triangles > 0 ? format_text("%d triangles", row.triangles) : format_text("%d slices", row.slices);
    outcome.text +=
        format_text("%-18s   %10s   %18.1f   %16s   %24s   %17s\n", what.c_str(),
                    cell(row.draw_ms, "%.1f").c_str(), row.voxel_touch_us, cell(row.depth_ms, "%.2f").c_str(),
                    cell(row.redraw_ms, "%.1f").c_str(), cell(row.feedback_ms, "%.2f").c_str());
    json["frames"].push_back({{"triangles", row.triangles},
                              {"slices", row.slices},
                              {"draw_ms", put(row.draw_ms)},
                              {"voxels_us", row.voxel_touch_us},
                              {"depth_images_ms", put(row.depth_ms)},
                              {"drawn_again_ms", put(row.redraw_ms)},
                              {"feedback_ms", put(row.feedback_ms)}});
  }
}

void report_falls(bool is_quick, Outcome& outcome) {
  outcome.text +=
      "\nWalls passed in steps of up to 1 m/s, pixels of 0.2 mm (steps in contact in brackets)\n"
      "object      wall, mm     steps   ";
  outcome.json["falls"] = Json::array();
  bool is_first = true;
  for (const bench::FallRow& row : bench::run_depth_falls(is_quick)) {
    if (std::exchange(is_first, false)) {
      for (const auto& m : row.methods) outcome.text += format_text("%20s", m.name.c_str());
      outcome.text += "\n";
    }
    outcome.text += format_text("%-10s %9.1f %9ld   ", row.object.c_str(), row.wall, row.steps);
    Json methods = Json::array();
    for (const auto& m : row.methods) {
      outcome.text += format_text("%20s", format_text("%ld (%ld)", m.passed, m.touched).c_str());
      methods.push_back({{"name", m.name}, {"passed", m.passed}, {"steps_in_contact", m.touched}});
    }
    outcome.text += "\n";
    outcome.json["falls"].push_back(
        {{"thing", row.object}, {"wall_mm", row.wall}, {"steps", row.steps}, {"methods", methods}});
  }
}

/// Models of a file or of all files of a folder, closed and scaled to 100 mm.
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
  outcome.text =
      "Resting position by a local occupancy map of 2 mm, us (published figures in brackets)\n"
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
  const auto real = real_models(arguments.source);
  if (!real) return real.error();
  outcome.text += "\nModels touched 1 mm deep; published: 60 to 62 us per step, CHAI3D 22 to 430 ms\n";
  json["models"] = Json::array();
  for (const bench::ModelRow& row : bench::run_depth_models(arguments.is_quick, real.value())) {
    outcome.text += format_text(
        "%s, %d triangles; images of 20 mm in 100^2 %.2f ms, of all in 0.2 mm %.1f ms\n"
        "  %-10s %15s %12s %12s %12s %12s\n",
        row.name.c_str(), row.triangles, row.clip_ms, row.complete_ms, "method", "prepared, ms", "p50, us",
        "p99.9, us", "rms, mm", "worst, mm");
    Json methods = Json::array();
    for (const bench::ModelRow::Method& m : row.methods) {
      outcome.text += format_text("  %-10s %15.1f %12.2f %12.2f %12.5f %12.5f\n", m.name.c_str(), m.ready_ms,
                                  m.p50, m.p999, m.error, m.worst);
      methods.push_back({{"name", m.name},
                         {"made_before_ms", m.ready_ms},
                         {"step_us", {{"p50", m.p50}, {"p999", m.p999}}},
                         {"error_rms_mm", m.error},
                         {"error_worst_mm", m.worst}});
    }
    json["models"].push_back({{"name", row.name},
                              {"triangles", row.triangles},
                              {"clip_images_ms", row.clip_ms},
                              {"whole_images_ms", row.complete_ms},
                              {"methods", methods}});
  }
  outcome.text +=
      "\nA model that moves at 400 mm/s and swells, drawn 100 times per second around a hand that presses on "
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
  report_falls(arguments.is_quick, outcome);
  report_images(arguments.is_quick, outcome);
  return std::nullopt;
}

}  // namespace trephine::bench
