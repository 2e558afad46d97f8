#include "sightline/lod/stored_levels.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <type_traits>

#include "sightline/core/affine.h"
#include "sightline/core/mesh_extras.h"
#include "sightline/lod/internal/cluster_tree.h"

namespace sightline::lod {
namespace {

using core::Aabb;
using core::kNone;

/// What stands first. Then follow rows of clusters, rows of groups, members of groups, a byte for each index, and what
/// these bytes leave open.
struct Head {
  std::uint32_t clusters, mesh_clusters, groups, members, indices, solid_indices;
};
struct ClusterRow {
  std::uint32_t index_count;
  Aabb box;
};
struct GroupRow {
  float error, angle;
  Aabb box;
  std::uint32_t member_count, made_count;  // clusters that it holds, and that it has made
};

// --- indices ---------------------------------------------------------------------------------------------------------

// An index is a vertex that its cluster has had, by how many vertices ago that came in, or a new one, by its difference
// from the new one before.
constexpr std::uint8_t kNew = 0, kLongAgo = 255;

/// Splits off the last bits: whole numbers of any size and sign in few bytes if they are small.
void put_number(std::vector<std::byte>& to, std::int64_t value) {
  auto rest = std::uint64_t(value) << 1 ^ std::uint64_t(value >> 63);
  for (; rest >= 128; rest >>= 7) to.push_back(std::byte(rest | 128));
  to.push_back(std::byte(rest));
}

class IndexEncoder {
 public:
  explicit IndexEncoder(std::size_t vertices) : place_(vertices) {}

  void add_cluster(std::span<const std::uint32_t> indices) {
    had_.clear();
    for (const std::uint32_t vertex : indices) {
      const std::uint32_t place = place_[vertex];
      if (place >= had_.size() || had_[place] != vertex) {
        place_[vertex] = std::uint32_t(had_.size());
        had_.push_back(vertex);
        codes.push_back(std::byte(kNew));
        put_number(rest, std::int64_t(vertex) - std::int64_t(before_));
        before_ = vertex;
      } else if (const std::size_t ago = had_.size() - place; ago < kLongAgo) {
        codes.push_back(std::byte(ago));
      } else {
        codes.push_back(std::byte(kLongAgo));
        put_number(rest, place);
      }
    }
  }

  std::vector<std::byte> codes, rest;

 private:
  std::vector<std::uint32_t> place_;  // by vertex: where it is in had_, if it is there
  std::vector<std::uint32_t> had_;    // vertices of the cluster
  std::uint32_t before_ = 0;
};

class IndexDecoder {
 public:
  /// `vertices`: how many there are, which indices stay below.
  IndexDecoder(std::span<const std::byte> codes, std::span<const std::byte> rest, std::size_t vertices)
      : codes_(codes), rest_(rest), vertices_(vertices) {}

  /// Reads the next cluster, which must be among the codes. False where they are damaged.
  bool read_cluster(std::span<std::uint32_t> indices) {
    std::size_t had = 0;
    for (std::uint32_t& index : indices) {
      const auto code = std::uint8_t(codes_[next_code_++]);
      std::int64_t number = 0;
      if (code == kNew) {
        if (!take_number(number)) return false;
        before_ += number;
        if (before_ < 0 || before_ >= std::int64_t(vertices_)) return false;
        had_[had++] = std::uint32_t(before_);
        index = std::uint32_t(before_);
        continue;
      }
      if (code == kLongAgo) {
        if (!take_number(number)) return false;
      } else {
        number = std::int64_t(had) - code;
      }
      if (number < 0 || number >= std::int64_t(had)) return false;
      index = had_[std::size_t(number)];
    }
    return true;
  }
  bool all_read() const { return next_code_ == codes_.size() && next_rest_ == rest_.size(); }

 private:
  bool take_number(std::int64_t& number) {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 42; shift += 7) {
      if (next_rest_ == rest_.size()) return false;
      const auto byte = std::uint8_t(rest_[next_rest_++]);
      value |= std::uint64_t(byte & 127) << shift;
      if (byte < 128) {
        number = std::int64_t(value >> 1) ^ -std::int64_t(value & 1);
        return true;
      }
    }
    return false;
  }

