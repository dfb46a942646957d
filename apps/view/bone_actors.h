// BoneActors: actors of the bone's chunks, of coarse groups of chunks and of reduced surfaces, and the choice
// of those that the next frame draws. Coarse groups are simplified chunks, drawn while the view moves.
// Reduced surfaces are quick meshes of whole shapes, shown until the chunks of a scan are finished.
#pragma once

#include <array>
#include <functional>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>
#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkSmartPointer.h>

#include "apps/view/tints.h"

class vtkRenderer;

namespace trephine::view {

/// Adds actors to a renderer, which must outlive this object. The draw functions choose the actors that the
/// next frame shows, and return the number of triangles of these actors. Drawing thread only.
class BoneActors {
 public:
  using Key = std::array<int, 4>;  ///< chunk and shape
  /// World box.
  struct Box {
    glm::dvec3 low{1e300}, high{-1e300};
    bool is_empty() const;
  };

  /// `has_coarse`: keeps coarse chunks, for draw_coarse().
  BoneActors(vtkRenderer* renderer, bool has_coarse) : renderer_(renderer), has_coarse_(has_coarse) {}

  struct Change {
    std::array<Box, 2> boxes;  ///< box of the chunk's changed part, before and after the change
    std::optional<Key> chunk;  ///< the shown chunk; nullopt if it was removed, or is empty
  };
  /// Shows a chunk in place of its previous state.
  Change show(const ChunkMesh& mesh);
  void add_reduced(const ChunkMesh& mesh);
  /// Returns false if there are no reduced surfaces.
  bool remove_reduced();
  bool has_reduced() const noexcept { return !reduced_.empty(); }
  void clear();
  /// Returns false if the shape has no chunks.
  bool remove_shape(std::size_t shape);
  /// Hides these shapes, by number, and no others. Returns false if exactly these shapes are already hidden.
  /// The next draw function applies it.
  bool set_hidden(std::set<std::size_t> shapes);
  /// Draws only the side of the plane to which `normal` points. A zero normal removes the plane.
  void set_clip(const glm::dvec3& origin, const glm::dvec3& normal);

  std::size_t draw_all();
  std::size_t draw_coarse();
  std::size_t draw_reduced();
  void draw_nothing();
  /// Draws a chunk in addition to the others, unless its shape is hidden. Returns its number of triangles.
  std::size_t draw_chunk(const Key& chunk);
  std::size_t draw_where(const std::function<bool(const Box&)>& is_drawn);

  std::vector<Key> chunks() const;
  std::size_t chunk_count() const noexcept { return chunks_.size(); }
  std::size_t triangle_count() const noexcept { return triangles_; }
  std::size_t coarse_triangle_count() const;
  /// Box of all chunks and reduced surfaces.
  Box bounds() const;

 private:
  struct Chunk {
    vtkSmartPointer<vtkActor> actor;
    Box box;
    std::size_t triangles = 0;
    DrawMesh coarse;
  };
  struct Group {  ///< coarse chunks with one actor
    vtkSmartPointer<vtkActor> actor;
    std::vector<Key> chunks;
    std::size_t triangles = 0;
    bool is_stale = true;
  };
  struct Reduced {
    std::size_t shape;
    vtkSmartPointer<vtkActor> actor;
    std::size_t triangles = 0;
  };
  vtkSmartPointer<vtkActor> add_actor(std::size_t shape) const;
  bool is_shown(std::size_t shape) const { return hidden_.count(shape) == 0; }
  bool is_shown(const Key& key) const { return is_shown(static_cast<std::size_t>(key[3])); }
  void refresh_groups();

  vtkRenderer* renderer_;
  bool has_coarse_;
  std::map<Key, Chunk> chunks_;
  std::map<Key, Group> groups_;
  std::map<std::size_t, Tint> tints_;  ///< of shapes
  std::vector<Reduced> reduced_;
  Box reduced_box_;
  std::size_t triangles_ = 0;
  std::set<std::size_t> hidden_;  ///< shapes
  vtkNew<vtkPlane> clip_;
  bool is_clipped_ = false;
};

}  // namespace trephine::view
