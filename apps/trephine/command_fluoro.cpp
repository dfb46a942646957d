// fluoro: an X-ray of a scan, or of a moment of a session, as a C-arm makes it.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/imaging/xray_panel.h"
#include "apps/trephine/commands.h"
#include "apps/trephine/surface_image.h"
#include "apps/view/slice_picture.h"
#include "apps/workbench/moment.h"
#include "data-tools/atomic_file.h"
#include "data-tools/output_set.h"
#include "data-tools/xray_file.h"
#include "modules/fluoroscopy/detector.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "modules/fluoroscopy/volume_xray.h"
#include "volume/image_plane.h"

namespace trephine::app {

using fluoroscopy::Border;
using fluoroscopy::CArm;
using fluoroscopy::View;
using glm::dvec2;
using glm::dvec3;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

enum class Way : std::uint8_t { interpolated, exact, surface };
constexpr std::string_view k_ways[] = {"interpolated", "exact", "surface"};
constexpr std::string_view k_metals[] = {"titanium", "steel"};

struct FluoroArguments {
  workbench::MomentChoice moment;
  std::string view, isocentre, collimate, pose, output, dicom, sums;
  ThingArguments things;
  std::optional<double> primary, secondary, to_detector, to_patient, pixel;
  std::optional<double> energy, shot;
  int size = 0, rays = 1;
  std::uint8_t way = 0, metal = 0;
  double photons = 0, blur = 0, edge = 0.3;
  std::uint64_t seed = 1;
  bool is_film = false, is_linear = false, is_beside = false;
};

/// The session goes to a shot of it: where the C-arm stood.
Result<fluoroscopy::XrayTaken> go_to_shot(workbench::Moment& moment, int number) {
  if (!moment.session)
    return Error{"a scan has no shots", "shot", std::to_string(number), "a recorded session", ""};
  std::int64_t count = 0;
  const sim::Chronicle& all = moment.state()->chronicle;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto* one = all[i].what.as<fluoroscopy::XrayTaken>();
    if (one == nullptr) continue;
    ++count;
    if (one->number != number) continue;
    const fluoroscopy::XrayTaken taken = *one;
    if (Status error = workbench::go_to(moment, all[i].tick)) return *error;
    return taken;
  }
  return Error{"there is no such shot", "shot", std::to_string(number),
               count > 0 ? format_text("1 to %d", static_cast<int>(count)) : "a session with shots", ""};
}

/// Position of the C-arm: of a shot, of a file, by name, by numbers; the last one counts.
Result<CArm> arm_of(const FluoroArguments& a, const workbench::Moment& moment, const CArm* shot) {
  CArm arm;
  const glm::dvec3 middle = 0.5 * (glm::dvec3(moment.scan->size) - 1.0);
  arm.isocentre = moment.scan->frame.world_from_volume(middle);
  if (shot != nullptr) {
    arm = *shot;
  } else if (moment.session) {
    const auto* state = moment.state()->settings_of<fluoroscopy::FluoroscopyState>();
    if (state != nullptr && state->is_placed) arm = *state;
  }
  if (!a.pose.empty()) {
    const auto pose = data_tools::read_xray_pose(a.pose);
    if (!pose) return pose.error();
    const data_tools::XrayPose& p = pose.value();
    if (!p.primary && !p.secondary)
      return Error{"the image does not say where its C-arm stood", "pose", "no positioner angles",
                   "(0018,1510) and (0018,1511)", "say them: --primary, --secondary"};
    arm.primary = p.primary.value_or(0), arm.secondary = p.secondary.value_or(0);
    arm.to_detector = p.to_detector.value_or(arm.to_detector);
    arm.to_patient = p.to_patient.value_or(arm.to_patient);
    arm.isocentre = p.isocentre.value_or(arm.isocentre);
    if (p.pixel && p.columns > 0 && p.rows > 0)
      arm.pixel = *p.pixel, arm.columns = p.columns, arm.rows = p.rows;
  }
  if (!a.view.empty()) fluoroscopy::set_preset(arm, a.view);
  arm.primary = a.primary.value_or(arm.primary), arm.secondary = a.secondary.value_or(arm.secondary);
  arm.to_detector = a.to_detector.value_or(arm.to_detector);
  arm.to_patient = a.to_patient.value_or(arm.to_patient);
  if (!a.isocentre.empty()) {
    const auto place = parse_place(a.isocentre, "--isocentre");
    if (!place) return place.error();
    arm.isocentre = place.value();
  }
  if (a.size > 0) {  // the same detector in other pixels
    arm.pixel *= static_cast<double>(arm.columns) / a.size;
    arm.rows = std::max<std::int64_t>(
        1, std::llround(static_cast<double>(arm.rows) * a.size / static_cast<double>(arm.columns)));
    arm.columns = a.size;
  }
  if (a.pixel) arm.pixel = *a.pixel;
  if (!a.collimate.empty()) {
    char* end = nullptr;
    arm.width = std::strtod(a.collimate.c_str(), &end);
    arm.height = *end == ',' ? std::strtod(end + 1, &end) : -1;
    if (*end != 0 || !(arm.width > 0 && arm.height > 0))
      return Error{"this is no field", "--collimate", a.collimate,
                   "width,height in mm on the detector: 120,80", ""};
  }
  if (Status error = fluoroscopy::check(arm)) return *error;
  return arm;
}