  std::span<const std::byte> codes_, rest_;
  std::size_t vertices_, next_code_ = 0, next_rest_ = 0;
  std::int64_t before_ = 0;
  std::uint32_t had_[3 * kClusterTriangles] = {};
};

// --- all of it -------------------------------------------------------------------------------------------------------

template <class T>
void put(std::vector<std::byte>& to, std::span<const T> values) {
  const std::size_t before = to.size();
  to.resize(before + values.size_bytes());
  if (!values.empty()) std::memcpy(to.data() + before, values.data(), values.size_bytes());
}

bool is_finite(const Aabb& box) {
  return core::is_finite(core::dvec3(box.min)) && core::is_finite(core::dvec3(box.max));
}

class Decoder {
 public:
  Decoder(std::span<const std::byte> bytes, const core::Mesh& mesh) : left_(bytes), mesh_(mesh) {}

  core::Expected<MeshLevels> run(LevelRange range) {
    if (const char* const wrong = read(range)) return core::fail(std::string("levels of a mesh: ") + wrong);
    return std::move(levels_);
  }

 private:
  /// What is wrong with them, or null.
  const char* read(LevelRange range) {
    Head head;
    std::vector<Head> heads;
    if (!take(1, heads)) return "they are cut short";
    head = heads[0];
    std::vector<GroupRow> groups;
    if (!take(head.clusters, rows_) || !take(head.groups, groups) || !take(head.members, levels_.members) ||
        head.indices > left_.size())
      return "they are cut short";
    if (head.mesh_clusters > head.clusters || head.solid_indices > mesh_.indices.size())
      return "they have less than the mesh";
    const bool all = range == LevelRange::kAll;
    levels_.mesh_clusters = head.mesh_clusters;
    levels_.solid_indices = head.solid_indices;
    if (const char* const wrong = read_clusters(all ? head.clusters : head.mesh_clusters)) return wrong;
    if (count_ > head.indices || (all && count_ != head.indices)) return "their clusters do not have all indices";
    if (!read_indices(head.indices, all)) return "their indices are inconsistent";
    if (!all) {
      levels_.members.clear();
    } else if (!join(groups) || !errors_grow()) {
      return "their groups are inconsistent";
    }
    list_roots(levels_);
    return nullptr;
  }

  template <class T>
  bool take(std::size_t count, std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count > left_.size() / sizeof(T)) return false;
    values.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(values.data()), left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
    return true;
  }

  const char* read_clusters(std::uint32_t count) {
    levels_.clusters.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      const ClusterRow& row = rows_[i];
      if (row.index_count > 3 * kClusterTriangles || row.index_count % 3 != 0 || !is_finite(row.box))
        return "a cluster is inconsistent";
      levels_.clusters[i] = {std::uint32_t(count_), row.index_count, kNone, kNone, row.box};
      count_ += row.index_count;
      if (i + 1 == levels_.mesh_clusters && count_ != mesh_.indices.size()) return "their clusters are not the mesh";
    }
    return levels_.mesh_clusters == 0 && !mesh_.indices.empty() ? "their clusters are not the mesh" : nullptr;
  }

  bool read_indices(std::size_t codes, bool all) {
    IndexDecoder decoder(left_.first(codes), left_.subspan(codes), mesh_.positions.size());
    levels_.indices.resize(count_);
    for (const Cluster& cluster : levels_.clusters)
      if (!decoder.read_cluster(std::span(levels_.indices).subspan(cluster.first_index, cluster.index_count)))
        return false;
    return !all || decoder.all_read();
  }

  /// Groups hold clusters that there are before those which they have made. So whoever goes from made clusters to held
  /// ones comes to an end.
  bool join(const std::vector<GroupRow>& rows) {
    std::size_t member = 0, made = levels_.mesh_clusters;
    for (std::uint32_t number = 0; number < rows.size(); ++number) {
      const GroupRow& row = rows[number];
      if (row.member_count > levels_.members.size() - member || row.made_count > levels_.clusters.size() - made ||
          !is_finite(row.box))
        return false;
      levels_.groups.push_back({row.error, row.angle, row.box, std::uint32_t(member), row.member_count});
      for (const std::size_t end = member + row.member_count; member < end; ++member) {
        const std::uint32_t held = levels_.members[member];
        if (held >= made || levels_.clusters[held].goes_into != kNone) return false;
        levels_.clusters[held].goes_into = number;
      }
      for (const std::size_t end = made + row.made_count; made < end; ++made) levels_.clusters[made].made_by = number;
    }
    return member == levels_.members.size() && made == levels_.clusters.size();
  }

  bool errors_grow() const {
    const auto is_bound = [](const ClusterGroup& g) { return g.error >= 0.0f && g.angle >= 0.0f; };  // no NaN either
    if (!std::ranges::all_of(levels_.groups, is_bound)) return false;
    return std::ranges::all_of(levels_.clusters, [&](const Cluster& cluster) {
      return cluster.made_by == kNone || cluster.goes_into == kNone ||
             levels_.groups[cluster.made_by].error <= levels_.groups[cluster.goes_into].error;
    });
  }

  std::span<const std::byte> left_;
  const core::Mesh& mesh_;
  std::vector<ClusterRow> rows_;
  std::uint64_t count_ = 0;  // indices of the clusters so far
  MeshLevels levels_;
};

}  // namespace

