// Levels as bytes: what is read is what was written, and bytes that anybody changed do no harm.
#include "sightline/lod/stored_levels.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include <gtest/gtest.h>

#include "sightline/core/mesh_extras.h"
#include "sightline/lod/internal/cut.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::stored_levels_test {
namespace {

using lod::LevelRange;
using lod::MeshLevels;

std::vector<NamedMesh> meshes() {
  std::vector<NamedMesh> all = ordinary_meshes();
  for (NamedMesh& mesh : hostile_meshes(11)) all.push_back(std::move(mesh));
  core::Mesh islands;  // many roots
  for (int i = 0; i < 400; ++i) islands = joined(std::move(islands), bumpy_torus(4, 0.0), {9.0f * float(i), 0, 0});
  all.push_back({"many islands", std::move(islands)});
  all.push_back({"large terrain", terrain(110, 1.3)});
  return all;
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same(const MeshLevels& a, const MeshLevels& b) {
  EXPECT_EQ(a.indices, b.indices);
  EXPECT_TRUE(same_bytes(a.clusters, b.clusters));
  EXPECT_TRUE(same_bytes(a.groups, b.groups));
  EXPECT_EQ(a.members, b.members);
  EXPECT_EQ(a.first_root, b.first_root);
  EXPECT_EQ(a.mesh_clusters, b.mesh_clusters);
  EXPECT_EQ(a.solid_indices, b.solid_indices);
}

TEST(StoredLevels, AreWhatWasBuilt) {
  for (const NamedMesh& named : meshes()) {
    SCOPED_TRACE(named.name);
    const MeshLevels built = lod::build_levels(named.mesh);
    const auto bytes = lod::encode(built);
    const auto all = lod::decode(bytes, named.mesh), clusters = lod::decode(bytes, named.mesh, LevelRange::kClusters);
    ASSERT_TRUE(all) << all.error().message;
    expect_same(*all, built);
    ASSERT_TRUE(clusters) << clusters.error().message;
    expect_same(*clusters, lod::build_clusters(named.mesh));
  }
}

/// Bytes of values as they lie in memory, and of whole numbers by seven bits each, the sign in the lowest.
struct Bytes {
  std::vector<std::byte> all;

  template <class T>
  Bytes& add(const T& value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    all.insert(all.end(), bytes.begin(), bytes.end());
    return *this;
  }
  Bytes& add(const Bytes& other) {
    all.insert(all.end(), other.all.begin(), other.all.end());
    return *this;
  }
  Bytes& number(std::int64_t value) {
    auto left = value < 0 ? 2 * std::uint64_t(-value) - 1 : 2 * std::uint64_t(value);
    for (; left > 127; left /= 128) add(std::uint8_t(128 + left % 128));
    return add(std::uint8_t(left));
  }
};

/// Levels as docs/reference/scene-cache-format.md describes them. Another layout needs another kLevelsVersion.
std::vector<std::byte> bytes_twin(const MeshLevels& levels) {
  Bytes clusters, groups, members, codes, rest;
  std::int64_t before = 0;
  for (const lod::Cluster& cluster : levels.clusters) {
    clusters.add(cluster.index_count).add(cluster.box);
    std::vector<std::uint32_t> had;
    for (std::uint32_t i = 0; i < cluster.index_count; ++i) {
      const std::uint32_t vertex = levels.indices[cluster.first_index + i];
      const auto at = std::ranges::find(had, vertex);
      const auto ago = had.end() - at;
      codes.add(std::uint8_t(std::min<std::ptrdiff_t>(ago, 255)));
      if (ago >= 255) rest.number(at - had.begin());
      if (ago > 0) continue;
      rest.number(std::int64_t(vertex) - before);
      before = vertex;
      had.push_back(vertex);
    }
  }
  for (std::uint32_t i = 0; i < levels.groups.size(); ++i) {
    const lod::ClusterGroup& group = levels.groups[i];
    const auto made = std::ranges::count(levels.clusters, i, &lod::Cluster::made_by);
    groups.add(group.error).add(group.angle).add(group.box).add(group.member_count).add(std::uint32_t(made));
  }
  for (std::uint32_t i = 0; i < levels.first_root; ++i) members.add(levels.members[i]);
  Bytes bytes;
  bytes.add(std::uint32_t(levels.clusters.size())).add(levels.mesh_clusters).add(std::uint32_t(levels.groups.size()));
  bytes.add(levels.first_root).add(std::uint32_t(levels.indices.size())).add(levels.solid_indices);
  return bytes.add(clusters).add(groups).add(members).add(codes).add(rest).all;
}

TEST(StoredLevels, AreWrittenAsTheFormatSays) {
  core::Mesh loose = soup_of(terrain(40, 1.0));  // clusters of as many vertices as corners
  for (std::size_t i = 5; i + 300 < loose.indices.size(); i += 7) loose.indices[i + 300] = loose.indices[i];
  for (const core::Mesh& mesh : {bumpy_torus(24, 0.1), loose, core::Mesh()}) {
    const MeshLevels levels = lod::build_levels(mesh);
    EXPECT_TRUE(lod::encode(levels) == bytes_twin(levels)) << mesh.indices.size();
  }
}

/// One cluster of so many vertices whose corners are such bytes.
bool accepts(std::size_t vertices, const std::vector<int>& codes, const Bytes& rest) {
  core::Mesh mesh;
  mesh.positions.assign(vertices, core::vec3(0.0f));
  mesh.indices.assign(codes.size(), 0);
  const core::Aabb box{core::vec3(0.0f), core::vec3(0.0f)};
  const auto count = std::uint32_t(codes.size());
  Bytes bytes;
  bytes.add(1u).add(1u).add(0u).add(0u).add(count).add(0u).add(count).add(box);
  for (const int code : codes) bytes.add(std::uint8_t(code));
  return bool(lod::decode(bytes.add(rest).all, mesh));
}

TEST(StoredLevels, IndicesStayAmongTheVertices) {
  const auto numbers = [](std::initializer_list<int> values) {
    Bytes bytes;
    for (const int value : values) bytes.number(value);
    return bytes;
  };
  EXPECT_TRUE(accepts(3, {0, 0, 0}, numbers({0, 1, 1})));
  EXPECT_FALSE(accepts(3, {0, 0, 0}, numbers({0, 1, 2}))) << "a vertex too many";
  EXPECT_FALSE(accepts(3, {0, 0, 0}, numbers({-1, 1, 1})));
  EXPECT_TRUE(accepts(3, {0, 0, 0}, numbers({2, -1, -1})));
  EXPECT_FALSE(accepts(3, {0, 0, 0}, numbers({0, 1, 1, 0}))) << "more numbers than it has";
  EXPECT_FALSE(accepts(3, {0, 0, 0}, numbers({0, 1})));
  EXPECT_TRUE(accepts(3, {0, 1, 1}, numbers({0})));
  EXPECT_FALSE(accepts(3, {1, 0, 0}, numbers({0, 1}))) << "a vertex before the first";
  EXPECT_FALSE(accepts(3, {0, 2, 0}, numbers({0, 1})));
  EXPECT_TRUE(accepts(3, {0, 0, 2}, numbers({0, 1})));
  EXPECT_TRUE(accepts(3, {0, 255, 255}, numbers({0, 0, 0}))) << "by number";
  EXPECT_FALSE(accepts(3, {0, 255, 255}, numbers({0, 0, 1})));
  EXPECT_FALSE(accepts(3, {0, 255, 255}, numbers({0, 0, -1})));
  EXPECT_FALSE(accepts(3, {0, 255, 255}, numbers({0, 0})));
  for (const int zeros : {5, 6}) {  // 0 in as many bytes and one
    Bytes number;
    for (int i = 0; i < zeros; ++i) number.add(std::uint8_t(128));
    EXPECT_EQ(accepts(1, {0, 1, 1}, number.add(std::uint8_t(0))), zeros == 5);
  }
  std::vector<int> full(3 * lod::kClusterTriangles, 1), more(full.size() + 3, 1);
  full[0] = more[0] = 0;
  EXPECT_TRUE(accepts(1, full, numbers({0})));
  EXPECT_FALSE(accepts(1, more, numbers({0})));
  EXPECT_FALSE(accepts(1, {0, 1, 1, 1}, numbers({0}))) << "no whole triangles";
}

TEST(StoredLevels, AreRefusedWhereAByteIsMissingOrTooMany) {
  const core::Mesh mesh = bumpy_torus(8, 0.1);
  auto bytes = lod::encode(lod::build_levels(mesh));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    ASSERT_FALSE(lod::decode(std::span(bytes).first(size), mesh)) << size;
  bytes.push_back(std::byte(0));
  EXPECT_FALSE(lod::decode(bytes, mesh));
  EXPECT_TRUE(lod::decode(lod::encode(MeshLevels()), core::Mesh()));
  EXPECT_FALSE(lod::decode(lod::encode(MeshLevels()), mesh)) << "no clusters for the mesh's triangles";
}

TEST(StoredLevels, TakeLittleRoom) {
  const core::Mesh mesh = terrain(110, 1.3);
  const MeshLevels built = lod::build_levels(mesh);
  EXPECT_LT(lod::encode(built).size(), built.indices.size() / 3 * 7) << "bytes of triangles of three indices";
}

/// Uses levels as drawing does.
void use(const MeshLevels& levels, const core::Mesh& mesh) {
  for (const std::uint32_t index : levels.indices) ASSERT_LT(index, mesh.positions.size());
  lod::CutChooser chooser;
  std::vector<lod::IndexRange> ranges;
  for (const double distance : {0.1, 20.0, 5000.0}) {
    const core::View view = *core::View::perspective({core::dvec3(distance), core::dvec3(0.0)}, 0.8, 1.5, 0.1);
    chooser.choose(levels, {lod::ImageError(view, 300, 200, 1.0), core::Affine()}, ranges);
    for (const lod::IndexRange& range : ranges) {
      ASSERT_EQ(range.count % 3, 0u);
      ASSERT_LE(std::size_t(range.first) + range.count, levels.indices.size());
    }
  }
  for (const lod::Cluster& cluster : levels.clusters) {
    ASSERT_LE(cluster.index_count, 3 * lod::kClusterTriangles);
    ASSERT_TRUE(cluster.made_by == core::kNone || cluster.made_by < levels.groups.size());
    ASSERT_TRUE(cluster.goes_into == core::kNone || cluster.goes_into < levels.groups.size());
    if (cluster.made_by == core::kNone || cluster.goes_into == core::kNone) continue;
    ASSERT_LE(levels.groups[cluster.made_by].error, levels.groups[cluster.goes_into].error);
  }
}

TEST(StoredLevels, ChangedBytesDoNoHarm) {
  const core::Mesh mesh = joined(terrain(24, 1.5), bumpy_torus(20, 0.2), {3, 3, 0});
  const auto whole = lod::encode(lod::build_levels(mesh));
  MeshRandom random(4);
  int accepted = 0, refused = 0;
  const auto try_bytes = [&](std::span<const std::byte> bytes) {
    for (const LevelRange range : {LevelRange::kAll, LevelRange::kClusters}) {
      const auto levels = lod::decode(bytes, mesh, range);
      ++(levels ? accepted : refused);
      if (levels) use(*levels, mesh);
    }
  };
  for (int round = 0; round < repeated(4000); ++round) {
    auto bytes = whole;
    // What stands first decides most.
    const std::size_t reach = round % 3 == 0 ? 24 : round % 3 == 1 ? 2000 : bytes.size();
    for (std::uint64_t i = 0, n = 1 + random() % 3; i < n; ++i) {
      std::byte& byte = bytes[random() % reach];
      byte = random() % 2 ? std::byte(random()) : byte ^ std::byte(1u << random() % 8);
    }
    try_bytes(bytes);
  }
  for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 500)
    try_bytes(std::span(whole).first(size));
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 1000);
}

