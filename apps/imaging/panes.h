// Panes next to a picture in three dimensions: slices that meet at the focus, sections, X-rays. Their
// kinds, contents and updates; who draws them is elsewhere.
#pragma once

#include <atomic>
#include <chrono>

#include "apps/imaging/pane_worker.h"
#include "apps/imaging/render_panel.h"
#include "apps/imaging/slice_panel.h"
#include "apps/imaging/xray_panel.h"

namespace trephine::imaging {

/// Kind of a pane. Along the tool: a slice in which its shaft lies. Drawn: the scan itself, directly, seen
/// as the picture is. Depths: the depth images around the tool.
enum class PaneKind : std::uint8_t { axial, coronal, sagittal, tool, section, xray, drawn, depths };
/// Does it show a plane of the scan?
constexpr bool is_planar(PaneKind kind) { return kind < PaneKind::xray; }
inline constexpr std::string_view k_pane_kinds[] = {"axial",   "coronal", "sagittal", "tool",
                                                    "section", "xray",    "drawn",    "depths"};

/// One thread. Pixels of a pane are counted from its upper left.
class Panes {
 public:
  explicit Panes(std::size_t count);

  // Focus.
  /// The newest state. is_changed: matter or things are not what they were the last time.
  void show(Subject subject, bool is_changed);
  /// Another scan: what was made of the old one is forgotten.
  void forget();
  void look_at(const glm::dvec3& world);
  const glm::dvec3& looked_at() const noexcept { return at_; }
  /// Position of the tool and direction of its shaft, out of the body. Unit.
  void show_tool(const glm::dvec3& tip, const glm::dvec3& shaft);
  void turn_section(const glm::dvec3& normal);
  glm::dvec3 section_normal() const noexcept { return section_normal_; }
  /// Value of the scan at the focus; empty outside of it.
  std::optional<int> probe() const;
  bool is_hounsfield() const noexcept { return subject_.scan && subject_.scan->is_hounsfield; }

  /// As a surgeon stands behind the patient: the patient's left is on the left in slices, sections and X-rays
  /// alike, and the back is up in axial ones. Otherwise as radiologists look at them.
  void set_from_back(bool is_from_back);
  bool is_from_back() const noexcept { return is_from_back_; }

  // Controls of the user.
  std::size_t count() const noexcept { return panes_.size(); }
  void set_kind(std::size_t pane, PaneKind kind);
  PaneKind kind(std::size_t pane) const noexcept { return panes_[pane].kind; }
  /// Nothing is made of a hidden one.
  void set_size(std::size_t pane, int columns, int rows, bool is_visible);
  void scroll(std::size_t pane, int slices);
  void zoom(std::size_t pane, double factor, const glm::dvec2& around);
  void pan(std::size_t pane, const glm::dvec2& pixels);
  /// As much as there is, in the middle.
  void reset(std::size_t pane);
  void set_window(const ct_viewer::GreyWindow& window);
  const ct_viewer::GreyWindow& window() const noexcept { return window_; }
  void set_blend(ct_viewer::Blend blend);
  ct_viewer::Blend blend() const noexcept { return blend_; }
  void set_labels(bool are_shown);
  bool has_labels() const noexcept { return has_labels_; }
  void set_slab(double thickness);
  double slab() const noexcept { return slab_; }

  // Ray-cast scan.
  /// As the picture is seen; its pixels are those of the pane.
  void set_eye(const volume::Eye& eye, const std::optional<volume::Openings::Plane>& clip);
  /// One of k_ramps.
  void set_ramp(std::string_view name);
  const std::string& ramp() const noexcept { return ramp_; }
  /// Factor of a label's opacity: 0 hides it.
  void set_label_opacity(std::size_t label, double opacity);