/// May some ray meet the scan? By the box of where its corners are seen.
bool sees(const View& view, const volume::Volume& scan) {
  dvec2 low(1e300), high(-1e300);
  for (const dvec3& corner : volume::corners_world(scan.frame, glm::ivec3(0), scan.size - 1)) {
    const auto seen = view.seen(corner);
    if (!seen) return true;  // around the source
    low = glm::min(low, *seen), high = glm::max(high, *seen);
  }
  return high.x >= view.open.column_low && high.y >= view.open.row_low && low.x < view.open.column_high &&
         low.y < view.open.row_high;
}

Json add_plan(imaging::Panel& panel, const View& view, const CArm& arm, const workbench::Moment& moment) {
  Json told = Json::array();
  if (!moment.plan) return told;
  const auto pixel = [&](const dvec3& p) {
    const auto at = view.seen(p);
    return at ? Json{at->x, at->y} : Json();
  };
  for (const data_tools::CaseTrajectory& t : moment.plan->trajectories) {
    const auto from = imaging::in_panel(view, arm.pixel, t.entry_world),
               to = imaging::in_panel(view, arm.pixel, t.target_world);
    if (from && to) panel.lines.push_back({{*from, *to}, {90, 220, 255}, false, "plan"});
    told.push_back({{"name", t.name},
                    {"entry_world_mm", json_of(t.entry_world)},
                    {"target_world_mm", json_of(t.target_world)},
                    {"entry_pixel", pixel(t.entry_world)},
                    {"target_pixel", pixel(t.target_world)}});
  }
  for (const data_tools::CaseLandmark& l : moment.plan->landmarks) {
    const auto at = imaging::in_panel(view, arm.pixel, l.place_world);
    const double r = 0.006 * arm.pixel * view.columns;
    if (at)
      panel.lines.push_back({{*at - dvec2(r, 0), *at + dvec2(0, r), *at + dvec2(r, 0), *at - dvec2(0, r)},
                             {90, 220, 255},
                             true,
                             "plan"});
    told.push_back({{"name", l.name}, {"pixel", pixel(l.place_world)}});
  }
  return told;
}

/// Line integrals as they are, float, one slice: -ln of what passes, the detector's middle at the origin.
Status write_sums(const std::string& path, std::span<const double> sums, const View& view, double pixel) {
  std::string text = format_text(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = "
      "False\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = %.17g %.17g 0\nElementSpacing = %.17g %.17g 1\n"
      "DimSize = %d %d 1\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n",
      -0.5 * pixel * (view.columns - 1), -0.5 * pixel * (view.rows - 1), pixel, pixel, view.columns,
      view.rows);
  for (const double sum : sums) {
    const auto one = static_cast<float>(sum);
    text.append(reinterpret_cast<const char*>(&one), sizeof one);
  }
  return data_tools::write_file_atomically(path, text);
}

