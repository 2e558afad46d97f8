// apps/study/gpu: two ways to cull on the GPU that E. T. Carlos describes in "Frustum Culling Híbrido Utilizando CPU e
// GPU" (2009, chapter 5), as they were but for the errors, to be compared with production (culling/gpu): the test in
// the primitive's own draw (in_draw.h), and a point per box with its answer read back (flat.h). Uses study, culling,
// gl, gpuscene, render.
//
// Both are conservative: a box that meets the view volume is kept, and one is kept needlessly only within float
// rounding of a plane. Section planes that unite, and layers, are not looked at.
//
// This header: the planes of a view as these shaders read them.
#pragma once

#include <span>

#include "sightline/core/item_bounds.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/gl/internal/buffer.h"

namespace sightline::study {

/// Texture unit and uniform block, apart from those that render's shaders use (0 to 3, and block 0).
inline constexpr GLuint kBoxUnit = 4, kPlaneBinding = 1;

/// The uniform block StudyPlanes of shaders/box_test.glsl.
class GpuPlanes {
 public:
  static core::Expected<GpuPlanes> create(const gl::Functions& gl);

  /// Writes and binds the block. `bounds`: those that `planes` were made for.
  void upload(const culling::CullPlanes& planes, const core::ItemBounds& bounds) const;

 private:
  const gl::Functions* gl_ = nullptr;
  gl::Buffer block_;
};

/// A buffer and its view through a texture buffer.
struct TexelArray {
  gl::Buffer buffer;
  gl::TextureBuffer texels;

  template <class T, std::size_t N>
  static core::Expected<TexelArray> create(const gl::Functions& gl, std::span<T, N> values, GLenum format,
                                           GLbitfield flags, std::string_view what) {
    auto buffer = gl::Buffer::create(gl, values, flags, what);
    if (!buffer) return tl::unexpected(buffer.error());
    auto texels = gl::TextureBuffer::create(gl, *buffer, format, what);
    if (!texels) return tl::unexpected(texels.error());
    return TexelArray{std::move(*buffer), std::move(*texels)};
  }
};

/// Bounds that hold nothing but the extent of `boxes`: all that CullPlanes asks of them.
core::ItemBounds extent_of(std::span<const core::Aabb> boxes);

}  // namespace sightline::study
