#include "apps/cli/report/report_pictures.h"

#include <cmath>

#include "apps/imaging/slice_panel.h"
#include "apps/imaging/xray_panel.h"
#include "apps/view/comparison.h"
#include "apps/view/slice_picture.h"
#include "apps/workbench/text.h"

namespace trephine::cli {

using glm::dvec2;
using imaging::Panel;
using workbench::format_text;
using workbench::ReportMoment;

namespace {

constexpr Panel::Colour k_danger{255, 90, 70}, k_removed{254, 161, 38};

imaging::Subject subject_of(const workbench::ReportData& data, const ReportMoment& moment) {
  const haptics::TouchScene& scene = data.engine().scene();
  imaging::Subject subject{scene.base, moment.version, {}, {}, moment.objects, {}};
  for (const haptics::TouchItem& item : scene.items)
    if (!subject.bone && !item.is_mesh() && &item.field.volume() == scene.base.get())
      subject.bone = item.field.shape();
  for (const auto& structure : data.engine().forbidden())
    if (structure->shape()) subject.structures.push_back(*structure->shape());
  subject.plan = std::make_shared<const volume::SurgicalPlan>(data.header().plan);
  return subject;
}

/// Adds a ring around the panel's centre.
void add_ring(Panel& panel) {
  constexpr double k_radius = 2.5;  // mm
  constexpr int k_corners = 32;
  Panel::Line ring{{}, k_danger, true, "position", true};
  for (int i = 0; i < k_corners; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / k_corners;
    ring.points.push_back(k_radius * dvec2(std::cos(angle), std::sin(angle)));
  }
  panel.lines.push_back(std::move(ring));
}

/// Slices through the position: axial and sagittal, with removed matter in amber.
Result<std::string> slices_of(const workbench::ReportData& data, const ReportMoment& moment) {
  const imaging::Subject subject = subject_of(data, moment);
  std::vector<Panel> panels;
  for (const char* name : {"axial", "sagittal"}) {
    volume::ImagePlane plane;
    volume::orient_plane(plane, name);
    plane.middle_world = moment.position_world;
    plane.columns = plane.rows = 300;
    plane.pixel = 0.25;
    const ct_viewer::SliceValues values = ct_viewer::slice_values(*subject.scan, *moment.version, plane, {});
    Panel panel = imaging::slice_panel(values, plane, imaging::first_window(*subject.scan, values.before),
                                       ct_viewer::Blend::both);
    // If outlines cannot be drawn (an open model has no cross-section), show the slice without them.
    if (imaging::draw_in(panel, subject, plane, false)) panel.lines.clear();
    add_ring(panel);
    if (values.before != values.now) panel.lines.push_back({{}, k_removed, true, "removed"});
    panel.title = name;
    panels.push_back(std::move(panel));
  }
  return view::slices_png(panels, 360);
}

Result<std::string> xray_of(const workbench::ReportData& data, const ReportMoment& moment,
                            imaging::XrayCamera& camera) {
  constexpr std::int64_t k_edge = 480;  // pixels
  fluoroscopy::CArm arm = *moment.xray;
  const double factor = static_cast<double>(std::max(arm.columns, arm.rows)) / static_cast<double>(k_edge);
  if (factor > 1) {
    arm.pixel *= factor;
    arm.columns = std::max<std::int64_t>(1, std::llround(static_cast<double>(arm.columns) / factor));
    arm.rows = std::max<std::int64_t>(1, std::llround(static_cast<double>(arm.rows) / factor));
  }
  const auto panel = camera.shoot(subject_of(data, moment), arm, 0);
  if (!panel) return panel.error();
  return view::slices_png({panel.value()}, static_cast<int>(k_edge));
}

/// Adds the states before and after, and the sections of their difference.
Status add_states(const workbench::ReportData& data, ReportPictures& pictures) {
  const haptics::TouchScene& scene = data.engine().scene();
  if (scene.items.empty() || scene.items[0].is_mesh() || !scene.base) return std::nullopt;
  auto panels = view::comparison_panels(scene, {"before", data.engine().uncut(), {}},
                                        {"after", data.engine().version(), data.overlays});
  if (!panels) return panels.error();
  std::vector<Panel>& all = panels.value();
  all[2].title = "removed or detached";  // replaces a title with a volume, which the page prints itself
  for (Panel::Line& line : all[2].lines) line.name = all[2].title;
  const auto states = view::slices_png({all[0], all[1]});
  if (!states) return states.error();
  const auto sections = view::slices_png({all[2], all[3]});
  if (!sections) return sections.error();
  pictures.states = states.value();
  pictures.sections = sections.value();
  return std::nullopt;
}

}  // namespace

ReportPictures pictures_of(const workbench::ReportData& data) {
  ReportPictures pictures;
  if (const Status error = add_states(data, pictures)) pictures.problem = error->what;
  imaging::XrayCamera camera;
  for (const ReportMoment& moment : data.moments) {
    const auto png = moment.xray ? xray_of(data, moment, camera) : slices_of(data, moment);
    if (png)
      pictures.moments.push_back({png.value(), format_text("%.1f s", moment.seconds), moment.text,
                                  moment.level == workbench::EventLevel::danger});
    else if (pictures.problem.empty())
      pictures.problem = png.error().what;
  }
  return pictures;
}

}  // namespace trephine::cli
