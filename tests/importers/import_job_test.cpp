#include "sightline/importers/internal/import_job.h"

#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>

#include <gtest/gtest.h>

namespace sightline::importers::import_job_test {
namespace {

using core::Affine;
using core::dvec3;

PolygonMesh square(const dvec3& at) {
  return {{at, at + dvec3(1, 0, 0), at + dvec3(1, 1, 0), at + dvec3(0, 1, 0)}, {}, {0, 1, 2, 3}, {4}};
}

struct Counts {
  std::size_t nodes, items, item_slots, meshes, materials;
  explicit Counts(const core::Scene& s)
      : nodes(s.node_count()),
        items(s.item_count()),
        item_slots(s.item_slots()),
        meshes(s.mesh_slots()),
        materials(s.material_slots()) {}
  friend bool operator==(const Counts&, const Counts&) = default;
};

core::Expected<void> fill(ImportJob& job) {
  const core::NodeId node = job.scene().add_node(job.file_node(), "part");
  job.scene().set_attribute(node, "key", "value");
  job.add_primitive(node, core::Sphere{2.0f}, {}, job.scene().add_material({.name = "paint"}));
  job.add_mesh(node, square(dvec3(0.0)), "square", {}, {});
  return {};
}

/// Readers check what files say. Should one let a bad mesh pass, the scene refuses it.
TEST(ImportJob, AMeshThatTheSceneRefusesIsDamage) {
  const auto read = [](ImportJob& job) -> core::Expected<void> {
    const core::NodeId node = job.scene().add_node(job.file_node(), "part");
    for (const std::uint32_t last : {2u, 3u, 1u}) {
      core::Mesh mesh;
      mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
      mesh.indices = {0, 1, last};
      EXPECT_EQ(job.add_mesh(node, mesh, {}), last < 3);
    }
    return {};
  };
  for (const MeshCopies copies : {MeshCopies::kApart, MeshCopies::kSimilar}) {
    core::Scene scene;
    ImportOptions options;
    options.copies = copies;
    options.lenient = true;
    const auto report = run_import("file", scene, scene.root(), options, {}, read);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(scene.item_count(), 2u);
    ASSERT_EQ(report->warnings.size(), 1u);
    EXPECT_EQ(report->warnings[0].message,
              "file/part: item dropped: mesh \"\": expected indices below 3, the number of positions, found 3");
    options.lenient = false;
    const auto refused = run_import("file", scene, scene.root(), options, {}, read);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, "file: " + report->warnings[0].message);
    EXPECT_EQ(scene.item_count(), 2u) << "as it was";
  }
}

TEST(ImportJob, FailureLeavesTheSceneAsItWas) {
  core::Scene scene;
  const ImportOptions options;
  const auto import = [&](const std::function<core::Expected<void>(ImportJob&)>& read) {
    return run_import("file", scene, scene.root(), options, {}, read);
  };
  ASSERT_TRUE(import(fill));
  ASSERT_TRUE(scene.commit());
  const Counts before(scene);

  const auto failed = import([](ImportJob& job) {
    (void)fill(job);
    return core::Expected<void>(core::fail("file: byte 7: broken"));
  });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "file: byte 7: broken");
  EXPECT_EQ(Counts(scene), before);

  const auto thrown = import([](ImportJob& job) -> core::Expected<void> {
    (void)fill(job);
    throw std::runtime_error("a library's words");
  });
  ASSERT_FALSE(thrown);
  EXPECT_EQ(thrown.error().message, "file: a library's words");
  EXPECT_EQ(Counts(scene), before);

  const auto no_memory = import([](ImportJob& job) -> core::Expected<void> {
    (void)fill(job);
    throw std::bad_alloc();
  });
  ASSERT_FALSE(no_memory);
  EXPECT_EQ(no_memory.error().message, "file: not enough memory");
  EXPECT_EQ(Counts(scene), before);

