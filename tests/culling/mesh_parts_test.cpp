// Parts of meshes that the GPU culler draws: in every view a cut of each mesh's levels, as coarse as the CPU's or a bit
// finer, and none is left out that the view volume meets; through edits, and with little room for them.
#include "sightline/culling/gpu/internal/mesh_parts.h"

#include <map>
#include <numbers>

#include "gpu_rig.h"
#include "sightline/lod/internal/cut.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests::mesh_parts_test {
namespace {

using core::dvec3;
using core::View;

constexpr int kWidth = 640, kHeight = 360;

class MeshParts : public GlTest, public testing::WithParamInterface<culling::GpuCullerConfig> {
 protected:
  static constexpr double kSite = 30.0;
  static constexpr std::uint32_t kLargeHills = 110;  // clusters of parts of one item, which may be rejected together

  /// Tori, hills of so many cells along each side, and cylinders; with `deform`, most under placements that scale
  /// unequally, shear or mirror.
  void fill(core::Scene& scene, Random& random, bool deform, const dvec3& site, std::uint32_t cells = 40) {
    const core::MeshId meshes[] = {scene.add_mesh(bumpy_torus(24, 0.1)).value(),
                                   scene.add_mesh(terrain(cells, 1.2)).value(),
                                   scene.add_mesh(smooth_cylinder(60)).value()};
    for (int i = 0; i < 24; ++i) {
      core::Affine at{uniform(random, 0.1, 2.0) * random_rotation(random), site + point(random, kSite)};
      if (deform && i % 2) at.linear = at.linear * core::dmat3(1, 0, 0, uniform(random, -2, 2), 0.2, 0, 0.5, 0.3, 3);
      if (deform && i % 3) at.linear[0] = -at.linear[0];
      scene.add_mesh_instance(scene.root(), meshes[i % 3], at);
    }
    for (int i = 0; i < 200; ++i)
      scene.add_primitive(scene.root(), core::Sphere{1.0f}, core::translation(site + point(random, kSite)));
    ASSERT_TRUE(scene.commit());
  }

  /// Gives levels to all meshes that lack them.
  static void give_levels(Rig& rig) {
    std::vector<gpuscene::MeshPool::LevelsOfMesh> given;
    for (const auto& mesh : rig.gpu.meshes().take_new_meshes(1000))
      given.push_back({mesh, std::make_shared<const lod::MeshLevels>(lod::build_levels(*mesh, 1))});
    rig.gpu.meshes().add_levels(given);
    ASSERT_TRUE(rig.gpu.upload_meshes(core::kNoDeadline, true));
  }

