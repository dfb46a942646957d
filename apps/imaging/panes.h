// Panes: images next to the 3-D view: slices that meet at the focus, sections, X-rays. Manages their kinds,
// contents and updates, and draws nothing.
#pragma once

#include <atomic>
#include <chrono>

#include "apps/imaging/pane_worker.h"
#include "apps/imaging/render_panel.h"
#include "apps/imaging/slice_panel.h"
#include "apps/imaging/xray_panel.h"

namespace trephine::imaging {

/// Kind of a pane. `tool`: a slice that contains the tool's shaft. `rendering`: the scan by ray casting, as
/// seen by the camera of the 3-D view. `depths`: the depth images around the tool.
enum class PaneKind : std::uint8_t { axial, coronal, sagittal, tool, section, xray, rendering, depths };
/// True for kinds that show a plane of the scan.
constexpr bool is_planar(PaneKind kind) { return kind < PaneKind::xray; }
inline constexpr std::string_view k_pane_kinds[] = {"axial",   "coronal", "sagittal", "tool",
                                                    "section", "xray",    "drawn",    "depths"};

/// Set of panes that show one subject. Not thread-safe. Pixels of a pane are counted from its upper left.
class Panes {
 public:
  explicit Panes(std::size_t count);

  // Focus.
  /// Sets the newest state. `is_changed`: matter changed since the previous state. The function
  /// itself detects another version, other objects and other depth images.
  void show(Subject subject, bool is_changed);
  /// Discards the subject and all images, before another scan is shown.
  void forget();
  /// Moves the focus, in which the slices meet (world, mm).
  void set_focus(const glm::dvec3& world);
  const glm::dvec3& focus() const noexcept { return at_; }
  /// Sets the tool's tip (world, mm) and the direction of its shaft, out of the body (unit).
  void show_tool(const glm::dvec3& tip, const glm::dvec3& shaft);
  /// Sets the surface of the tool for the next X-rays; nullopt: they show no tool.
  void set_xray_tool(std::optional<Object> tool) { xray_tool_ = std::move(tool); }
  /// Sets the normal of sections (world, any length above 0).
  void turn_section(const glm::dvec3& normal);
  glm::dvec3 section_normal() const noexcept { return section_normal_; }
  /// Current value of the scan at the focus, with removed matter as air; nullopt outside the scan.
  std::optional<int> probe() const;
  bool is_hounsfield() const noexcept { return subject_.scan && subject_.scan->is_hounsfield; }

  /// Selects the view of a surgeon behind the patient: the patient's left is on the left in slices, sections
  /// and X-rays, and the back is up in axial slices. False selects the radiological convention.
  void set_from_back(bool is_from_back);
  bool is_from_back() const noexcept { return is_from_back_; }

  // Controls of the user.
  std::size_t count() const noexcept { return panes_.size(); }
  void set_kind(std::size_t pane, PaneKind kind);
  PaneKind kind(std::size_t pane) const noexcept { return panes_[pane].kind; }
  /// Sets the size in pixels. Hidden panes get no images.
  void set_size(std::size_t pane, int columns, int rows, bool is_visible);
  void scroll(std::size_t pane, int slices);
  /// Scales the image around a pixel.
  void zoom(std::size_t pane, double factor, const glm::dvec2& around);
  void pan(std::size_t pane, const glm::dvec2& pixels);
  /// Fits the whole scan into the pane, centred.
  void reset(std::size_t pane);
  void set_window(const ct_viewer::GreyWindow& window);
  const ct_viewer::GreyWindow& window() const noexcept { return window_; }
  void set_blend(ct_viewer::Blend blend);
  ct_viewer::Blend blend() const noexcept { return blend_; }
  void set_labels(bool are_shown);
  bool has_labels() const noexcept { return has_labels_; }
  /// Sets the thickness over which slices are averaged, mm; 0: no averaging.
  void set_slab(double thickness);
  double slab() const noexcept { return slab_; }

  // Ray-cast scan.
  /// Sets the camera of the 3-D view. Its columns and rows are replaced by those of the pane.
  void set_camera(const volume::Camera& camera, const std::optional<volume::Openings::Plane>& clip);
  /// Selects the transfer function by a name of k_transfer_functions.
  void set_transfer_function(std::string_view name);
  const std::string& transfer_function() const noexcept { return transfer_; }
  /// Returns the selected transfer function. The function `bone` reaches k_touch_opacity at the threshold of
  /// the touched bone, or at k_bone if bone is not defined by a single threshold.
  volume::TransferFunction transfer(const volume::Volume& scan) const;
  /// Sets the factor of a label's opacity: 0 hides it.
  void set_label_opacity(std::size_t label, double opacity);

  // The C-arm. All X-ray panes show one image. It is held between exposures, even while no X-ray pane is
  // visible.
  void set_arm(const fluoroscopy::CArm& arm);
  const fluoroscopy::CArm& arm() const noexcept { return arm_; }
  /// Switches live X-rays on or off: 256 pixels across, taken again after each change.
  void set_live(bool is_live);
  bool is_live() const noexcept { return is_live_; }
  /// Requests a single X-ray of the current state, 1024 pixels across.
  void shoot();
  /// True while an X-ray is requested or computed.
  bool is_exposing() const noexcept { return xray_.is_requested || xray_.is_computing; }
  /// Sets the text next to X-rays: the total exposure.
  /// Removes the held X-ray.
  void clear_xray();
  void set_xray_note(std::string note) { xray_note_ = std::move(note); }
  const std::string& xray_note() const noexcept { return xray_note_; }