  const auto nothing = scene.commit();
  ASSERT_TRUE(nothing);
  EXPECT_TRUE(nothing->empty());
  ASSERT_TRUE(import(fill)) << "as if nothing had happened";
  const auto delta = scene.commit();
  ASSERT_TRUE(delta);
  EXPECT_EQ(delta->inserted.size(), 2u);
}

TEST(ImportJob, CancelsWhereverItIsAsked) {
  for (int asked_until = 0; asked_until < 2; ++asked_until) {
    core::Scene scene;
    const Counts before(scene);
    int asked = 0;
    double last = -1.0;
    ImportOptions options;
    options.progress = [&](double share) {
      EXPECT_GT(share, last);
      last = share;
      return asked++ < asked_until;
    };
    const auto report = run_import("file", scene, scene.root(), options, {}, [](ImportJob& job) {
      (void)fill(job);
      return job.progress(0.5);
    });
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().message, kCancelled);
    EXPECT_EQ(asked, asked_until + 1);
    EXPECT_EQ(Counts(scene), before);
  }
}

TEST(ImportJob, UnitsAndUpAxis) {
  core::Scene scene;
  const auto report = run_import("file", scene, scene.root(), {}, {0.001, UpAxis::kY}, fill);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->metres_per_unit, 0.001);
  const Affine world = scene.world_from_node(report->nodes[0]);
  const dvec3 up = core::transform_point(world, {0.0, 1000.0, 0.0});
  const dvec3 right = core::transform_point(world, {1000.0, 0.0, 0.0});
  EXPECT_LT(glm::distance(up, {0, 0, 1}), 1e-15);
  EXPECT_LT(glm::distance(right, {1, 0, 0}), 1e-15);
  EXPECT_NEAR(glm::determinant(world.linear), 1e-9, 1e-20) << "no mirror";
}

TEST(ImportJob, DropsWhatCouldNotBeCommitted) {
  core::Scene scene;
  const auto report = run_import("file", scene, scene.root(), {}, {}, [](ImportJob& job) {
    core::Scene& s = job.scene();
    const core::NodeId far = s.add_node(job.file_node(), "far", core::translation({1e38, 0, 0}));
    const core::NodeId none =
        s.add_node(job.file_node(), "none", {core::dmat3(std::numeric_limits<double>::quiet_NaN()), {}});
    job.add_primitive(far, core::Sphere{1.0f}, {});
    job.add_mesh(none, square(dvec3(0.0)), "square", {}, {});
    job.add_primitive(job.file_node(), core::Sphere{1.0f}, {});
    return core::Expected<void>();
  });
  ASSERT_TRUE(report);
  EXPECT_EQ(scene.item_count(), 1u);
  EXPECT_EQ(report->warnings.size(), 2u);
  EXPECT_TRUE(scene.commit());
}

TEST(ImportJob, PromisedReachIsCheckedWhereTheParentStretches) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto items_left = [](const Affine& scene_from_parent, const dvec3& at) {
    core::Scene scene;
    const core::NodeId parent = scene.add_node(scene.root(), "parent", scene_from_parent);
    const auto report = run_import("file", scene, parent, {}, {}, [&](ImportJob& job) {
      job.promise_reach();
      job.add_primitive(job.file_node(), core::Sphere{1.0f}, core::translation(at));
      return core::Expected<void>();
    });
    EXPECT_TRUE(report && scene.commit());
    EXPECT_EQ(report->warnings.size(), 1u - scene.item_count());
    return scene.item_count();
  };
  EXPECT_EQ(items_left({}, {kLargestCoordinate, 0, 0}), 1u);
  EXPECT_EQ(items_left({core::dmat3(1e30), {}}, {1e5, 0, 0}), 1u);
  EXPECT_EQ(items_left({core::dmat3(1e30), {}}, {1e10, 0, 0}), 0u);
  EXPECT_EQ(items_left({core::dmat3(1.0), {0, 1e40, 0}}, {0, 0, 0}), 0u);
  EXPECT_EQ(items_left({core::dmat3(kNan), {}}, {0, 0, 0}), 0u);
}

