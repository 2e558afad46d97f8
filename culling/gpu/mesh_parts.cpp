#include "sightline/culling/gpu/internal/mesh_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/core/internal/sort_unique.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::culling {
namespace {

using core::dvec3;
using core::kNone;

constexpr std::uint32_t kClusterTexels = 3, kGroupTexels = 2, kInstanceTexels = 4;  // as in part_data.glsl
constexpr float kMoreError = 1.0f + 1e-5f;  // clusters are left out only where no part could think otherwise

std::uint32_t bits(float value) {
  return std::bit_cast<std::uint32_t>(value);
}

double largest_row_sum(const core::dmat3& m) {
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) largest = std::max(largest, std::abs(m[0][i]) + std::abs(m[1][i]) + std::abs(m[2][i]));
  return largest;
}

/// At least the largest factor by which a linear map stretches. Exact for a rotation after or before a scale along the
/// axes.
double stretch(const core::dmat3& m) {
  const core::dmat3 t = glm::transpose(m);
  return std::sqrt(std::min(largest_row_sum(t * m), largest_row_sum(m * t))) * (1.0 + 1e-9);
}

/// Makes room for so many bytes, and for some more, up to `most`.
core::Expected<void> make_room(const gl::Functions& gl, gl::TexelArray& array, std::size_t bytes, std::size_t step,
                               std::size_t most, const char* what) {
  if (bytes <= array.buffer.size()) return {};
  const std::size_t more = std::min(most, (bytes + bytes / 4) / step * step);
  auto buffer = array.buffer.enlarged(gl, std::max(bytes, more), GL_DYNAMIC_STORAGE_BIT, what);
  if (!buffer) return tl::unexpected(buffer.error());
  auto texels = gl::TextureBuffer::create(gl, *buffer, GL_RGBA32UI, what);
  if (!texels) return tl::unexpected(texels.error());
  array = {std::move(*buffer), std::move(*texels)};
  return {};
}

}  // namespace

bool MeshParts::differs(const gpuscene::MeshPool& pool, std::uint32_t record) const {
  const std::uint32_t instance = instance_of(record);
  if (instance == kNone) return pool.levels(record) != nullptr;
  const Mesh& mesh = meshes_[instances_[instance].mesh];
  const gpuscene::ElementsCommand command = pool.command(record);
  return pool.levels(record) != mesh.levels.get() || command.first_index != mesh.first_index ||
         command.base_vertex != mesh.base_vertex;
}

core::Expected<void> MeshParts::update(const gl::Functions& gl, const core::Snapshot& snapshot,
                                       const gpuscene::MeshPool& pool, std::span<const std::uint32_t> records,
                                       std::span<const core::Slot> slots, gpuscene::ElementWriter& writer) {
  // All that draw a mesh let go of it first: it may have another place.
  for (const std::uint32_t record : records)
    if (has(record) && differs(pool, record)) release(instance_of(record));
  for (const std::uint32_t record : records) {
    if (!has(record) && pool.levels(record)) add(record, pool.share_levels(record), pool.command(record));
    if (has(record)) place(snapshot, instance_of(record), slots[record]);
  }
  return flush(gl, snapshot, slots, writer);
}

/// Does nothing where there is no room.
void MeshParts::add(std::uint32_t record, std::shared_ptr<const lod::MeshLevels> levels,
                    const gpuscene::ElementsCommand& command) {
  const auto count = std::uint32_t(levels->clusters.size());
  const std::uint32_t first = space_.take(count);
  if (cluster_count() > most_clusters_) return space_.give_back(first, count);
  Instance instance{record, mesh_of(std::move(levels), command), detail_space_.take(kInstanceTexels), first};
  ++meshes_[instance.mesh].users;
  std::uint32_t number = std::uint32_t(instances_.size());
  if (unused_instances_.empty()) {
    instances_.push_back(instance);
  } else {
    number = unused_instances_.back();
    unused_instances_.pop_back();
    instances_[number] = instance;
  }
  if (record >= instance_of_record_.size()) instance_of_record_.resize(record + 1, kNone);
  instance_of_record_[record] = number;
  parts_.resize(std::max<std::size_t>(parts_.size(), std::size_t(cluster_count()) * kItemsPerCluster));
  for (std::uint32_t i = 0; i < count; ++i) parts_[first + i] = {number, i};
}

void MeshParts::place(const core::Snapshot& snapshot, std::uint32_t number, core::Slot slot) {
  const Instance& instance = instances_[number];
  const core::Affine world = snapshot.world_from_item(slot);
  const dvec3 origin = world.origin - snapshot.bounds().origin;
  for (std::uint32_t row = 0; row < 3; ++row) {
    const auto along = [&](int column) { return bits(float(world.linear[column][int(row)])); };
    write(instance.details + row, {along(0), along(1), along(2), bits(float(origin[int(row)]))});
  }
  write(instance.details + 3, {bits(core::round_up(stretch(world.linear))), instance.record,
                               std::uint32_t(meshes_[instance.mesh].base_vertex), 0});
  mark(instance);
}

void MeshParts::release(std::uint32_t number) {
  const Instance& instance = instances_[number];
  Mesh& mesh = meshes_[instance.mesh];
  const auto count = std::uint32_t(mesh.levels->clusters.size());
  mark(instance);
  std::fill_n(parts_.begin() + instance.first_part, count, Part());
  space_.give_back(instance.first_part, count);
  detail_space_.give_back(instance.details, kInstanceTexels);
  instance_of_record_[instance.record] = kNone;
  unused_instances_.push_back(number);
  if (--mesh.users > 0) return;
  detail_space_.give_back(mesh.details,
                          kClusterTexels * count + kGroupTexels * std::uint32_t(mesh.levels->groups.size()));
  mesh_of_levels_.erase(mesh.levels.get());
  mesh.levels = nullptr;
  unused_meshes_.push_back(instance.mesh);
}