  /// By record, which clusters are drawn. Every command names a cluster, or a mesh without parts.
  using Drawn = std::map<std::uint32_t, std::vector<bool>>;
  Drawn cull(Rig& rig, const View& view, const lod::ImageError* error) {
    EXPECT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, {0, nullptr, error}));
    const auto target = rig.lists.target(gpuscene::BatchKind::kMesh);
    std::uint32_t count = 0;
    if (rig.lists.section(gpuscene::BatchKind::kMesh).count > 0)
      rig.lists.counts().read(gpuscene::DrawLists::record_count_offset(gpuscene::BatchKind::kMesh), sizeof count,
                              &count);
    std::vector<gpuscene::ElementsCommand> commands(count);
    if (count > 0)
      gl().GetNamedBufferSubData(target.buffer, GLintptr(target.offset), GLsizeiptr(count * sizeof(commands[0])),
                                 commands.data());
    Drawn drawn;
    for (const gpuscene::ElementsCommand& command : commands) {
      const std::uint32_t record = command.base_instance;
      const lod::MeshLevels* levels = rig.gpu.meshes().levels(record);
      const gpuscene::ElementsCommand whole = rig.gpu.meshes().command(record);
      EXPECT_EQ(command.base_vertex, whole.base_vertex);
      EXPECT_EQ(command.instance_count, 1u);
      EXPECT_TRUE(levels);
      if (!levels) continue;
      std::vector<bool>& of_record = drawn[record];
      of_record.resize(levels->clusters.size());
      const auto cluster = std::ranges::find_if(levels->clusters, [&](const lod::Cluster& c) {
        return c.first_index + whole.first_index == command.first_index && c.index_count == command.count;
      });
      EXPECT_NE(cluster, levels->clusters.end());
      if (cluster == levels->clusters.end()) continue;
      const auto number = std::size_t(cluster - levels->clusters.begin());
      EXPECT_FALSE(of_record[number]) << "drawn twice";
      of_record[number] = true;
    }
    return drawn;
  }

  /// All groups that are simplified, if a whole mesh is drawn: they have made something that is, or that goes into
  /// others that are.
  static std::vector<bool> simplified(const lod::MeshLevels& levels, const std::vector<bool>& drawn) {
    std::vector<std::vector<std::uint32_t>> made(levels.groups.size());
    for (std::uint32_t c = 0; c < levels.clusters.size(); ++c)
      if (levels.clusters[c].made_by != core::kNone) made[levels.clusters[c].made_by].push_back(c);
    std::vector<bool> simplified(levels.groups.size());
    for (std::size_t g = levels.groups.size(); g-- > 0;)
      for (const std::uint32_t c : made[g]) {
        const std::uint32_t next = levels.clusters[c].goes_into;
        if (drawn[c] || (next != core::kNone && simplified[next])) simplified[g] = true;
      }
    return simplified;
  }

  /// The clusters drawn are a cut: what the groups that are simplified leave, neither more nor less.
  static void expect_cut(const lod::MeshLevels& levels, const std::vector<bool>& drawn,
                         const std::vector<bool>& simplified) {
    for (std::size_t c = 0; c < drawn.size(); ++c) {
      const lod::Cluster& cluster = levels.clusters[c];
      const bool fine = cluster.made_by == core::kNone || simplified[cluster.made_by];
      const bool replaced = cluster.goes_into != core::kNone && simplified[cluster.goes_into];
      ASSERT_EQ(drawn[c], fine && !replaced) << "cluster " << c;
      ASSERT_TRUE(!replaced || fine);
    }
  }

  /// Whether all triangles of a cluster lie beyond one plane of the view volume.
  static bool outside(const View& view, const core::Snapshot& snapshot, core::Slot slot, const lod::MeshLevels& levels,
                      const lod::Cluster& cluster) {
    const core::Affine world = snapshot.world_from_item(slot);
    const std::span corners = std::span(levels.indices).subspan(cluster.first_index, cluster.index_count);
    return std::ranges::any_of(core::frustum_planes(view.clip_from_world(), view.clip_depth()), [&](const auto& plane) {
      return std::ranges::all_of(corners, [&](std::uint32_t corner) {
        return core::evaluate(plane, core::transform_point(world, snapshot.mesh(slot).positions[corner])) < 0.0;
      });
    });
  }

  static View from_within(Random& random, const dvec3& site) {
    View view = random_view(random, site, kSite);
    if (chance(random, 0.3)) add_sections(random, site, kSite, view);
    return view;
  }
  /// Shows all.
  static View from_outside(const dvec3& site) {
    return *View::orthographic({site + dvec3(0, -500, 0), site, {0, 0, 1}}, 1000.0, 1.0, 0.0, 1000.0);
  }
};

INSTANTIATE_TEST_SUITE_P(All, MeshParts, testing::ValuesIn(all_gpu_configs()), gpu_config_name);

TEST_P(MeshParts, AreACutNearlyAsCoarseAsTheCpus) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  std::size_t groups = 0, finer = 0, coarse = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    core::Scene scene;
    const bool deform = seed % 2 == 0;
    const dvec3 site = seed % 3 == 0 ? dvec3(1e7, -1e6, 1e3) : dvec3(0.0);
    fill(scene, random, deform, site, kLargeHills);
    Rig rig(*context, scene, GetParam());
    give_levels(rig);
    for (int i = 0; i < repeated(200, 20); ++i) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", view " << i);
      const lod::ImageError error(from_within(random, site), kWidth, kHeight, magnitude(random, 0.01, 100.0));
      const Drawn drawn = cull(rig, from_outside(site), &error);
      ASSERT_EQ(drawn.size(), 24u);
      for (const auto& [record, of_record] : drawn) {
        const lod::MeshLevels& levels = *rig.gpu.meshes().levels(record);
        const std::vector<bool> here = simplified(levels, of_record);
        expect_cut(levels, of_record, here);
        if (HasFatalFailure()) return;
        const core::Slot slot = gpuscene::GpuScene::slots_of(rig.snapshot, gpuscene::BatchKind::kMesh)[record];
        const lod::MeshError of_mesh(error, rig.snapshot.world_from_item(slot));
        for (std::size_t g = 0; g < here.size(); ++g) {
          const lod::ClusterGroup& group = levels.groups[g];
          const float allowed = of_mesh.allowed(group.box);
          ASSERT_TRUE(!here[g] || group.error <= allowed) << "coarser than allowed";
          if (!deform && group.error <= 0.998f * allowed) {
            ASSERT_TRUE(here[g]) << "finer than rounding tells: " << group.error << " of " << allowed;
          }
          ++groups;
          finer += !here[g] && group.error <= allowed;
          coarse += here[g];
        }
      }
    }
  }
  EXPECT_GT(coarse, groups / 20);
  EXPECT_LT(coarse, groups - groups / 20);
  EXPECT_LT(finer, groups / 10);
}

