#include "sightline/gpuscene/internal/mesh_pool.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "sightline/lod/internal/solid_shells.h"

namespace sightline::gpuscene {
namespace {

using core::kNoItem;
using core::kNone;
using core::Slot;
using core::Snapshot;

constexpr std::size_t kVertexPiece = 8192, kIndexPiece = 65536;  // staged at a time: a fraction of a millisecond
constexpr std::size_t kLeastDone = 16384;  // elements of a call, so that edits cannot keep uploads from ending

std::uint32_t snorm16(float v) {
  return std::uint16_t(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
}

}  // namespace

std::uint32_t pack_normal(const core::vec3& normal) {
  const float sum = std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z);
  if (!(sum > 0.0f) || !std::isfinite(sum)) return kNoNormal;
  glm::vec2 p = glm::vec2(normal) / sum;
  if (normal.z < 0.0f) p = {std::copysign(1.0f - std::abs(p.y), p.x), std::copysign(1.0f - std::abs(p.x), p.y)};
  return snorm16(p.x) | snorm16(p.y) << 16;
}

bool flat_shaded(const Snapshot& snapshot, Slot slot) {
  return int(snapshot.kind(slot)) >= core::kPrimitiveKindCount && snapshot.mesh(slot).normals.empty();
}

// --- records ---------------------------------------------------------------------------------------------------------

void MeshPool::add(const Snapshot& snapshot, Slot slot) {
  const bool given_up = snapshot.item(slot) == kNoItem;  // it never shows again
  const std::uint32_t shape = given_up ? kNone : shape_of(snapshot.share_mesh(slot));
  if (shape != kNone) ++shapes_[shape].users;
  hidden_.push_back(snapshot.vacant(slot));
  shape_of_record_.push_back(shape);
}

void MeshPool::update(const Snapshot& snapshot, Slot slot, std::uint32_t record) {
  hidden_[record] = snapshot.vacant(slot);
  if (snapshot.item(slot) != kNoItem || shape_of_record_[record] == kNone) return;
  const std::uint32_t shape = std::exchange(shape_of_record_[record], kNone);
  if (--shapes_[shape].users == 0) release(shape);
}

/// Null where nothing of a record's mesh is drawn.
const MeshPool::Shape* MeshPool::drawn_shape(std::uint32_t record) const {
  const std::uint32_t shape = shape_of_record_[record];
  return shape != kNone && shapes_[shape].drawn ? &shapes_[shape] : nullptr;
}

DrawnMesh MeshPool::drawn(std::uint32_t record) const {
  const Shape* shape = drawn_shape(record);
  if (!shape) return {{0, 0, 0, 0, record}, nullptr, 0};
  const std::uint32_t instances = hidden_[record] ? 0 : 1;
  return {{shape->index_count, instances, shape->first_index, std::int32_t(shape->first_vertex), record},
          shape->levels.get(),
          shape->solid_indices.value_or(0)};
}

std::shared_ptr<const lod::MeshLevels> MeshPool::share_levels(std::uint32_t record) const {
  const Shape* shape = drawn_shape(record);
  return shape ? shape->levels : nullptr;
}

// --- meshes ----------------------------------------------------------------------------------------------------------

/// kNone where there is no mesh.
std::uint32_t MeshPool::shape_of(std::shared_ptr<const core::Mesh> mesh) {
  if (!mesh) return kNone;
  const auto [place, fresh] = shape_of_mesh_.try_emplace(mesh.get(), std::uint32_t(shapes_.size()));
  if (!fresh) return place->second;
  if (unused_shapes_.empty()) {
    shapes_.emplace_back();
  } else {
    place->second = unused_shapes_.back();
    unused_shapes_.pop_back();
  }
  Shape& shape = shapes_[place->second];
  shape.serial = ++serial_;
  queue(new_meshes_, {place->second, shape.serial, nullptr, calls_, mesh->positions.size(), mesh->indices.size()});
  shape.mesh = std::move(mesh);
  new_shapes_.push_back(place->second);
  return place->second;
}

void MeshPool::release(std::uint32_t index) {
  Shape& shape = shapes_[index];
  if (current_.shape != kNone && current_.serial == shape.serial) give_back_current();
  if (shape.drawn) {
    vertices_.give_back(shape.first_vertex, shape.vertex_count);
    indices_.give_back(shape.first_index, index_room(shape));
  }
  shape_of_mesh_.erase(shape.mesh.get());
  gone_meshes_.push_back(std::move(shape.mesh));
  shape = {};
  unused_shapes_.push_back(index);
}

std::vector<std::shared_ptr<const core::Mesh>> MeshPool::take_new_meshes(std::size_t most) {
  std::vector<std::shared_ptr<const core::Mesh>> meshes;
  for (; meshes.size() < most && !new_shapes_.empty(); new_shapes_.pop_back())
    if (shapes_[new_shapes_.back()].mesh) meshes.push_back(shapes_[new_shapes_.back()].mesh);
  return meshes;
}

std::vector<std::shared_ptr<const core::Mesh>> MeshPool::take_gone_meshes() {
  auto meshes = std::exchange(gone_meshes_, {});
  std::erase_if(meshes, [&](const auto& mesh) { return has(*mesh); });
  return meshes;
}

std::vector<std::shared_ptr<const core::Mesh>> MeshPool::meshes() const {
  std::vector<std::shared_ptr<const core::Mesh>> meshes;
  for (const Shape& shape : shapes_)
    if (shape.mesh) meshes.push_back(shape.mesh);
  return meshes;
}

void MeshPool::add_levels(std::span<const LevelsOfMesh> levels) {
  for (const LevelsOfMesh& of : levels) {
    const auto place = shape_of_mesh_.find(of.mesh.get());
    if (place == shape_of_mesh_.end() || of.levels->empty()) continue;
    queue(new_levels_, {place->second, shapes_[place->second].serial, of.levels, calls_, 0, of.levels->indices.size()});
  }
}

void MeshPool::queue(std::deque<Upload>& uploads, Upload upload) {
  waiting_vertices_ += upload.vertex_count;
  waiting_indices_ += upload.index_count;
  uploads.push_back(std::move(upload));
}

// --- uploading -------------------------------------------------------------------------------------------------------

core::Expected<bool> MeshPool::upload(const gl::Functions& gl, core::Deadline deadline, bool levels) {
  const std::uint64_t least = elements_done_ + kLeastDone;
  core::Expected<bool> more;
  do more = step(gl, levels, deadline == core::kNoDeadline);
  while (more && *more && (elements_done_ < least || !core::over(deadline)));
  write_staged();
  vertices_.free_scratch();
  indices_.free_scratch();
  ++calls_;
  if (!more) return more;
  return current_.shape == kNone && new_meshes_.empty() && (!levels || (!*more && new_levels_.empty()));
}

/// Does a little of what comes next. Returns whether there was anything to do.
core::Expected<bool> MeshPool::step(const gl::Functions& gl, bool levels, bool find_solids) {
  if (vertices_.moving()) return move(gl, vertices_, &Shape::first_vertex, vertex_room);
  if (indices_.moving()) return move(gl, indices_, &Shape::first_index, index_room);
  if (current_.shape == kNone && !begin_next(levels, find_solids)) return pack_if_wasteful(gl);
  auto room = make_room(gl, vertices_, waiting_vertices_);
  if (room) room = make_room(gl, indices_, waiting_indices_);
  if (!room) return tl::unexpected(room.error());
  if (vertices_.moving() || indices_.moving()) return true;
  Current& c = current_;
  const core::Mesh& mesh = *shapes_[c.shape].mesh;
  const std::size_t vertices = std::min(kVertexPiece, c.vertex_count - c.vertices);
  for (Vertex& vertex : vertices_.stage(c.first_vertex + std::uint32_t(c.vertices), vertices)) {
    const std::size_t i = c.vertices++;
    vertex = {mesh.positions[i], mesh.normals.empty() ? kNoNormal : pack_normal(mesh.normals[i])};
  }
  const std::vector<std::uint32_t>& from = c.levels ? c.levels->indices : c.ordered.empty() ? mesh.indices : c.ordered;
  const std::size_t indices = std::min(kIndexPiece, c.index_count - c.indices);
  const auto to = indices_.stage(c.first_index + std::uint32_t(c.indices), indices);
  std::copy_n(from.begin() + std::ptrdiff_t(c.indices), indices, to.begin());
  c.indices += indices;
  elements_done_ += vertices + indices;
  if (c.vertices == c.vertex_count && c.indices == c.index_count) end_current();
  if (vertices_.staged() >= kVertexPiece || indices_.staged() >= kIndexPiece) write_staged();
  return true;
}

/// Takes the next upload and places for it. Levels come once all meshes are there.
bool MeshPool::begin_next(bool levels, bool find_solids) {
  while (!new_meshes_.empty() || (levels && !new_levels_.empty())) {
    std::deque<Upload>& uploads = new_meshes_.empty() ? new_levels_ : new_meshes_;
    Current next{std::move(uploads.front()), 0, 0, 0, 0, {}, {}};
    uploads.pop_front();
    waiting_vertices_ -= next.vertex_count;
    waiting_indices_ -= next.index_count;
    const Shape& shape = shapes_[next.shape];
    if (shape.serial != next.serial) continue;  // the mesh is gone
    if (next.levels) {
      // Levels from a file may be those of another mesh.
      const std::uint32_t solid = next.levels->solid_indices;
      if (shape.levels == next.levels || shape.solid_indices.value_or(solid) != solid) continue;
      next.solid_indices = solid;
    } else if (find_solids || !lod::is_large(*shape.mesh)) {
      next.ordered = shape.mesh->indices;
      next.solid_indices = lod::solid_shells_first(shape.mesh->positions, next.ordered);
    }
    next.first_vertex = vertices_.take(std::uint32_t(next.vertex_count));
    next.first_index = indices_.take(std::uint32_t(next.index_count));
    current_ = std::move(next);
    return true;
  }
  return false;
}

void MeshPool::give_back_current() {
  vertices_.give_back(current_.first_vertex, std::uint32_t(current_.vertex_count));
  indices_.give_back(current_.first_index, std::uint32_t(current_.index_count));
  current_ = {};
}

/// Draws it from now on. What is staged is written before anything draws.
void MeshPool::end_current() {
  Current done = std::exchange(current_, {});
  Shape& shape = shapes_[done.shape];
  if (done.levels) {
    indices_.give_back(shape.first_index, index_room(shape));
    has_levels_ = true;
  } else {
    shape.first_vertex = done.first_vertex;
    shape.vertex_count = std::uint32_t(done.vertex_count);
    shape.index_count = std::uint32_t(done.index_count);
    shape.drawn = true;
  }
  shape.first_index = done.first_index;
  shape.solid_indices = done.solid_indices;
  shape.levels = std::move(done.levels);
  if (shape.levels || done.call != calls_) ++version_;
}

void MeshPool::write_staged() {
  vertices_.write();
  indices_.write();
}

// --- memory ----------------------------------------------------------------------------------------------------------

/// `waiting`: elements that are to come beside those that have places.
template <class Element>
core::Expected<void> MeshPool::make_room(const gl::Functions& gl, ElementStore<Element>& store, std::size_t waiting) {
  if (store.has_room()) return {};
  write_staged();
  return store.begin_growth(gl, waiting, has_levels_ ? 8 : 2);
}

/// Moves some of a store's elements to its other buffer, and draws from there once all are.
template <class Element>
bool MeshPool::move(const gl::Functions& gl, ElementStore<Element>& store, std::uint32_t Shape::*first,
                    std::uint32_t (*room)(const Shape&)) {
  const bool done = store.move(gl);
  elements_done_ += ElementStore<Element>::kMovedBytes / sizeof(Element);
  if (!done) return true;
  if (store.packing()) {
    for (Shape& shape : shapes_)
      if (shape.drawn && room(shape) > 0) shape.*first = store.packed_place(shape.*first);
    ++version_;
  }
  store.end_move();
  return true;
}

/// Begins to move what is in use where that is less than half of a buffer. Returns whether it is.
core::Expected<bool> MeshPool::pack_if_wasteful(const gl::Functions& gl) {
  const auto begin = [&](auto& store, std::uint32_t Shape::*first, std::uint32_t (*room)(const Shape&)) {
    using Run = typename std::remove_reference_t<decltype(store)>::Run;
    std::vector<Run> runs;
    ++packs_;
    for (const Shape& shape : shapes_)
      if (shape.drawn && room(shape) > 0) runs.push_back({shape.*first, room(shape)});
    return store.begin_packing(gl, std::move(runs)).map([] { return true; });
  };
  if (!new_levels_.empty()) return false;  // they may need the room
  write_staged();
  if (vertices_.is_wasteful()) return begin(vertices_, &Shape::first_vertex, vertex_room);
  if (indices_.is_wasteful()) return begin(indices_, &Shape::first_index, index_room);
  return false;
}

}  // namespace sightline::gpuscene
