// Filled caps where section planes cut meshes. (Ray-cast solids fill their own caps, see gpuprims/shaders/search.glsl.)
#pragma once

#include <array>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::render {

/// Section planes keep a convex part of space, or leave out one when they unite. So along a pixel's ray the kept part
/// begins behind at most one plane, and a pixel shows at most one point of a cut face. That cut point is inside a
/// closed mesh when the ray leaves the mesh once more behind it than it enters the mesh.
///
/// A first pass counts the crossings of all meshes at once with atomic adds, however many meshes lie behind each other.
/// It also sums up the records, added where the ray leaves and subtracted where it enters. If the cut point is in one
/// mesh, the sum is the record of that mesh. If it is in several, a second pass lists the crossings of the pixel, and
/// the pixel shows the first of the meshes that the point is in. The lists have room for kListed crossings per pixel on
/// average. With more crossings, some pixels with several such meshes show the item of another mesh of their list.
/// Otherwise the result is exact up to rasterisation. In multisampled targets caps cover whole pixels: the outlines of
/// cut faces of meshes stay jagged.
///
/// Meshes that are not closed (core::enclosure) have no inside and get no caps.
///
/// Costs nothing before the first view with sections. From then on it costs three programs, 12 + 8 * kListed bytes per
/// pixel, a byte per mesh item, and once per mesh the time to find whether it is closed.
class SectionCaps {
 public:
  static constexpr int kListed = 4;

  static core::Expected<SectionCaps> create(const gl::Functions& gl, const gl::ShaderContext& shaders);
  /// The programs: crossings counted, crossings listed, caps.
  static std::array<gl::ProgramDescription, 3> describe(const gl::ShaderContext& shaders);

  /// Makes room for a target of that size and finds which meshes are closed, once for each scene.
  core::Expected<void> prepare(const core::Snapshot& snapshot, const gpuscene::GpuScene& scene, int width, int height);

  /// Counts crossings, then draws the caps into `image` with the state that is set, and leaves it bound. `draw_meshes`
  /// must draw the batch of meshes with the program and the framebuffer that are in use.
  template <class DrawMeshes>
  void draw(const gl::Framebuffer& image, const DrawMeshes& draw_meshes) const {
    begin_counting();
    draw_meshes();
    begin_listing();
    draw_meshes();
    draw_caps(image);
  }

  /// The program that draws caps, for uniforms of its shading.
  const gl::Program& caps() const { return caps_; }
  std::size_t memory_bytes() const { return cells_.size() + nodes_.size(); }

 private:
  void begin_counting() const;
  void begin_listing() const;
  void draw_caps(const gl::Framebuffer& image) const;

  const gl::Functions* gl_ = nullptr;
  gl::Program count_, list_, caps_;
  gl::VertexArray no_attributes_;
  gl::Buffer cells_, nodes_;
  gl::Framebuffer crossings_;                                         // of one sample per pixel, without attachments
  std::shared_ptr<const gpuscene::MeshPool::Enclosures> enclosures_;  // of the scene that is drawn
  int width_ = 0, height_ = 0;
};

}  // namespace sightline::render