/// In any view volume: what lies in it of the cut that the whole mesh would have.
TEST_P(MeshParts, AreLeftOutOnlyOutsideTheView) {
  std::size_t left_out = 0, needless = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Random random(seed);
    core::Scene scene;
    const dvec3 site = seed % 2 == 0 ? dvec3(1e6, -1e7, 0.0) : dvec3(0.0);
    fill(scene, random, seed > 2, site, kLargeHills);
    Rig rig(*context, scene, GetParam());
    give_levels(rig);
    const std::vector<core::Slot> slots = gpuscene::GpuScene::slots_of(rig.snapshot, gpuscene::BatchKind::kMesh);
    for (int i = 0; i < repeated(200, 20); ++i) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", view " << i);
      View view = random_view(random, site, kSite);
      const lod::ImageError error(view, kWidth, kHeight, magnitude(random, 0.01, 100.0));
      const lod::ImageError exact(view, kWidth, kHeight, 0.0);
      const bool in_full = chance(random, 0.2);
      const Drawn all = cull(rig, from_outside(site), in_full ? nullptr : &error);
      Drawn seen = cull(rig, view, in_full ? nullptr : &error);
      for (const auto& [record, of_record] : all) {
        const lod::MeshLevels& levels = *rig.gpu.meshes().levels(record);
        const lod::MeshError of_mesh(exact, rig.snapshot.world_from_item(slots[record]));
        std::vector<bool>& here = seen[record];
        here.resize(of_record.size());
        for (std::size_t c = 0; c < of_record.size(); ++c) {
          ASSERT_TRUE(of_record[c] || !here[c]) << "not of the cut";
          ASSERT_TRUE(!in_full || of_record[c] == (c < levels.mesh_clusters));
          if (!of_record[c]) continue;
          ASSERT_TRUE(here[c] || outside(view, rig.snapshot, slots[record], levels, levels.clusters[c]))
              << "record " << record << ", cluster " << c;
          left_out += !here[c];
          needless += here[c] && of_mesh.outside(levels.clusters[c].box);
        }
      }
    }
  }
  EXPECT_GT(left_out, 1000u);
  EXPECT_LT(needless, left_out / 4) << "boxes along the axes are larger than those of the mesh";
}

/// Items that move, come, go and hide; their parts' places are used again.
TEST_P(MeshParts, FollowEdits) {
  Random random(5);
  core::Scene scene;
  fill(scene, random, false, dvec3(0.0));
  Rig rig(*context, scene, GetParam());
  give_levels(rig);
  std::vector<core::ItemId> items;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && to_index(item) < 24) items.push_back(item);
  std::size_t settled = 0;
  for (int round = 0; round < 24; ++round) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    const core::MeshId mesh = scene.add_mesh(bumpy_torus(std::uint32_t(8 + 4 * (round % 5)), 0.1)).value();
    for (int i = 0; i < 2; ++i)
      items.push_back(scene.add_mesh_instance(scene.root(), mesh, core::translation(point(random, kSite))));
    for (int i = 0; i < 2; ++i) {
      const auto gone = items.begin() + whole(random, 0, int(items.size()) - 1);
      scene.remove_item(*gone);
      items.erase(gone);
    }
    scene.set_placement(items[0], core::translation(point(random, kSite)));
    scene.set_visible(items[1], round % 2 == 0);
    auto delta = scene.commit();
    ASSERT_TRUE(delta);
    const std::vector<core::Slot> touched = rig.snapshot.apply(*delta);
    const auto larger = rig.gpu.append(rig.snapshot);
    ASSERT_TRUE(larger);
    rig.gpu.update(rig.snapshot, touched);
    ASSERT_TRUE(rig.gpu.upload_meshes(core::kNoDeadline));
    if (*larger) {
      rig.lists = std::move(*gpuscene::DrawLists::create(*context, rig.gpu));
      rig.culler = std::move(*culling::GpuCuller::create(*context, rig.snapshot, rig.gpu, GetParam()));
    } else {
      ASSERT_TRUE(rig.culler.update(rig.snapshot, rig.gpu, touched));
    }
    if (round % 3 != 1) give_levels(rig);
    const View view = random_view(random, dvec3(0.0), kSite);
    const lod::ImageError error(view, kWidth, kHeight, 3.0);
    Rig fresh(*context, scene, GetParam());
    give_levels(fresh);
    if (round % 3 == 1) continue;  // new meshes are drawn whole, which cull() takes for an error
    const auto by_item = [&](Rig& of) {
      std::map<core::ItemId, std::vector<bool>> drawn;
      const std::vector<core::Slot> slots = gpuscene::GpuScene::slots_of(of.snapshot, gpuscene::BatchKind::kMesh);
      for (auto& [record, clusters] : cull(of, view, &error)) drawn[of.snapshot.item(slots[record])] = clusters;
      return drawn;
    };
    ASSERT_EQ(by_item(rig), by_item(fresh));
    if (round == 12) settled = rig.culler.memory_bytes();
  }
  EXPECT_LE(rig.culler.memory_bytes(), 2 * settled);
}

