#include "sightline/apps/study/rays/gpu/structures.h"

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace sightline::study::rays {
namespace {

/// The uniform block Space of query.glsl, in its layout.
struct SpaceBlock {
  std::array<float, 4> low{}, high{}, cell{}, per_cell{};
  std::array<std::int32_t, 4> cells{};
  double slack = 0.0, unused = 0.0;
};
static_assert(sizeof(SpaceBlock) == 96);

// Shaders read these as they lie.
static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(core::Aabb) == 24 && sizeof(TriangleSet::Corners) == 36 && sizeof(KdTreeWithRopes::Leaf) == 56 &&
              sizeof(SparseBoxGrid::Box) == 20);

std::array<float, 4> four(const core::vec3& v) {
  return {v.x, v.y, v.z, 0.0f};
}

SpaceBlock space_of(const TriangleSet& triangles) {
  SpaceBlock block;
  block.slack = 0.5 * double(UnitSpace::kSlack) * triangles.space().size;
  return block;
}

SpaceBlock space_of(const TriangleSet& triangles, const core::Aabb& bounds) {
  SpaceBlock block = space_of(triangles);
  block.low = four(bounds.min), block.high = four(bounds.max);
  return block;
}

SpaceBlock space_of(const TriangleSet& triangles, const GridLines& lines) {
  SpaceBlock block = space_of(triangles);
  block.low = four(lines.low), block.cell = four(lines.cell), block.per_cell = four(lines.per_cell);
  for (std::size_t a = 0; a < 3; ++a) block.cells[a] = lines.cells[a];
  return block;
}

template <class... T>
core::Expected<GpuStructure> upload_arrays(const gl::Context& context, const SpaceBlock& block,
                                           const std::vector<T>&... arrays) {
  static_assert((std::is_trivially_copyable_v<T> && ...));
  auto space = gl::Buffer::create(context.functions(), sizeof block, &block, 0, "space of a structure");
  if (!space) return tl::unexpected(space.error());
  GpuStructure result;
  result.space = std::move(*space);
  core::Expected<void> done;
  std::size_t next = 0;
  const auto add = [&](std::size_t bytes, const void* data) {
    if (!done) return;
    auto made = make_storage(context, bytes, data, "array of a structure");
    if (made)
      result.arrays[next++] = std::move(*made);
    else
      done = tl::unexpected(made.error());
  };
  (add(arrays.size() * sizeof(T), arrays.data()), ...);
  if (!done) return tl::unexpected(done.error());
  return result;
}

}  // namespace

core::Expected<gl::Buffer> make_storage(const gl::Context& context, std::size_t bytes, const void* data,
                                        const char* what) {
  constexpr std::size_t kLeast = 64;  // of any shader's element: what is empty is never read, but must be bound
  const std::size_t most = std::size_t(context.capabilities().max_storage_block_bytes);
  if (bytes > most)
    return core::fail(std::string(what) + ": " + std::to_string(bytes) + " bytes, and the context's storage blocks " +
                      "have at most " + std::to_string(most));
  if (bytes >= kLeast) return gl::Buffer::create(context.functions(), bytes, data, 0, what);
  std::array<std::byte, kLeast> padded{};
  if (data != nullptr && bytes > 0) std::memcpy(padded.data(), data, bytes);
  return gl::Buffer::create(context.functions(), padded.size(), padded.data(), 0, what);
}

core::Expected<GpuTriangles> upload(const gl::Context& context, const TriangleSet& triangles) {
  const std::size_t bytes = triangles.size() * sizeof(TriangleSet::Corners);
  auto corners = make_storage(context, bytes, triangles.size() == 0 ? nullptr : &triangles.corners(0), "triangles");
  if (!corners) return tl::unexpected(corners.error());
  return GpuTriangles{std::move(*corners)};
}

core::Expected<GpuStructure> upload(const gl::Context& context, const TriangleSet& triangles, const UniformGrid& grid) {
  return upload_arrays(context, space_of(triangles, grid.lines), grid.triangles, grid.begins);
}

core::Expected<GpuStructure> upload(const gl::Context& context, const Structures& s, Structure structure) {
  const SpaceBlock plain = space_of(s.triangles);
  switch (structure) {
    case Structure::kOctree:
      return upload_arrays(context, space_of(s.triangles, s.octree.bounds), s.octree.triangles, s.octree.nodes);
    case Structure::kGrid:
      return upload(context, s.triangles, s.grid);
    case Structure::kKdTree:
      return upload_arrays(context, plain, s.kd.triangles, s.kd.nodes);
    case Structure::kKdTreeWithParents:
      return upload_arrays(context, plain, s.kd.triangles, s.kd.nodes, s.kd_parents.parents, s.kd_parents.boxes);
    case Structure::kKdTreeWithRopes:
      return upload_arrays(context, plain, s.kd.triangles, s.kd_ropes.nodes, s.kd_ropes.leaves);
    case Structure::kBvh:
      return upload_arrays(context, plain, s.bvh.triangles, s.bvh.nodes);
    case Structure::kBih:
      return upload_arrays(context, plain, s.bih.triangles, s.bih.nodes);
    case Structure::kSbg:
      return upload_arrays(context, space_of(s.triangles, s.sbg.lines), s.sbg.triangles, s.sbg.boxes,
                           s.sbg.box_of_cell);
  }
  return core::fail("no such structure");
}

}  // namespace sightline::study::rays