TEST(ImportJob, ProgressIsToldInSteps) {
  core::Scene scene;
  int calls = 0;
  ImportOptions options;
  options.progress = [&](double) { return ++calls > 0; };
  ASSERT_TRUE(run_import("file", scene, scene.root(), options, {}, [](ImportJob& job) {
    for (int i = 0; i < 100000; ++i) EXPECT_TRUE(job.progress(i / 100000.0));
    return core::Expected<void>();
  }));
  EXPECT_GT(calls, 200);
  EXPECT_LE(calls, 258);
}

TEST(ImportJob, DroppedItemsBeyondTheListAreCounted) {
  core::Scene scene;
  const auto report = run_import("file", scene, scene.root(), {}, {}, [](ImportJob& job) {
    const core::NodeId far = job.scene().add_node(job.file_node(), "far", core::translation({1e38, 0, 0}));
    for (std::size_t i = 0; i < kMaxWarnings + 7; ++i) job.add_primitive(far, core::Sphere{1.0f}, {});
    return core::Expected<void>();
  });
  ASSERT_TRUE(report);
  EXPECT_EQ(scene.item_count(), 0u);
  ASSERT_EQ(report->warnings.size(), kMaxWarnings + 1);
  EXPECT_EQ(report->warnings.back().message, "7 further warnings are not listed");
}

TEST(ImportJob, CountsWhatItAdds) {
  core::Scene scene;
  ImportOptions options;
  const auto read = [](ImportJob& job) {
    job.add_mesh(job.file_node(), square(dvec3(0.0)), "square", {}, {});
    job.add_mesh(job.file_node(), square(dvec3(5.0)), "another", {}, {});
    job.add_mesh(job.file_node(), PolygonMesh{}, "empty", {}, {});
    job.add_instance(job.file_node(), job.scene().mesh_of(core::ItemId{0}), {});
    job.add_instance(job.file_node(), job.scene().mesh_of(core::ItemId{2}), {}, {}, true);
    job.add_primitive(job.file_node(), core::Sphere{0.0f}, {});
    return core::Expected<void>();
  };
  auto report = run_import("file", scene, scene.root(), options, {}, read);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->items[std::size_t(core::Kind::kMesh)], 5u);
  EXPECT_EQ(report->items[std::size_t(core::Kind::kSphere)], 1u);
  EXPECT_EQ(report->degenerate, 3u);
  EXPECT_EQ(report->shared_meshes, 2u);  // the second square and the first instance
  EXPECT_EQ(scene.mesh_slots(), 2u);
  options.copies = MeshCopies::kApart;
  core::Scene apart;
  report = run_import("file", apart, apart.root(), options, {}, read);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->shared_meshes, 1u);
  EXPECT_EQ(apart.mesh_slots(), 3u);
}

TEST(ImportJob, SharingErrorIsInMetresOfTheScene) {
  /// Meshes alike but for a turn and rounding, at the given scales of their nodes and placements.
  const auto error = [](std::initializer_list<std::pair<double, double>> scales) {
    core::Scene scene;
    const auto report = run_import("file", scene, scene.root(), {}, {}, [&](ImportJob& job) {
      const auto mesh = [](double angle) {
        core::Mesh made;
        for (const dvec3& p : {dvec3(0, 0, 0), dvec3(5, 1, 0), dvec3(7, 3, 2), dvec3(2, 6, 1)})
          made.positions.emplace_back(std::cos(angle) * p.x - std::sin(angle) * p.y,
                                      std::sin(angle) * p.x + std::cos(angle) * p.y, p.z);
        made.indices = {0, 1, 2, 0, 2, 3};
        return made;
      };
      job.add_mesh(job.file_node(), mesh(0.0), {});
      for (const auto& [of_node, of_item] : scales) {
        const core::NodeId node = job.scene().add_node(job.file_node(), "n", {core::dmat3(of_node), {}});
        job.add_mesh(node, mesh(0.3), {core::dmat3(of_item), {}});
      }
      return core::Expected<void>();
    });
    EXPECT_EQ(report->shared_meshes, scales.size());
    return report->sharing_error;
  };
  const double one = error({{1, 1}});
  EXPECT_GT(one, 0.0);
  EXPECT_DOUBLE_EQ(error({{4, 1}}), 4 * one);
  EXPECT_DOUBLE_EQ(error({{1, 8}}), 8 * one);
  EXPECT_DOUBLE_EQ(error({{4, 8}}), 32 * one);
  EXPECT_DOUBLE_EQ(error({{1, 1}, {4, 1}, {2, 1}}), 4 * one);
}