std::vector<std::byte> encode(const MeshLevels& levels) {
  std::vector<ClusterRow> clusters;
  std::vector<GroupRow> groups;
  for (const ClusterGroup& group : levels.groups)
    groups.push_back({group.error, group.angle, group.box, group.member_count, 0});
  const std::uint32_t most = levels.indices.empty() ? 0 : std::ranges::max(levels.indices);
  IndexEncoder indices(std::size_t(most) + 1);
  for (const Cluster& cluster : levels.clusters) {
    clusters.push_back({cluster.index_count, cluster.box});
    if (cluster.made_by != kNone) ++groups[cluster.made_by].made_count;
    indices.add_cluster(std::span(levels.indices).subspan(cluster.first_index, cluster.index_count));
  }
  const Head head{std::uint32_t(clusters.size()),       levels.mesh_clusters,
                  std::uint32_t(groups.size()),         levels.first_root,
                  std::uint32_t(levels.indices.size()), levels.solid_indices};
  std::vector<std::byte> bytes;
  bytes.reserve(sizeof head + clusters.size() * sizeof clusters[0] + groups.size() * sizeof groups[0] +
                levels.first_root * sizeof(std::uint32_t) + indices.codes.size() + indices.rest.size());
  put(bytes, std::span(&head, 1));
  put(bytes, std::span<const ClusterRow>(clusters));
  put(bytes, std::span<const GroupRow>(groups));
  put(bytes, std::span(levels.members).first(levels.first_root));
  put(bytes, std::span<const std::byte>(indices.codes));
  put(bytes, std::span<const std::byte>(indices.rest));
  return bytes;
}

core::Expected<MeshLevels> decode(std::span<const std::byte> bytes, const core::Mesh& mesh, LevelRange range) {
  return Decoder(bytes, mesh).run(range);
}

MeshLevels stored_levels_of(const core::Mesh& mesh, LevelRange range) {
  if (const core::StoredBytes* stored = core::bytes_stored_with(mesh))
    if (const auto bytes = stored->bytes())
      if (auto levels = decode(*bytes, mesh, range)) return std::move(*levels);
  return {};
}

MeshLevels levels_of(const core::Mesh& mesh, LevelRange range, int threads, const std::stop_token& stop) {
  if (MeshLevels stored = stored_levels_of(mesh, range); !stored.empty()) return stored;
  return range == LevelRange::kAll ? build_levels(mesh, threads, stop) : build_clusters(mesh, threads, stop);
}

bool builds_levels() {
#if SIGHTLINE_HAS_MESHOPT
  return true;
#else
  return false;
#endif
}

}  // namespace sightline::lod
