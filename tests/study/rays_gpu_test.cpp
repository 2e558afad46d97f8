// The traversals in GLSL against those of the CPU: the same hits, bit for bit, and the same counts.
#include <cstdlib>

#include "sightline/apps/study/rays/generated_meshes.h"
#include "sightline/apps/study/rays/gpu/benchmark.h"
#include "sightline/apps/study/rays/gpu/tracer.h"
#include "sightline/tests/study/rays_scenes.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::study::rays::rays_gpu_test {
namespace {

using namespace tests;
using sightline::tests::GlTest;

class RaysGpu : public GlTest {
 protected:
  /// A scene and rays on the GPU, and a search of them.
  struct Case {
    const Structures& structures;
    GpuTriangles triangles;
    RayBatch batch;
  };
  std::optional<Case> make_case(const Structures& structures, std::span<const Ray> rays, std::uint32_t width) {
    auto triangles = upload(*context, structures.triangles);
    auto batch = RayBatch::create(*context, structures.triangles, rays, width);
    if (!triangles || !batch) {
      ADD_FAILURE() << (triangles ? batch.error() : triangles.error()).message;
      return std::nullopt;
    }
    return Case{structures, std::move(*triangles), std::move(*batch)};
  }
  std::vector<GpuAnswer> search(GpuTracer& tracer, const Case& on, const Traversal& traversal,
                                const GpuStructure& structure, Ask ask, const Launch& launch) {
    const auto done = tracer.trace(traversal, ask, on.triangles, structure, on.batch, launch);
    EXPECT_TRUE(done) << (done ? "" : done.error().message);
    return on.batch.read();
  }

  /// All promises of one traversal. False: something failed.
  bool agrees(GpuTracer& tracer, const Case& on, const Traversal& t, std::span<const Ray> rays,
              const std::string& where) {
    auto structure = upload(*context, on.structures, t.structure);
    if (!structure) {
      ADD_FAILURE() << structure.error().message;
      return false;
    }
    const auto nearest = search(tracer, on, t, *structure, Ask::kNearest, {true, 3});
    const auto any = search(tracer, on, t, *structure, Ask::kAny, {true});
    const auto counted = search(tracer, on, t, *structure, Ask::kCount, {});
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto what = [&] {
        return std::string(t.name) + ", " + where + ", ray " + std::to_string(i) + ", " + describe(rays[i]);
      };
      Counters counters;
      const Hit expected = t.count(on.structures, rays[i], counters);
      EXPECT_EQ(nearest[i].hit(), expected)
          << what() << ": triangle " << nearest[i].triangle << ", not " << expected.triangle;
      EXPECT_EQ(counted[i].hit(), expected) << what();
      EXPECT_EQ(bool(any[i].hit()), bool(expected)) << what();
      EXPECT_EQ(counted[i].nodes, counters.nodes) << what();
      EXPECT_EQ(counted[i].triangles, counters.triangles) << what();
      if (HasFailure()) return false;
    }
    return true;
  }
};

TEST_F(RaysGpu, AllTraversalsFindWhatTheCpuFinds) {
  constexpr std::uint64_t kSeed = 20110216;
  const char* wanted = std::getenv("SIGHTLINE_STUDY_RAYS");  // per scene
  const int count = wanted != nullptr ? std::atoi(wanted) : 2000;
  Random random(kSeed);
  GpuTracer tracer(*context);
  for (const Mesh& mesh : scenes(random)) {
    const TriangleSet triangles = mesh.set();
    const Structures structures(triangles);
    RaySource source(structures, random);
    std::vector<Ray> rays;
    for (int i = 0; i < count; ++i) rays.push_back(source.next());
    const auto on = make_case(structures, rays, 47);
    ASSERT_TRUE(on);
    for (const Traversal& t : traversals())
      ASSERT_TRUE(agrees(tracer, *on, t, rays, mesh.name + ", seed " + std::to_string(kSeed)));
  }
}