Status write_dicom(const std::string& path, const std::vector<float>& received, const View& view,
                   const CArm& arm, const fluoroscopy::Shoot& shot, const fluoroscopy::Dose& dose,
                   std::uint64_t scan_hash) {
  data_tools::XrayToWrite xray;
  xray.pose = {arm.primary, arm.secondary, arm.to_detector, arm.to_patient,
               arm.pixel,   arm.isocentre, view.columns,    view.rows};
  std::vector<std::uint16_t> pixels, open;
  for (const float v : received)
    pixels.push_back(static_cast<std::uint16_t>(
        std::clamp(65535 - data_tools::XrayToWrite::k_log_steps * fluoroscopy::weakening(v), 0.0, 65535.0)));
  for (int row = view.open.row_low; row < view.open.row_high; ++row)
    for (int column = view.open.column_low; column < view.open.column_high; ++column)
      open.push_back(pixels[static_cast<std::size_t>(column) +
                            static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(row)]);
  std::sort(open.begin(), open.end());
  xray.darkest = open[open.size() / 200], xray.brightest = open[open.size() - 1 - open.size() / 200];
  xray.pixels = pixels;
  xray.column_low = view.open.column_low, xray.column_high = view.open.column_high;
  xray.row_low = view.open.row_low, xray.row_high = view.open.row_high;
  xray.voltage_kv = shot.voltage;
  xray.exposure_ms = 1000 * shot.time, xray.current_ma = shot.current;
  xray.area_product = dose.area_product, xray.scan_hash = scan_hash;
  return data_tools::write_xray_file(path, xray);
}

