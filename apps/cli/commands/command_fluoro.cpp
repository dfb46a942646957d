// fluoro: C-arm X-ray image of a scan, or of a moment of a session.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/commands/surface_image.h"
#include "apps/imaging/xray_panel.h"
#include "apps/view/slice_picture.h"
#include "apps/workbench/moment.h"
#include "data-tools/dicom/xray_file.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "modules/fluoroscopy/detector.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "modules/fluoroscopy/volume_xray.h"
#include "volume/imaging/image_plane.h"

namespace trephine::cli {

using fluoroscopy::Border;
using fluoroscopy::CArm;
using fluoroscopy::View;
using glm::dvec2;
using glm::dvec3;

namespace {

enum class Integration : std::uint8_t { interpolated, exact, surface };
constexpr std::string_view k_integrations[] = {"interpolated", "exact", "surface"};

struct FluoroArguments {
  workbench::MomentChoice moment;
  std::string view, isocentre, collimate, pose, output, dicom, sums;
  ObjectArguments objects;
  std::optional<double> primary, secondary, to_detector, to_patient, pixel;
  std::optional<double> energy, shot;
  int size = 0, rays = 1;
  std::uint8_t integration = 0;
  double photons = 0, blur = 0, edge = 0.3;
  std::uint64_t seed = 1;
  bool is_film = false, is_linear = false, is_side_by_side = false;
};

/// Moves the session to a shot, by its number. Returns the shot, with the pose of the C-arm.
Result<fluoroscopy::XrayTaken> go_to_shot(workbench::Moment& moment, int number) {
  if (!moment.session)
    return Error{.what = "a scan contains no shots",
                 .where = "shot",
                 .found = std::to_string(number),
                 .expected = "a recorded session"};
  std::int64_t count = 0;
  const sim::Chronicle& chronicle = moment.state()->chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i) {
    const auto* event = chronicle[i].value.as<fluoroscopy::XrayTaken>();
    if (event == nullptr) continue;
    ++count;
    if (event->number != number) continue;
    const fluoroscopy::XrayTaken shot = *event;
    if (Status error = workbench::go_to(moment, chronicle[i].tick)) return *error;
    return shot;
  }
  return Error{
      .what = "unknown shot",
      .where = "shot",
      .found = std::to_string(number),
      .expected = count > 0 ? format_text("1 to %d", static_cast<int>(count)) : "a session with shots"};
}

/// Returns the pose of the C-arm. Later sources override earlier ones: the shot or else the session, the
/// file, the named view, and single numbers.
Result<CArm> arm_of(const FluoroArguments& a, const workbench::Moment& moment, const CArm* shot) {
  CArm arm;
  const glm::dvec3 middle = 0.5 * (glm::dvec3(moment.scan->size) - 1.0);
  arm.isocentre = moment.scan->frame.world_from_volume(middle);
  if (shot != nullptr) {
    arm = *shot;
  } else if (moment.session) {
    const auto* state = moment.state()->persistent_of<fluoroscopy::FluoroscopyState>();
    if (state != nullptr && state->is_placed) arm = *state;
  }
  if (!a.pose.empty()) {
    const auto pose = data_tools::read_xray_pose(a.pose);
    if (!pose) return pose.error();
    const data_tools::XrayPose& p = pose.value();
    if (!p.primary && !p.secondary)
      return Error{.what = "the image does not contain the pose of the C-arm",
                   .where = "pose",
                   .found = "no positioner angles",
                   .expected = "(0018,1510) and (0018,1511)",
                   .remedy = "pass --primary and --secondary"};
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
    const auto position = parse_point(a.isocentre, "--isocentre");
    if (!position) return position.error();
    arm.isocentre = position.value();
  }
  if (a.size > 0) {  // keep the detector's size, change its pixels
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
      return Error{.what = "invalid field size",
                   .where = "--collimate",
                   .found = a.collimate,
                   .expected = "width,height in mm on the detector: 120,80"};
  }
  if (Status error = fluoroscopy::check(arm)) return *error;
  return arm;
}

/// True if some ray may meet the scan: the projected bounding box of its corners overlaps the open field.
bool sees(const View& view, const volume::Volume& scan) {
  dvec2 low(1e300), high(-1e300);
  for (const dvec3& corner : volume::corners_world(scan.frame, glm::ivec3(0), scan.size - 1)) {
    const auto pixel = view.project(corner);
    if (!pixel) return true;  // a corner is behind the source
    low = glm::min(low, *pixel), high = glm::max(high, *pixel);
  }
  return high.x >= view.open.column_low && high.y >= view.open.row_low && low.x < view.open.column_high &&
         low.y < view.open.row_high;
}

/// Returns trajectories and landmarks with their pixels.
Json json_of_plan(const volume::SurgicalPlan& plan, const View& view) {
  Json rows = Json::array();
  const auto pixel = [&](const dvec3& p) {
    const auto at = view.project(p);
    return at ? Json{at->x, at->y} : Json();
  };
  for (const volume::PlannedTrajectory& t : plan.trajectories)
    rows.push_back({{"name", t.name},
                    {"entry_world_mm", json_of(t.entry_world)},
                    {"target_world_mm", json_of(t.target_world)},
                    {"entry_pixel", pixel(t.entry_world)},
                    {"target_pixel", pixel(t.target_world)}});
  for (const volume::PlannedLandmark& l : plan.landmarks)
    rows.push_back({{"name", l.name}, {"pixel", pixel(l.position_world)}});
  return rows;
}

/// Writes line integrals (-ln of the transmitted share) as one slice of floats, with the detector's centre at
/// the origin.
Status write_sums(const std::string& path, std::span<const double> sums, const View& view, double pixel) {
  std::string text = format_text(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = "
      "False\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = %.17g %.17g 0\nElementSpacing = %.17g %.17g 1\n"
      "DimSize = %d %d 1\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n",
      -0.5 * pixel * (view.columns - 1), -0.5 * pixel * (view.rows - 1), pixel, pixel, view.columns,
      view.rows);
  for (const double sum : sums) {
    const auto value = static_cast<float>(sum);
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
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
    pixels.push_back(static_cast<std::uint16_t>(std::clamp(
        65535 - data_tools::XrayToWrite::k_log_steps * fluoroscopy::attenuation_of(v), 0.0, 65535.0)));
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
  add_inputs(outputs, a.moment, a.objects);
  outputs.add_input(a.pose);
  outputs.add_output("output", a.output, data_tools::OutputKind::picture);
  outputs.add_output("dicom", a.dicom);
  outputs.add_output("sums", a.sums);
  if (Status error = outputs.check()) return *error;
  for (const auto& [path, extension, option] :
       {std::tuple(&a.dicom, ".dcm", "--dicom"), std::tuple(&a.sums, ".mha", "--sums")})
    if (!path->empty() && !data_tools::has_extension(*path, extension))
      return Error{.what = "the file has a wrong extension",
                   .where = option,
                   .expected = std::string("NAME") + extension};
  const double energy = a.energy.value_or(60);
  for (const Status& error :
       {check_range(energy, fluoroscopy::k_lowest_energy, fluoroscopy::k_highest_energy, "--energy"),
        check_range(a.photons, 0, 1e9, "--photons"), check_range(a.blur, 0, 20, "--detector-blur"),
        check_range(a.rays, 1, 4, "--supersampling"), check_range(a.edge, 0, 10, "--edge"),
        check_range(a.size, 0, 8192, "--pixels"), check_range(a.shot.value_or(1), 1, 1e9, "--shot")})
    if (error) return *error;
  const auto opened = open_with(a.moment, a.objects);
  if (!opened) return opened.error();
  std::optional<fluoroscopy::XrayTaken> session_shot;
  if (a.shot && *a.shot != std::floor(*a.shot))
    return Error{.what = "the number of a shot is not whole",
                 .where = "--shot",
                 .found = format_text("%g", *a.shot),
                 .expected = "1, 2, 3 or more"};
  if (a.shot) {
    if (a.moment.until)
      return Error{.what = "the shot already selects the time",
                   .where = "--until",
                   .found = format_text("%g s", *a.moment.until),
                   .expected = "--shot alone",
                   .remedy = "omit --until"};
    const auto shot = go_to_shot(*opened.value(), static_cast<int>(*a.shot));
    if (!shot) return shot.error();
    session_shot = shot.value();
  }
  const workbench::Moment& moment = *opened.value();
  if (!moment.scan->is_hounsfield)
    return Error{.what = "the scan's values are not Hounsfield units",
                 .where = "SRC",
                 .found = "values without a unit",
                 .expected = "CT",
                 .remedy = "for CT without this information pass --hounsfield"};
  const auto placed = arm_of(a, moment, session_shot ? &*session_shot : nullptr);
  if (!placed) return placed.error();
  const CArm& arm = placed.value();
  const View view(arm), fine = view.refined(a.rays);
  if (!sees(view, *moment.scan))
    return Error{.what = "no ray intersects the scan",
                 .where = "--isocentre",
                 .found = format_text("%.1f, %.1f, %.1f", arm.isocentre.x, arm.isocentre.y, arm.isocentre.z),
                 .expected = "a beam through the scan",
                 .remedy = "omit the isocentre to use the middle of the scan"};
  for (const auto& object : moment.objects)
    if (Status error = imaging::check_closed(object)) return *error;

  // Compute the image and, for --side-by-side, also the image of the other kind (volume or surfaces).
  const bool is_surface = a.integration == static_cast<std::uint8_t>(Integration::surface);
  const auto clock = Clock::now();
  std::vector<double> sums, other;
  // Sums along the parts of the rays outside the scan; empty for images from surfaces.
  std::vector<double> sums_beyond, other_beyond;
  Outcome outcome("fluoro");
  Json& json = outcome.json;
  std::int64_t hidden_count = 0, tissue_count = 0;
  std::vector<std::uint8_t> hidden;
  if (is_surface || a.is_side_by_side) {
    const auto image = surface_image(moment, fine, energy, {a.edge, a.is_side_by_side});
    if (!image) return image.error();
    sums = image.value().within;
    json["unbalanced_rays"] = image.value().unbalanced;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += image.value().edges[i];
    if (!is_surface) std::swap(sums, other);
  }
  const std::int64_t open_count = static_cast<std::int64_t>(view.open.column_high - view.open.column_low) *
                                  (view.open.row_high - view.open.row_low);
  if (!is_surface || a.is_side_by_side) {
    fluoroscopy::VolumeXray xray(moment.scan, energy);
    const auto objects = imaging::xray_objects(imaging::subject_of(moment), energy);
    const bool is_exact = a.integration == static_cast<std::uint8_t>(Integration::exact);
    if (Status error = xray.project(fine, moment.version, objects,
                                    is_exact ? volume::RaySum::exact : volume::RaySum::joseph))
      return *error;
    (is_surface ? other : sums) = xray.sums();
    std::vector<double>& padded = is_surface ? other_beyond : sums_beyond;
    padded = xray.sums_outside(fine);
    for (const Border border : xray.borders(view)) {
      hidden.push_back(border == Border::end);
      hidden_count += border == Border::end, tissue_count += border != Border::none;
    }
  }
  const double seconds = seconds_since(clock);
  const fluoroscopy::Detector detector{a.photons, a.blur, a.seed};
  const auto add_beyond = [](std::vector<double> beyond, const std::vector<double>& within) {
    if (beyond.empty()) return within;
    for (std::size_t i = 0; i < beyond.size(); ++i) beyond[i] += within[i];
    return beyond;
  };
  const std::vector<float> received =
      fluoroscopy::receive(add_beyond(std::move(sums_beyond), sums), view, a.rays, detector);
  fluoroscopy::Shoot shot;
  if (session_shot)
    shot.time = session_shot->time, shot.voltage = session_shot->voltage,
    shot.current = session_shot->current;
  const fluoroscopy::Dose dose = fluoroscopy::dose_of(arm, shot);

  // Report.
  json["method"] = k_integrations[a.integration];
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
  outcome.print(
      "C-arm: primary {c_arm/primary_degrees:.1f}, secondary {c_arm/secondary_degrees:.1f} degrees; "
      "{columns} x {rows} pixels of {c_arm/pixel_mm:.3f} mm; {image_seconds:.2f} s",
      {{"columns", view.columns}, {"rows", view.rows}});
  outcome.print(
      "an exposure of {time_s:.1f} s at {voltage_kv:.0f} kV, {current_ma:.0f} mA: {kerma_mgy:.3f} mGy, "
      "{area_product_mgy_cm2:.1f} mGy cm²",
      json["exposure"]);
  if (tissue_count > 0)
    outcome.print(
        std::string(
            "the scan does not fill the beam: {rays_past_the_border_in_the_body_percent:.1f} % of the "
            "rays pass its border in the body") +
        (hidden_count > 0 ? ", {rays_past_the_last_slices_not_shown_percent:.1f} % past its first and last "
                            "slices, where nothing is shown"
                          : ""));
  fluoroscopy::Display display = fluoroscopy::k_fluoroscope_display;
  display.is_logarithmic = !a.is_linear, display.is_inverted = a.is_film;
  imaging::Panel panel = imaging::xray_panel(received, view, arm.pixel, display, hidden);
  panel.title = format_text("X-ray: primary %.0f\u00b0, secondary %.0f\u00b0", arm.primary, arm.secondary);
  panel.foot = format_text("dose-area product %.1f mGy cm\u00b2", dose.area_product);
  imaging::draw_plan(panel, moment.plan, view, arm.pixel);
  json["plan"] = json_of_plan(moment.plan, view);
  std::vector<imaging::Panel> panels{panel};
  if (a.is_side_by_side) {
    const Likeness similarity = is_surface ? likeness(other, sums) : likeness(sums, other);
    json["surface_against_volume"] = {{"zncc", similarity.zncc}, {"mape_percent", similarity.mape}};
    outcome.print("surfaces against the volume: ZNCC {zncc:.4f}, MAPE {mape_percent:.1f} %",
                  json["surface_against_volume"]);
    panels.push_back(imaging::xray_panel(
        fluoroscopy::receive(add_beyond(std::move(other_beyond), other), view, a.rays, detector), view,
        arm.pixel, display, hidden));
    panels.back().title = is_surface ? "volume" : "surface";
  }
  outputs.write(a.output, [&] {
    return view::write_slices(panels, a.output, std::clamp(std::max(view.columns, view.rows), 480, 1024));
  });
  outputs.write(a.dicom, [&] {
    return write_dicom(a.dicom, received, view, arm, shot, dose, volume::content_hash(*moment.scan));
  });
  outputs.write(a.sums, [&] { return write_sums(a.sums, sums, fine, arm.pixel / a.rays); });
  return finished(outputs, std::move(outcome), "no picture requested: -o XRAY.png");
}

Run build_fluoro(Options& options) {
  auto a = std::make_shared<FluoroArguments>();
  add_moment(options, a->moment);
  add_shape(options, a->moment.shape);
  options.add("--view", a->view, "A standard view; angles that are passed replace its angles")
      .one_of({std::begin(fluoroscopy::k_presets), std::end(fluoroscopy::k_presets)});
  options
      .add("--primary", a->primary, "Positioner primary angle: + with the detector toward the patient's left")
      .type("DEG");
  options.add("--secondary", a->secondary, "Positioner secondary angle: + with the detector toward the head")
      .type("DEG");
  options.add("--isocentre", a->isocentre, "Isocentre, mm (LPS) (default: centre of the scan)").type("X,Y,Z");
  options.add("--to-detector", a->to_detector, "Distance from the source to the detector, mm (1000)")
      .type("MM");
  options.add("--to-patient", a->to_patient, "Distance from the source to the isocentre, mm (650)")
      .type("MM");
  options.add("--pixels", a->size, "Pixels along an edge of the detector, whose size does not change (1024)")
      .type("N");
  options.add("--pixel", a->pixel, "Pixel size of the detector, mm (0.3)").type("MM");
  options.add("--collimate", a->collimate, "Opening of the collimators, mm on the detector").type("W,H");
  options.add("--pose", a->pose, "Use the pose of the C-arm of this DICOM image (XA, RF)").type("FILE");
  options.add("--shot", a->shot, "Repeat this shot of the session: its pose, and the state of that moment")
      .type("N");
  options.add(
      "--integration", a->integration, k_integrations,
      "Integration along rays: interpolated between voxels, exact through voxels as boxes, or by surfaces");
  options.add("--energy", a->energy, "Energy of the photons, keV (60)").type("KEV");
  options.add("--edge", a->edge, "Surfaces: contribution of a ray that only grazes bone").shows_default();
  add_objects(options, a->objects);
  options.add("--supersampling", a->rays, "Rays along the edge of a pixel, 1 to 4").type("N").shows_default();
  options
      .add("--photons", a->photons, "Photons per pixel with nothing in the beam, for the noise (0: no noise)")
      .type("N");
  options.add("--detector-blur", a->blur, "Blur of the detector, sigma in pixels").type("PX");
  options.add("--seed", a->seed, "Seed of the noise").shows_default();
  options.add("--film", a->is_film, "Bone bright, as on a film");
  options.add("--linear", a->is_linear, "Greys by transmitted intensity, not by its logarithm");
  options.add("--side-by-side", a->is_side_by_side, "Volume and surfaces side by side, and their similarity");
  options.add("-o,--output", a->output, "Write the image with letters and plan").type("PNG");
  options.add("--dicom", a->dicom, "Write the image as DICOM (XA)").type("FILE");
  options
      .add("--sums", a->sums, "Write the line integrals, -ln of the transmitted share, as floats (MetaImage)")
      .type("MHA");
  return run_with(a, run_fluoro);
}

}  // namespace

const Command k_fluoro{
    "fluoro", "X-ray a scan, or a moment of a session, with a C-arm",
    "  trephine fluoro spine --view lateral -o lateral.png\n"
    "  trephine fluoro spine.session --scan SCANS/SPINE --primary 30 --until 60 --dicom shot.dcm",
    build_fluoro};

}  // namespace trephine::cli