/// The clusters of an instance's parts.
void MeshParts::mark(const Instance& instance) {
  const std::size_t end = instance.first_part + meshes_[instance.mesh].levels->clusters.size();
  for (std::uint32_t c = instance.first_part / kItemsPerCluster; c * std::size_t(kItemsPerCluster) < end; ++c)
    if (changed_.empty() || changed_.back() != c) changed_.push_back(c);
}

std::uint32_t MeshParts::mesh_of(std::shared_ptr<const lod::MeshLevels> levels,
                                 const gpuscene::ElementsCommand& command) {
  const auto [present, fresh] = mesh_of_levels_.try_emplace(levels.get(), std::uint32_t(meshes_.size()));
  if (!fresh) return present->second;
  if (unused_meshes_.empty()) {
    meshes_.emplace_back();
  } else {
    present->second = unused_meshes_.back();
    unused_meshes_.pop_back();
  }
  const std::size_t texels = kClusterTexels * levels->clusters.size() + kGroupTexels * levels->groups.size();
  Mesh& mesh = meshes_[present->second];
  mesh = {std::move(levels), detail_space_.take(std::uint32_t(texels)), 0, command.first_index, command.base_vertex};
  write_mesh(mesh);
  return present->second;
}

void MeshParts::write_mesh(const Mesh& mesh) {
  const lod::MeshLevels& levels = *mesh.levels;
  std::uint32_t place = mesh.details;
  const std::uint32_t groups = place + kClusterTexels * std::uint32_t(levels.clusters.size());
  const auto write_corner = [&](const core::vec3& corner, std::uint32_t word) {
    write(place++, {bits(corner.x), bits(corner.y), bits(corner.z), word});
  };
  const auto details_of = [&](std::uint32_t group) { return group == kNone ? kNone : groups + kGroupTexels * group; };
  for (const lod::Cluster& cluster : levels.clusters) {
    write_corner(cluster.box.min, mesh.first_index + cluster.first_index);
    write_corner(cluster.box.max, cluster.index_count);
    write(place++, {details_of(cluster.made_by), details_of(cluster.goes_into), 0, 0});
  }
  for (const lod::ClusterGroup& group : levels.groups) {
    write_corner(group.box.min, bits(group.error));
    write_corner(group.box.max, 0);
  }
}

MeshParts::Cluster MeshParts::make_cluster(const core::Snapshot& snapshot, std::uint32_t cluster,
                                           std::span<const core::Slot> slots) const {
  Cluster made{};
  core::AabbD around;
  core::Affine world;
  std::uint32_t placed_instance = kNone;
  const Part* parts = parts_.data() + std::size_t(cluster) * kItemsPerCluster;
  made.instance = parts[0].instance;
  for (std::size_t i = 0; i < kItemsPerCluster; ++i) {
    const Part& part = parts[i];
    made.parts[i] = {kNone, 0};
    if (part.instance != parts[0].instance) made.instance = kNone;
    if (part.instance == kNone) continue;
    const Instance& instance = instances_[part.instance];
    const Mesh& mesh = meshes_[instance.mesh];
    const lod::Cluster& of = mesh.levels->clusters[part.cluster];
    made.parts[i] = {instance.details, mesh.details + kClusterTexels * part.cluster};
    if (std::exchange(placed_instance, part.instance) != part.instance)
      world = snapshot.world_from_item(slots[instance.record]);
    around.grow(lod::placed_box(of.box, world, snapshot.bounds().origin));
    if (of.goes_into == kNone) {
      made.error = std::numeric_limits<float>::infinity();
    } else {
      made.error = std::max(made.error, kMoreError * mesh.levels->groups[of.goes_into].error);
      made.replacing.grow(mesh.levels->groups[of.goes_into].box);
    }
  }
  made.box = core::round_outwards(around, dvec3(0.0));
  made.instance = made.instance == kNone ? kNone : instances_[made.instance].details;
  return made;
}

core::Expected<void> MeshParts::flush(const gl::Functions& gl, const core::Snapshot& snapshot,
                                      std::span<const core::Slot> slots, gpuscene::ElementWriter& writer) {
  constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();
  auto done = make_room(gl, clusters_, cluster_count() * sizeof(Cluster), sizeof(Cluster),
                        most_clusters_ * sizeof(Cluster), "clusters of parts of meshes");
  if (done)
    done = make_room(gl, details_, detail_space_.end() * sizeof(Texel), sizeof(Texel), kNoLimit,
                     "details of parts of meshes");
  if (!done) return done;
  std::ranges::stable_sort(detail_writes_, {}, [](const auto& write) { return write.first; });
  std::vector<std::uint32_t> places;
  std::vector<Texel> texels;
  for (const auto& [place, texel] : detail_writes_) {
    const bool again = !places.empty() && places.back() == place;  // given back and taken by another
    if (!again) places.push_back(place);
    texels.resize(places.size());
    texels.back() = texel;
  }
  writer.write(details_.buffer, sizeof(Texel), places, texels.data());
  detail_writes_ = {};
  core::sort_unique(changed_);
  std::erase_if(changed_, [&](std::uint32_t cluster) { return cluster >= cluster_count(); });
  std::vector<Cluster> made;
  for (const std::uint32_t cluster : changed_) made.push_back(make_cluster(snapshot, cluster, slots));
  writer.write(clusters_.buffer, sizeof(Cluster), changed_, made.data());
  changed_ = {};
  return {};
}

}  // namespace sightline::culling