Result<Outcome> run_fluoro(const FluoroArguments& a) {
  data_tools::OutputSet outputs;
  reads(outputs, a.moment, a.things);
  outputs.reads(a.pose);
  outputs.writes("output", a.output, data_tools::OutputKind::picture);
  outputs.writes("dicom", a.dicom);
  outputs.writes("sums", a.sums);
  if (Status error = outputs.check()) return *error;
  for (const auto& [path, extension, option] :
       {std::tuple(&a.dicom, ".dcm", "--dicom"), std::tuple(&a.sums, ".mha", "--sums")})
    if (!path->empty() && !data_tools::has_extension(*path, extension))
      return Error{"the file has another extension", option, "", std::string("NAME") + extension, ""};
  const double energy = a.energy.value_or(60);
  for (const Status& error :
       {check_range(energy, fluoroscopy::k_lowest_energy, fluoroscopy::k_highest_energy, "--energy"),
        check_range(a.photons, 0, 1e9, "--photons"), check_range(a.blur, 0, 20, "--blur"),
        check_range(a.rays, 1, 4, "--rays"), check_range(a.edge, 0, 10, "--edge"),
        check_range(a.size, 0, 8192, "--size"), check_range(a.shot.value_or(1), 1, 1e9, "--shot")})
    if (error) return *error;
  const auto opened = open_with(a.moment, a.things);
  if (!opened) return opened.error();
  std::optional<fluoroscopy::XrayTaken> taken;
  if (a.shot) {
    if (a.moment.until)
      return Error{"a shot has its own time", "--until", format_text("%g s", *a.moment.until), "--shot alone",
                   ""};
    const auto shot = go_to_shot(*opened.value(), static_cast<int>(*a.shot));
    if (!shot) return shot.error();
    taken = shot.value();
  }
  const workbench::Moment& moment = *opened.value();
  if (!moment.scan->is_hounsfield)
    return Error{"the scan's numbers are no Hounsfield units", "SRC", "values of another kind", "CT",
                 "CT whose file does not say so: --hounsfield"};
  const auto placed = arm_of(a, moment, taken ? &*taken : nullptr);
  if (!placed) return placed.error();
  const CArm& arm = placed.value();
  const View view(arm), fine = view.refined(a.rays);
  if (!sees(view, *moment.scan))
    return Error{"no ray meets the scan", "--isocentre",
                 format_text("%.1f, %.1f, %.1f", arm.isocentre.x, arm.isocentre.y, arm.isocentre.z),
                 "a beam through the scan", "leave the isocentre out: the scan's middle"};
  for (const auto& thing : moment.things)
    if (Status error = imaging::check_closed(thing)) return *error;

  // The image, and next to it the other kind's where that was asked for.
  const bool is_surface = a.way == static_cast<std::uint8_t>(Way::surface);
  const fluoroscopy::Matter matter =
      a.metal == 0 ? fluoroscopy::Matter::titanium : fluoroscopy::Matter::steel;
  const auto clock = Clock::now();
  std::vector<double> sums, other, sums_seen, other_seen;  // ..._seen: with what lies beyond the scan
  Outcome outcome{new_report("fluoro"), "", exit_done};
  Json& json = outcome.json;
  std::int64_t hidden_count = 0, tissue_count = 0;
  std::vector<std::uint8_t> hidden;
  if (is_surface || a.is_beside) {
    const auto image = surface_image(moment, fine, energy, {a.edge, matter, a.is_beside});
    if (!image) return image.error();
    sums = image.value().within;
    json["unbalanced_rays"] = image.value().unbalanced;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += image.value().edges[i];
    if (!is_surface) std::swap(sums, other);
  }
  const std::int64_t open_count = static_cast<std::int64_t>(view.open.column_high - view.open.column_low) *
                                  (view.open.row_high - view.open.row_low);
  if (!is_surface || a.is_beside) {
    fluoroscopy::VolumeXray xray(moment.scan, energy);
    const auto things = imaging::things_of(imaging::subject_of(moment), matter, energy);
    const bool is_exact = a.way == static_cast<std::uint8_t>(Way::exact);
    if (Status error = xray.project(fine, moment.version, things,
                                    is_exact ? volume::RaySum::exact : volume::RaySum::joseph))
      return *error;
    (is_surface ? other : sums) = xray.sums();
    std::vector<double>& seen = is_surface ? other_seen : sums_seen;
    seen = xray.beyond(fine);
    for (const Border border : xray.borders(view)) {
      hidden.push_back(border == Border::end);
      hidden_count += border == Border::end, tissue_count += border != Border::none;
    }
  }
  const double seconds = seconds_since(clock);
  const fluoroscopy::Detector detector{a.photons, a.blur, a.seed};
  const auto seen = [](std::vector<double> beyond, const std::vector<double>& within) {
    if (beyond.empty()) return within;
    for (std::size_t i = 0; i < beyond.size(); ++i) beyond[i] += within[i];
    return beyond;
  };
  const std::vector<float> received =
      fluoroscopy::receive(seen(std::move(sums_seen), sums), view, a.rays, detector);
  fluoroscopy::Shoot shot;
  if (taken) shot.time = taken->time, shot.voltage = taken->voltage, shot.current = taken->current;
  const fluoroscopy::Dose dose = fluoroscopy::dose_of(arm, shot);

  // Report.
  json["method"] = k_ways[a.way];
  json["energy_kev"] = energy;
  json["c_arm"] = {{"primary_degrees", arm.primary},
                   {"secondary_degrees", arm.secondary},
                   {"to_detector_mm", arm.to_detector},
                   {"to_patient_mm", arm.to_patient},
                   {"isocentre_world_mm", json_of(arm.isocentre)},
                   {"pixel_mm", arm.pixel},
                   {"columns", arm.columns},
                   {"rows", arm.rows}};
  json["exposure"] = {{"time_s", shot.time},
                      {"voltage_kv", shot.voltage},
                      {"current_ma", shot.current},
                      {"kerma_mgy", dose.kerma},
                      {"area_product_mgy_cm2", dose.area_product}};
  json["image_seconds"] = seconds;
  const double share = static_cast<double>(open_count) / 100;
  json["rays_past_the_border_in_the_body_percent"] = static_cast<double>(tissue_count) / share;
  json["rays_past_the_last_slices_not_shown_percent"] = static_cast<double>(hidden_count) / share;
  outcome.text =
      format_text("C-arm: primary %.1f, secondary %.1f degrees; %d x %d pixels of %.3f mm; %.2f s\n",
                  arm.primary, arm.secondary, view.columns, view.rows, arm.pixel, seconds);
  outcome.text += format_text("an exposure of %.1f s at %.0f kV, %.0f mA: %.3f mGy, %.1f mGy cm2\n",
                              shot.time, shot.voltage, shot.current, dose.kerma, dose.area_product);
  if (tissue_count > 0)
    outcome.text += format_text(
        "the scan does not fill the beam: %.1f %% of the rays pass its border in the body%s\n",
        static_cast<double>(tissue_count) / share,
        hidden_count > 0 ? format_text(", %.1f %% past its first and last slices, where nothing is shown",
                                       static_cast<double>(hidden_count) / share)
                               .c_str()
                         : "");
  fluoroscopy::Display display;
  display.is_logarithmic = !a.is_linear, display.is_inverted = a.is_film;
  imaging::Panel panel = imaging::xray_panel(received, view, arm.pixel, display, hidden);
  panel.title = format_text("%s: primary %.0f\u00b0, secondary %.0f\u00b0",
                            std::string(k_ways[a.way]).c_str(), arm.primary, arm.secondary);
  panel.foot = format_text("%.1f mGy cm\u00b2", dose.area_product);
  json["plan"] = add_plan(panel, view, arm, moment);
  std::vector<imaging::Panel> panels{panel};
  if (a.is_beside) {
    const Likeness alike = is_surface ? likeness(other, sums) : likeness(sums, other);
    json["surface_against_volume"] = {{"zncc", alike.zncc}, {"mape_percent", alike.mape}};
    outcome.text +=
        format_text("surfaces against the volume: ZNCC %.4f, MAPE %.1f %%\n", alike.zncc, alike.mape);
    panels.push_back(
        imaging::xray_panel(fluoroscopy::receive(seen(std::move(other_seen), other), view, a.rays, detector),
                            view, arm.pixel, display, hidden));
    panels.back().title = is_surface ? "volume" : "surface";
  }
  outputs.write(a.output, [&] {
    return view::write_slices(panels, a.output, std::clamp(std::max(view.columns, view.rows), 480, 1024));
  });
  outputs.write(a.dicom, [&] {
    return write_dicom(a.dicom, received, view, arm, shot, dose, volume::content_hash(*moment.scan));
  });
  outputs.write(a.sums, [&] { return write_sums(a.sums, sums, fine, arm.pixel / a.rays); });
  return finished(outputs, std::move(outcome), "no picture was asked for: -o XRAY.png\n");
}