TEST_F(RaysGpu, ThatAreNotFiniteHitNothing) {
  const Mesh mesh = sphere(16, 8);
  const TriangleSet triangles = mesh.set();
  const Structures structures(triangles);
  std::vector<Ray> rays = bad_rays();
  const std::size_t bad = rays.size();
  rays.push_back({{0, 0, 0}, {0, 0, 1}});
  GpuTracer tracer(*context);
  const auto on = make_case(structures, rays, 5);
  ASSERT_TRUE(on);
  for (const Traversal& t : traversals()) {
    ASSERT_TRUE(agrees(tracer, *on, t, rays, "not finite"));
    const auto answers = on->batch.read();
    for (std::size_t i = 0; i < bad; ++i) EXPECT_FALSE(answers[i].hit()) << t.name << ", ray " << i;
    EXPECT_TRUE(answers[bad].hit()) << t.name;
  }
}

TEST_F(RaysGpu, EveryLaunchAnswersEachRay) {
  constexpr std::uint64_t kSeed = 5;
  Random random(kSeed);
  const Mesh mesh = sphere(40, 20);
  const TriangleSet triangles = mesh.set();
  const Structures structures(triangles);
  GpuTracer tracer(*context);
  const Traversal& bvh = *std::find_if(traversals().begin(), traversals().end(),
                                       [](const Traversal& t) { return t.structure == Structure::kBvh; });
  auto structure = upload(*context, structures, bvh.structure);
  ASSERT_TRUE(structure);
  for (const std::uint32_t width : {1u, 8u, 37u, 64u, 5000u}) {
    for (const std::size_t count : {1u, 63u, 1000u}) {
      std::vector<Ray> rays;
      for (std::size_t i = 0; i < count; ++i)
        rays.push_back({random_point(random, -2.0, 2.0), random_point(random, -1.0, 1.0)});
      for (const Launch launch : {Launch{false, 0}, Launch{true, 0}, Launch{false, 1}, Launch{true, 64}}) {
        const auto on = make_case(structures, rays, width);
        ASSERT_TRUE(on);
        const auto answers = search(tracer, *on, bvh, *structure, Ask::kNearest, launch);
        ASSERT_EQ(answers.size(), count);
        for (std::size_t i = 0; i < count; ++i)
          ASSERT_EQ(answers[i].hit(), bvh.nearest(structures, rays[i]))
              << "seed " << kSeed << ", width " << width << ", ray " << i << " of " << count;
      }
    }
  }
}

TEST_F(RaysGpu, BenchmarkTimesEveryTraversal) {
  const GeneratedMesh mesh = make_scattered(3000);
  const TriangleSet triangles(mesh.positions, mesh.indices);
  const auto silent = [](const std::string&) {};
  const auto made =
      run_benchmark("scattered", triangles, {96, 63}, 1, silent,
                    [&](const Structures& s, const BenchmarkRays& searched, Benchmark& result) -> core::Expected<void> {
                      const auto left_out = run_on_gpu(*context, s, searched, 1, silent, result);
                      if (!left_out) return tl::unexpected(left_out.error());
                      EXPECT_TRUE(left_out->empty());
                      return {};
                    });
  ASSERT_TRUE(made) << made.error().message;
  const Benchmark& b = *made;
  for (const TraversalRun& run : b.traversals) {
    ASSERT_TRUE(run.gpu) << run.traversal->name;
    EXPECT_EQ(run.gpu->disagreements, 0u) << run.traversal->name;
    for (const double ns :
         {run.gpu->rows_ns, run.gpu->tiles_ns, run.gpu->persistent_ns, run.gpu->reflected_ns, run.gpu->shadow_ns})
      EXPECT_GT(ns, 0.0) << run.traversal->name;
  }
}

TEST_F(RaysGpu, WhatNoStorageBlockHoldsIsAnError) {
  const std::size_t most = std::size_t(context->capabilities().max_storage_block_bytes);
  const auto made = make_storage(*context, most + 1, nullptr, "a structure");
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("a structure: "), std::string::npos) << made.error().message;
}

}  // namespace
}  // namespace sightline::study::rays::rays_gpu_test
