#include "sightline/apps/study/rays/gpu/benchmark.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <optional>
#include <span>

namespace sightline::study::rays {
namespace {

constexpr std::uint32_t kPersistentGroups = 1024;  // enough for 132 processors of eight warps each
constexpr std::uint32_t kGroup = 32;

class GpuBenchmark {
 public:
  GpuBenchmark(const gl::Context& context, const Structures& structures, const BenchmarkRays& searched)
      : context_(context), structures_(structures), searched_(searched), tracer_(context) {}

  core::Expected<void> upload_rays() {
    auto triangles = upload(context_, structures_.triangles);
    if (!triangles) return tl::unexpected(triangles.error());
    triangles_ = std::move(*triangles);
    for (std::size_t kind = 0; kind < kRayKinds; ++kind) {
      const std::uint32_t width = kind == 0 ? std::uint32_t(searched_.image.width) : kGroup * kGroup;
      auto batch = RayBatch::create(context_, structures_.triangles, searched_.rays[kind], width);
      if (!batch) return tl::unexpected(batch.error());
      batches_[kind] = std::move(*batch);
    }
    const std::span<const Ray> few(searched_.rays[0].data(), std::min<std::size_t>(kGroup, searched_.rays[0].size()));
    auto batch = RayBatch::create(context_, structures_.triangles, few);
    if (!batch) return tl::unexpected(batch.error());
    few_ = std::move(*batch);
    return {};
  }

  core::Expected<void> upload_structure(Structure structure) {
    std::optional<GpuStructure>& place = uploaded_[std::size_t(structure)];
    if (place) return {};
    auto made = upload(context_, structures_, structure);
    if (!made) return tl::unexpected(made.error());
    place = std::move(*made);
    return {};
  }

  core::Expected<void> time(const Traversal& traversal, GpuRun& run) {
    constexpr Launch kRows{}, kTiles{true, 0}, kPersistent{true, kPersistentGroups};
    auto done = time(traversal, Ask::kNearest, RayKind::kPrimary, kRows, run.rows_ns);
    if (done) done = time(traversal, Ask::kNearest, RayKind::kPrimary, kTiles, run.tiles_ns);
    if (done) done = time(traversal, Ask::kNearest, RayKind::kPrimary, kPersistent, run.persistent_ns);
    if (done) compare(run);
    if (done) done = time(traversal, Ask::kNearest, RayKind::kReflected, kRows, run.reflected_ns);
    if (done) done = time(traversal, Ask::kAny, RayKind::kShadow, kRows, run.shadow_ns);
    return done;
  }

 private:
  /// Compares the primary rays' last answers with the CPU's.
  void compare(GpuRun& run) const {
    const std::vector<GpuAnswer> answers = batches_[0].read();
    for (std::size_t i = 0; i < answers.size(); ++i) run.disagreements += answers[i].hit() != searched_.hits[i];
  }

  core::Expected<void> trace(const Traversal& traversal, Ask ask, const RayBatch& batch, const Launch& launch) {
    return tracer_.trace(traversal, ask, triangles_, *uploaded_[std::size_t(traversal.structure)], batch, launch);
  }

  /// Lowers `ns`, which is 0 at first. A few rays go ahead: drivers finish a program when it first runs.
  core::Expected<void> time(const Traversal& traversal, Ask ask, RayKind kind, const Launch& launch, double& ns) {
    const RayBatch& batch = batches_[std::size_t(kind)];
    if (batch.size() == 0) return {};
    auto done = trace(traversal, ask, few_, launch);
    if (!done) return done;
    const double seconds = seconds_on_gpu(context_, [&] { done = trace(traversal, ask, batch, launch); });
    const double taken = seconds * 1e9 / double(batch.size());
    ns = ns == 0.0 ? taken : std::min(ns, taken);
    return done;
  }

  const gl::Context& context_;
  const Structures& structures_;
  const BenchmarkRays& searched_;
  GpuTracer tracer_;
  GpuTriangles triangles_;
  std::array<RayBatch, kRayKinds> batches_;
  RayBatch few_;
  std::array<std::optional<GpuStructure>, kStructures> uploaded_;
};

}  // namespace

double seconds_on_gpu(const gl::Context& context, const std::function<void()>& work) {
  context.functions().Finish();
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor_start = std::clock();
  work();
  context.functions().Finish();
  if (context.capabilities().software) return double(std::clock() - processor_start) / CLOCKS_PER_SEC;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

core::Expected<std::vector<std::string>> run_on_gpu(const gl::Context& context, const Structures& structures,
                                                    const BenchmarkRays& searched, int passes,
                                                    const std::function<void(const std::string&)>& step,
                                                    Benchmark& result) {
  std::vector<std::string> left_out;
  GpuBenchmark benchmark(context, structures, searched);
  if (auto done = benchmark.upload_rays(); !done) return tl::unexpected(done.error());
  for (TraversalRun& run : result.traversals) {
    step(std::string("uploading for GLSL, ") + run.traversal->name);
    if (auto done = benchmark.upload_structure(run.traversal->structure); !done) {
      left_out.push_back(std::string(run.traversal->name) + ": " + done.error().message);
      continue;
    }
    run.gpu.emplace();
  }
  for (int pass = 0; pass < passes; ++pass)
    for (TraversalRun& run : result.traversals) {
      if (!run.gpu) continue;
      step(std::string("GLSL, ") + run.traversal->name);
      if (auto done = benchmark.time(*run.traversal, *run.gpu); !done) return tl::unexpected(done.error());
    }
  return left_out;
}

}  // namespace sightline::study::rays