TEST(PolygonMesh, FarCoordinatesKeepTheirDetail) {
  const double detail = 1e-4, far = 1e7;
  PolygonMesh mesh = square({far, -far, far});
  mesh.positions[2].x += detail;
  const CentredMesh made = centred(mesh);
  ASSERT_EQ(made.mesh.positions.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT(glm::distance(dvec3(made.mesh.positions[i]) + made.centre, mesh.positions[i]), 1e-2 * detail);
}

TEST(PolygonMesh, DropsBadFacesAndUnusedVertices) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  PolygonMesh mesh;
  mesh.positions = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {kNan, 0, 0}, {1e37, 0, 0}};
  mesh.normals.assign(6, {0, 0, 1});
  mesh.normals[0] = core::vec3(std::numeric_limits<float>::quiet_NaN());  // of a vertex that no face uses
  for (const dvec3& far : {dvec3(0, 1e37, 0), dvec3(0, 0, -1e37)}) mesh.positions.push_back(far);
  mesh.normals.resize(8, {0, 0, 1});
  mesh.corners = {1, 2, 3, 1, 2, 1, 2, 4, 5, 2, 1, 6, 2, 1, 7, 2, 1};
  mesh.face_sizes = {3, 2, 3, 3, 3, 3};
  const CentredMesh made = centred(mesh);
  EXPECT_EQ(made.dropped, 5u);
  EXPECT_EQ(made.mesh.positions.size(), 3u);
  EXPECT_EQ(made.mesh.normals.size(), 3u);
  EXPECT_EQ(made.mesh.indices, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_TRUE(centred({}).mesh.positions.empty());
  EXPECT_EQ(made.mended_normals, 0u);
  mesh.normals[3] = {0, std::numeric_limits<float>::infinity(), 0};  // of a vertex that a face uses
  mesh.normals[1] = {1, 0, 0};
  const CentredMesh mended = centred(mesh);
  EXPECT_EQ(mended.mended_normals, 1u);
  EXPECT_EQ(mended.mesh.normals, (std::vector<core::vec3>{{1, 0, 0}, {0, 0, 1}, {0, 0, 1}}));
}

TEST(PolygonMesh, BoundsCountWhatIsDrawn) {
  PolygonMesh mesh = square({0, 0, 0});
  mesh.positions.insert(mesh.positions.end(), {{50, 0, 0}, {60, 0, 0}, {70, 0, 0}, {80, 0, 0}});
  mesh.corners = {0, 1, 2, 3, 4, 5, 6, 7};
  mesh.face_sizes = {4, 4};
  mesh.normals.assign(8, {0, 0, 1});
  const CentredMesh made = centred(mesh);
  EXPECT_EQ(made.flat, 1u);
  ASSERT_EQ(made.mesh.positions.size(), 4u);
  EXPECT_EQ(made.mesh.normals.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT(glm::distance(dvec3(made.mesh.positions[i]) + made.centre, mesh.positions[i]), 1e-5);
  EXPECT_EQ(made.mesh.indices.size(), 6u);
}

}  // namespace
}  // namespace sightline::importers::import_job_test