  // The C-arm. Between exposures its last image is held.
  void set_arm(const fluoroscopy::CArm& arm);
  const fluoroscopy::CArm& arm() const noexcept { return arm_; }
  /// 256 pixels across, whenever something changed.
  void set_live(bool is_live);
  bool is_live() const noexcept { return is_live_; }
  /// 1024 pixels across, once.
  void shoot();
  /// Total exposure, written next to X-rays.
  void set_xray_note(std::string note) { xray_note_ = std::move(note); }
  const std::string& xray_note() const noexcept { return xray_note_; }

  // Requests and images.
  /// Takes finished images in, and asks for those that are not as they should be. True: there are new ones.
  bool frame();
  /// Null: none yet.
  const Panel* panel(std::size_t pane) const noexcept;
  /// Why the newest could not be made.
  const std::string& trouble(std::size_t pane) const noexcept { return panes_[pane].trouble; }
  double milliseconds(std::size_t pane) const noexcept { return panes_[pane].milliseconds; }
  std::uint64_t made(std::size_t pane) const noexcept { return panes_[pane].made; }
  /// Another number whenever there is something else to draw.
  std::uint64_t changes(std::size_t pane) const noexcept { return panes_[pane].changes; }
  /// Is a pane of this kind visible?
  bool sees(PaneKind kind) const noexcept;
  /// Is all that is visible as it should be?
  bool is_up_to_date() const;
  PaneWorker::Counters counters() const { return worker_.counters(); }

  /// The plane of a pane that shows one.
  std::optional<volume::ImagePlane> plane(std::size_t pane) const;
  /// World position of a pixel; empty in an X-ray.
  std::optional<glm::dvec3> world(std::size_t pane, const glm::dvec2& pixel) const;
  /// Position of a point in the image, or of its orthogonal projection on the plane; empty outside of it.
  std::optional<glm::dvec2> pixel(std::size_t pane, const glm::dvec3& world) const;

 private:
  struct Pane {
    PaneKind kind = PaneKind::axial;
    int columns = 0, rows = 0;
    bool is_visible = false;
    double pixel = 0;                          ///< mm; 0: as much as there is
    glm::dvec3 middle{0.0};                    ///< world; its height is that of where one looks
    bool is_stale = false, is_wanted = false;  ///< a shot was asked for
    std::shared_ptr<XrayCamera> camera;
    std::shared_ptr<Renderer> renderer;
    bool is_coarse = false;  ///< drawn in fewer pixels while things move
    std::chrono::steady_clock::time_point asked{};
    std::optional<Panel> panel;
    std::string trouble;
    double milliseconds = 0;
    std::uint64_t made = 0, changes = 0;
    std::uint64_t stamp = 0;                         ///< of requests of this kind and scan
    std::shared_ptr<std::atomic<bool>> is_given_up;  ///< of an image that takes long, while it is made
  };
  void forget(std::size_t index);
  volume::ImagePlane turned(const Pane& pane) const;
  bool is_mirrored(const fluoroscopy::View& view) const noexcept;
  void show_side(Panel& panel) const;
  void request(std::size_t index);
  void request_drawn(std::size_t index);
  void make_stale(bool with_xrays);
  /// Slices, and sections where they are meant too.
  void make_slices_stale(bool with_sections = false);

  Subject subject_;
  std::vector<Pane> panes_;
  glm::dvec3 at_{0.0}, tip_{0.0}, shaft_{0, 0, 1}, section_normal_{0, -1, 0};
  ct_viewer::GreyWindow window_;
  ct_viewer::Blend blend_ = ct_viewer::Blend::now;
  bool is_from_back_ = false, has_labels_ = false, is_live_ = false, has_window_ = false, has_arm_ = false;
  double slab_ = 0;
  fluoroscopy::CArm arm_;
  volume::Eye eye_;
  std::optional<volume::Openings::Plane> clip_;
  std::string ramp_ = "bone", xray_note_;
  std::vector<volume::LabelLook> looks_;  ///< by label, of what is drawn directly
  bool has_eye_ = false;
  double pixels_a_ms_ = 2000;  ///< that were drawn directly, of late
  PaneWorker worker_;
};

}  // namespace trephine::imaging
