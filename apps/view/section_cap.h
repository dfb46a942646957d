// SectionCap: the cut face of a clipped picture, in the colours of the bone and of the structures.
#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "apps/view/structures.h"
#include "volume/imaging/direct_image.h"

namespace trephine::view {

/// Matter in a plane, as an image.
struct CapImage {
  glm::dvec3 corner_world{0.0};                       ///< outer corner of the first pixel
  glm::dvec3 right_world{0.0}, up_world{0.0};         ///< edges of the image from that corner, mm
  glm::dvec3 normal_world{0, 0, 1};                   ///< unit, toward the side that is not shown
  int columns = 0, rows = 0;                          ///< 0: the plane misses the scan
  std::vector<std::array<std::uint8_t, 4>> pixels{};  ///< RGBA; alpha is 255 in matter and 0 elsewhere
};

/// Returns the matter of a version in a plane: bone shaded by its density, its marrow if labels mark it, and
/// structures in their colours. `structures`: structures_of() the scene; those with an opacity below 1 are
/// left out. At most `max_pixels` per edge. Cost: some 10 ms with k_cap_pixels.
CapImage cap_image(const haptics::TouchScene& scene, const volume::Version& version,
                   const std::vector<Structure>& structures, const volume::Openings::Plane& plane,
                   int max_pixels);
inline constexpr int k_cap_pixels = 1000, k_coarse_cap_pixels = 250;

/// Returns true if cap_image() shows matter at a position (world, mm) in its plane.
bool has_cap_at(const haptics::TouchScene& scene, const volume::Version& version,
                const std::vector<Structure>& structures, const glm::dvec3& at_world);

/// Computes images of cut faces on another thread; a new request replaces a waiting one. No cost before the
/// first request. Borrows the scene. Call on the drawing thread only.
class SectionCap {
 public:
  explicit SectionCap(const haptics::TouchScene& scene) : scene_(&scene) {}
  ~SectionCap();
  SectionCap(const SectionCap&) = delete;
  SectionCap& operator=(const SectionCap&) = delete;

  /// Requests an image. `is_moved`: the plane or the structures changed, so that images of previous requests
  /// are discarded.
  void request(std::shared_ptr<const volume::Version> version, std::vector<Structure> structures,
               const volume::Openings::Plane& plane, bool is_moved = true);
  /// Discards all requests and their images.
  void clear();
  /// Returns the newest finished image once. Without `is_moved`, it may be the image of a previous request.
  std::optional<CapImage> take();
  /// Waits until the newest request is finished.
  void finish();
  bool is_complete() const { return !job_.valid() && !waiting_ && !done_; }

 private:
  struct Request {
    std::shared_ptr<const volume::Version> version;
    std::vector<Structure> structures;
    volume::Openings::Plane plane;
  };
  void start();
  void collect();

  const haptics::TouchScene* scene_;
  std::optional<Request> waiting_;
  std::future<CapImage> job_;
  bool is_discarded_ = false;  ///< the image of the running job is not used
  std::optional<CapImage> done_;
};

}  // namespace trephine::view
