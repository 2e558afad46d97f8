// Filled caps where section planes cut meshes. (Ray-cast solids fill their own, see gpuprims/shaders/search.glsl.)
#pragma once

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::render {

/// Along a pixel's ray what the sections keep begins behind one plane at most: section planes keep a convex part, and
/// when they unite leave out one. So a pixel shows one point of a cut face, or none. That point is inside a closed mesh
/// when behind it the ray leaves the mesh once more than it enters it: counted over all meshes at once, with atomic
/// adds, however deep they are stacked. The sum of the records counted, forth and back, is then the record of the one
/// mesh the point is in. Only where it is in several, a second pass lists the crossings of the pixel, and the first
/// mesh of those it is in is shown: lists have room for kListed crossings a pixel on average; beyond that some such
/// pixel shows the item of another mesh of its list. Exact up to rasterisation otherwise. Multisampled targets get
/// whole pixels of it: the outlines of cut faces of meshes stay jagged.
///
/// Meshes that are not closed (core::enclosure) have no inside and stay open where they are cut.
///
/// Costs nothing before a view has sections: then three programs, 12 bytes a pixel and 8 kListed for the lists, a byte
/// for each mesh item, and once for each mesh the time to see whether it is closed.
class SectionCaps {
 public:
  static constexpr int kListed = 4;

  static core::Expected<SectionCaps> create(const gl::Functions& gl, const gl::ShaderContext& shaders);

  /// Makes room for a target of that size and learns which meshes are closed.
  core::Expected<void> prepare(const core::Snapshot& snapshot, const gpuscene::Batch& meshes, int width, int height);

  /// Counts crossings: `draw_meshes` must draw the batch of meshes with the program that is in use, to a target whose
  /// depth and colour are not written. Then draws the caps into the bound framebuffer, with depth test.
  template <class DrawMeshes>
  void draw(const DrawMeshes& draw_meshes) const {
    begin_counting();
    draw_meshes();
    begin_listing();
    draw_meshes();
    draw_caps();
  }

  std::size_t memory_bytes() const { return cells_.size() + nodes_.size() + enclosures_.size(); }

 private:
  void begin_counting() const;
  void begin_listing() const;
  void draw_caps() const;

  const gl::Functions* gl_ = nullptr;
  gl::Program count_, list_, caps_;
  gl::VertexArray no_attributes_;
  gl::Buffer cells_, nodes_, enclosures_;
  gl::TextureBuffer enclosure_texels_;
  int width_ = 0, height_ = 0;
  std::size_t mesh_count_ = 0;
};

}  // namespace sightline::render