/// One change of each thing that is checked, on words of the head and of rows.
TEST(StoredLevels, EachRuleIsKept) {
  const core::Mesh mesh = terrain(40, 1.5);
  const MeshLevels built = lod::build_levels(mesh);
  if (built.groups.size() < 4) GTEST_SKIP() << "no coarser levels in this build";
  const auto refuses = [&](const auto& change) {
    MeshLevels levels = built;
    change(levels);
    return !lod::decode(lod::encode(levels), mesh);
  };
  EXPECT_FALSE(refuses([](MeshLevels&) {}));
  const std::uint32_t first = built.mesh_clusters;
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.groups[1].error = -1.0f; }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.groups[1].error = std::nanf(""); }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.groups[1].angle = -1.0f; }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.groups[1].angle = std::nanf(""); }));
  EXPECT_FALSE(refuses([](MeshLevels& l) { l.groups[0].error = l.groups[0].angle = 0.0f; }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.groups[0].error = 1e30f; })) << "finer, but larger";
  EXPECT_FALSE(refuses([](MeshLevels& l) {
    for (lod::ClusterGroup& group : l.groups) group.error = 1.0f;
  })) << "all equal";
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.groups[0].box.min.x = std::nanf(""); }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.clusters[0].box.max.x = HUGE_VALF; }));
  EXPECT_TRUE(refuses([&](MeshLevels& l) { l.members[0] = first; })) << "a group that holds what it makes";
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.members[0] = l.members[1]; })) << "a cluster in two groups";
  EXPECT_TRUE(refuses([](MeshLevels& l) { ++l.groups[0].member_count; }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { ++l.groups.back().member_count; }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.members.insert(l.members.begin() + l.first_root++, l.members.back()); }))
      << "a member that no group holds";
  EXPECT_TRUE(refuses([](MeshLevels& l) { --l.mesh_clusters; }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.mesh_clusters = std::uint32_t(l.clusters.size()) + 1; }));
  EXPECT_TRUE(refuses([](MeshLevels& l) { l.clusters.back().made_by = core::kNone; })) << "made by no group";
  EXPECT_FALSE(refuses([&](MeshLevels& l) { l.solid_indices = std::uint32_t(mesh.indices.size()); }));
  EXPECT_TRUE(refuses([&](MeshLevels& l) { l.indices[5] = std::uint32_t(mesh.positions.size()); }));
  EXPECT_TRUE(refuses([&](MeshLevels& l) { l.solid_indices = std::uint32_t(mesh.indices.size()) + 3; }));
}

