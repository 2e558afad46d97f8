// The structures of apps/study/rays in GPU memory, as flat arrays that the shaders read.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/apps/study/rays/traversals.h"
#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/buffer.h"

namespace sightline::study::rays {

/// Storage bindings that shaders/query.glsl, shaders/trace.comp and the traversals' own shaders share.
enum class Binding : GLuint { kRays, kAnswers, kCorners, kTriangles, kNodes, kMore, kYetMore, kNextTile };

/// A set's triangles: nine floats each.
struct GpuTriangles {
  gl::Buffer corners;
};

/// One structure of a set of triangles. `arrays`: bound from Binding::kTriangles on; those it does not have are empty.
struct GpuStructure {
  gl::Buffer space;
  std::array<gl::Buffer, 4> arrays;
};

/// Uploading fails when the GPU has not the memory, or an array is larger than the context's storage blocks may be.
core::Expected<GpuTriangles> upload(const gl::Context& context, const TriangleSet& triangles);
core::Expected<GpuStructure> upload(const gl::Context& context, const Structures& structures, Structure structure);
core::Expected<GpuStructure> upload(const gl::Context& context, const TriangleSet& triangles, const UniformGrid& grid);

/// A buffer of at least `bytes`, for a storage block; `data` may be null, and `bytes` 0.
core::Expected<gl::Buffer> make_storage(const gl::Context& context, std::size_t bytes, const void* data,
                                        const char* what);

}  // namespace sightline::study::rays