  // Requests and images.
  /// Adopts finished images, and requests new images for visible panes whose images are stale. Returns true
  /// if there are new images.
  bool frame();
  /// Newest image of a pane; null before the first.
  const Panel* panel(std::size_t pane) const noexcept;
  /// Error message of the newest request; empty if it succeeded.
  const std::string& problem(std::size_t pane) const noexcept { return image_of(pane).problem; }
  /// Number of images that were made for the pane.
  std::uint64_t image_count(std::size_t pane) const noexcept { return image_of(pane).count; }
  /// Counter that changes whenever the pane must be redrawn.
  std::uint64_t changes(std::size_t pane) const noexcept {
    return panes_[pane].changes + image_of(pane).changes;
  }
  /// True if a pane of this kind is visible.
  bool shows(PaneKind kind) const noexcept;
  /// True if all visible panes show the newest state at full resolution. An X-ray that is not live counts as
  /// up to date unless a new exposure is requested or in progress.
  bool is_up_to_date() const;
  /// True if a visible pane waits for its first image or for an image of its present size, or if it shows a
  /// volume rendering that is stale or coarse. Also true if an X-ray is requested or computed.
  bool is_waiting() const;
  PaneWorker::Counters counters() const { return worker_.counters(); }

  /// Plane of a planar pane; nullopt for other kinds.
  std::optional<volume::ImagePlane> plane(std::size_t pane) const;
  /// World position of a pixel; nullopt unless the pane is planar.
  std::optional<glm::dvec3> world(std::size_t pane, const glm::dvec2& pixel) const;
  /// Pixel of a world point in an X-ray, or of its orthogonal projection in a planar pane; nullopt for other
  /// kinds and behind the X-ray source.
  std::optional<glm::dvec2> pixel(std::size_t pane, const glm::dvec3& world) const;

 private:
  /// Newest image of a pane, or of the C-arm.
  struct Image {
    std::optional<Panel> panel;
    std::string problem;
    double milliseconds = 0;
    std::uint64_t count = 0, changes = 0;
    /// Changes with the kind and the scan. Images that were requested with another stamp are discarded.
    std::uint64_t stamp = 0;
    bool is_stale = false;
  };
  struct Pane {
    PaneKind kind = PaneKind::axial;
    int columns = 0, rows = 0;
    bool is_visible = false;
    double pixel = 0;           ///< mm; 0: fits the whole scan
    glm::dvec3 middle{0.0};     ///< world; its height above the plane is ignored
    std::uint64_t changes = 0;  ///< changes of the kind and the problem, in addition to Image::changes
    Image image;                ///< unused for X-rays
    std::shared_ptr<Renderer> renderer;
    bool is_coarse = false;  ///< drawn in fewer pixels during motion
    std::chrono::steady_clock::time_point requested{};
    std::shared_ptr<std::atomic<bool>> is_cancelled;  ///< cancels the image in progress
  };
  struct Xray : Image {
    std::shared_ptr<XrayCamera> camera;
    bool is_requested = false;  ///< a single X-ray was requested and not begun
    bool is_computing = false;
  };
  Image& image_of(std::size_t index) noexcept {
    return panes_[index].kind == PaneKind::xray ? xray_ : panes_[index].image;
  }
  const Image& image_of(std::size_t index) const noexcept {
    return panes_[index].kind == PaneKind::xray ? xray_ : panes_[index].image;
  }
  void forget(std::size_t index);
  /// Adopts a finished image from a slot of the worker. Returns true if it is new.
  bool adopt(std::size_t slot, Image& image);
  bool adopt_xray();
  bool is_xray_due() const noexcept {
    return xray_.is_requested || (is_live_ && xray_.is_stale && shows(PaneKind::xray));
  }
  volume::ImagePlane plane_of(const Pane& pane) const;
  bool is_mirrored(const fluoroscopy::View& view) const noexcept;
  void show_side(Panel& panel) const;
  void request(std::size_t index);
  void request_rendering(std::size_t index);
  void request_xray();
  void make_stale(bool includes_xrays);
  /// Marks slices, and sections if `includes_sections`, as stale.
  void make_slices_stale(bool includes_sections = false);

  Subject subject_;
  std::vector<Pane> panes_;
  Xray xray_;
  std::optional<Object> xray_tool_;
  glm::dvec3 at_{0.0}, tip_{0.0}, shaft_{0, 0, 1}, section_normal_{0, -1, 0};
  ct_viewer::GreyWindow window_;
  ct_viewer::Blend blend_ = ct_viewer::Blend::now;
  bool is_from_back_ = false, has_labels_ = false, is_live_ = false, has_window_ = false, has_arm_ = false;
  double slab_ = 0;
  fluoroscopy::CArm arm_;
  volume::Camera camera_;
  std::optional<volume::Openings::Plane> clip_;
  std::string transfer_ = "bone", xray_note_;
  std::vector<volume::LabelAppearance> appearances_;  ///< by label, for ray casting
  bool has_camera_ = false;
  double pixels_per_ms_ = 2000;  ///< speed of recent ray casting
  PaneWorker worker_;            ///< a slot for each pane, then one for the C-arm
};

}  // namespace trephine::imaging