Run build(Options& options) {
  auto a = std::make_shared<FluoroArguments>();
  add_moment(options, a->moment);
  add_shape(options, a->moment.shape);
  options.add("--view", a->view, "A usual pose; angles given with it replace its own")
      .one_of({std::begin(fluoroscopy::k_presets), std::end(fluoroscopy::k_presets)});
  options
      .add("--primary", a->primary, "Positioner primary angle: + with the detector toward the patient's left")
      .type("DEG");
  options.add("--secondary", a->secondary, "Positioner secondary angle: + with the detector toward the head")
      .type("DEG");
  options.add("--isocentre", a->isocentre, "mm (LPS); the scan's middle when left out").type("X,Y,Z");
  options.add("--to-detector", a->to_detector, "From the source, mm (1000)").type("MM");
  options.add("--to-patient", a->to_patient, "From the source to the isocentre, mm (650)").type("MM");
  options.add("--size", a->size, "Pixels across the same detector (1024)").type("N");
  options.add("--pixel", a->pixel, "Of the detector, mm (0.3)").type("MM");
  options.add("--collimate", a->collimate, "What collimators leave open, mm on the detector").type("W,H");
  options.add("--pose", a->pose, "Stand as the C-arm of this DICOM image did (XA, RF)").type("FILE");
  options.add("--shot", a->shot, "This shot of the session again: its pose, and the state of that moment")
      .type("N");
  options.add(
      "--method", a->way, k_ways,
      "How rays are summed: interpolated between voxels, exact through voxels as boxes, or by surfaces");
  options.add("--energy", a->energy, "Of the photons, keV (60)").type("KEV");
  options.add("--edge", a->edge, "Surfaces: how much a ray counts that only grazes bone").shows_default();
  add_things(options, a->things);
  options.add("--metal", a->metal, k_metals, "What models are of");
  options.add("--rays", a->rays, "To a pixel's edge, 1 to 4").type("N").shows_default();
  options.add("--photons", a->photons, "A pixel meets with nothing in the beam: noise (0: none)").type("N");
  options.add("--blur", a->blur, "Of the detector, sigma in pixels").type("PX");
  options.add("--seed", a->seed, "Of the noise").shows_default();
  options.add("--film", a->is_film, "Bone bright, as on a film");
  options.add("--linear", a->is_linear, "Greys by what comes through, not by its logarithm");
  options.add("--beside", a->is_beside, "Volume and surfaces side by side, and their similarity");
  options.add("-o,--output", a->output, "Write the image with letters and plan").type("PNG");
  options.add("--dicom", a->dicom, "Write the image as DICOM (XA)").type("FILE");
  options.add("--sums", a->sums, "Write the line integrals, -ln of what passes, as floats (MetaImage)")
      .type("MHA");
  return run_with(a, run_fluoro);
}

}  // namespace

const Command k_fluoro{
    "fluoro", "X-ray a scan, or a moment of a session, with a C-arm",
    "  trephine fluoro spine --view lateral -o lateral.png\n"
    "  trephine fluoro spine.session --case SCANS/SPINE --primary 30 --until 60 --dicom shot.dcm",
    build};

}  // namespace trephine::app