/// Where the lists have no room for parts, meshes are drawn whole. That is in full, so never wrong.
TEST_P(MeshParts, WithoutRoomMeshesAreWhole) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  Random random(3);
  core::Scene scene;
  fill(scene, random, false, dvec3(0.0));
  auto& has = const_cast<gl::Capabilities&>(context->capabilities());
  const auto texels = std::exchange(has.max_texture_buffer_texels, 5 * 600);
  Rig rig(*context, scene, GetParam());
  has.max_texture_buffer_texels = texels;
  give_levels(rig);
  const View view = from_outside(dvec3(0.0));
  const lod::ImageError error(view, kWidth, kHeight, 1.0);
  ASSERT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, {0, nullptr, &error}));
  const core::VisibleSet set = rig.culler.read_back(rig.lists);
  std::map<core::Slot, int> times;
  for (const core::Slot slot : set.single_slots) ++times[slot];
  EXPECT_EQ(times.size(), 224u) << "all items are drawn";
  int whole = 0, in_parts = 0;
  for (const core::Slot slot : gpuscene::GpuScene::slots_of(rig.snapshot, gpuscene::BatchKind::kMesh))
    ++(times[slot] == 1 ? whole : in_parts);
  EXPECT_GT(whole, 5);
  EXPECT_GT(in_parts, 0);
}

/// The feedback counts items, drawn by parts or not.
TEST_P(MeshParts, CountAsTheirItems) {
  Random random(9);
  core::Scene scene;
  fill(scene, random, true, dvec3(0.0));
  Rig rig(*context, scene, GetParam());
  const View view = *View::perspective({{0, -40, 0}, {0, 0, 0}, {0, 0, 1}}, 0.7, 1.5, 0.1);
  const culling::GpuCuller::Image image{view, {kWidth, kHeight, {{0, 0}}}, false};
  const auto feedback = [&](const culling::GpuCuller::Image* of) {
    EXPECT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, {0, of}));
    gl().Finish();
    const auto taken = rig.culler.take_feedback();
    EXPECT_TRUE(taken);
    return taken ? std::pair(taken->visible, taken->items_drawn) : std::pair<std::uint64_t, std::uint64_t>();
  };
  const auto before = feedback(nullptr), before_sampled = feedback(&image);
  const std::size_t memory = rig.culler.memory_bytes();
  give_levels(rig);
  EXPECT_EQ(feedback(nullptr), before);
  EXPECT_EQ(feedback(&image), before_sampled);
  EXPECT_GT(before.first, 20u);
  EXPECT_GT(rig.culler.memory_bytes(), memory);
}

/// A scene none of whose meshes has levels has neither buffers nor programs for parts.
TEST_P(MeshParts, CostNothingWhereThereAreNone) {
  Random random(9);
  core::Scene scene;
  fill(scene, random, true, dvec3(0.0));
  Rig rig(*context, scene, GetParam());
  const View view = from_outside(dvec3(0.0));
  const lod::ImageError error(view, kWidth, kHeight, 1.0);
  ASSERT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists));
  const std::size_t memory = rig.culler.memory_bytes() + rig.lists.memory_bytes();
  ASSERT_TRUE(rig.culler.cull(view, rig.snapshot, rig.gpu, rig.lists, {0, nullptr, &error}));
  EXPECT_EQ(rig.culler.memory_bytes() + rig.lists.memory_bytes(), memory);
}

}  // namespace
}  // namespace sightline::tests::mesh_parts_test