class InMemory : public core::StoredBytes {
 public:
  explicit InMemory(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  core::Expected<std::vector<std::byte>> bytes() const override { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

TEST(StoredLevels, ComeWithTheirMeshAndNotWithItsCopies) {
  core::Mesh mesh = terrain(40, 1.5);
  MeshLevels marked = lod::build_levels(mesh);
  marked.clusters[0].box.min.z -= 1.0f;  // so that they are told from those which are built
  const auto bytes = lod::encode(marked);
  mesh.extras = core::MeshExtrasSlot({std::make_shared<InMemory>(bytes), nullptr});
  const core::Mesh copy = mesh;
  EXPECT_EQ(core::bytes_stored_with(copy), nullptr);
  core::Mesh assigned = mesh;
  assigned = copy;
  EXPECT_EQ(core::bytes_stored_with(assigned), nullptr);
  const core::Mesh moved = std::move(mesh);
  EXPECT_NE(core::bytes_stored_with(moved), nullptr);
  expect_same(lod::levels_of(moved, LevelRange::kAll), marked);
  expect_same(lod::levels_of(copy, LevelRange::kAll), lod::build_levels(copy));
  expect_same(lod::levels_of(copy, LevelRange::kClusters), lod::build_clusters(copy));
  EXPECT_TRUE(lod::stored_levels_of(copy).empty());
  EXPECT_EQ(lod::levels_of(moved, LevelRange::kClusters).clusters[0].box.min, marked.clusters[0].box.min);
  core::Mesh damaged = copy;
  damaged.extras = core::MeshExtrasSlot(
      {std::make_shared<InMemory>(std::vector<std::byte>(bytes.begin(), bytes.end() - 1)), nullptr});
  expect_same(lod::levels_of(damaged, LevelRange::kAll), lod::build_levels(copy));
}

}  // namespace
}  // namespace sightline::tests::stored_levels_test
