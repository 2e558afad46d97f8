// sightline-bench prepare: what is done for a frame on the processor before GL draws it, without GL, by step and by
// threads.
#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/stages.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/progress.h"
#include "sightline/core/internal/hash.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/culling/occlusion/internal/occlusion_passes.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/culling/occlusion/solid_occluders.h"
#include "sightline/engine/drawing/internal/draw_choice.h"
#include "sightline/gpuscene/internal/visible_records.h"
#include "sightline/lod/stored_levels.h"

namespace sightline::bench::prepare_bench {
namespace {

using apps::need;
using core::ThreadPool;

constexpr int kWidth = 1280, kHeight = 720;
constexpr float kSnap = culling::kCoarsestSnap;
const culling::ImageSamples kSamples{kWidth, kHeight, {{0, 0}}, kSnap};

struct Options {
  StageOptions stages;
  int frames = 16;
  double lod_error = 0.5;
  bool verify = false;
};

void add_options(apps::CommandLine& line, Options& o) {
  add_stage_options(line, o.stages);
  line.add("--frames", o.frames, "Of a tour, evenly spaced; each is prepared as if it came again")
      .in_range(1, 10'000)
      .shows_default();
  line.add("--lod-error", o.lod_error, "Of the levels of meshes, in pixels").in_range(0.0, 1e6).shows_default();
  line.add_flag("--verify", o.verify, "Measure nothing: fail unless 1, 2, 3, 5 and 16 threads prepare the same");
  line.examples(
      "  sightline-bench prepare --items 5000000\n"
      "  sightline-bench prepare --items 100000 --frames 1000 --verify\n"
      "  sightline-bench prepare plant.slc --threads 8 --json prepare.json");
}

/// How a GPU scene would draw the items with meshes, by their levels.
class Meshes {
 public:
  explicit Meshes(const core::Snapshot& snapshot) : drawn_(snapshot.size()) {
    std::vector<const core::Mesh*> meshes;
    for_each_slot(snapshot, [&](core::Slot slot) {
      if (levels_.try_emplace(&snapshot.mesh(slot)).second) meshes.push_back(&snapshot.mesh(slot));
    });
    const int threads = meshes.size() > 1 ? 1 : 0;  // that build the levels of a mesh
    ThreadPool().run(std::uint32_t(meshes.size()), [&](std::uint32_t i) {
      levels_.at(meshes[i]) = lod::levels_of(*meshes[i], lod::LevelRange::kAll, threads);
    });
    for_each_slot(snapshot, [&](core::Slot slot) {
      const core::Mesh& mesh = snapshot.mesh(slot);
      const lod::MeshLevels& levels = levels_.at(&mesh);
      drawn_[slot] = {{std::uint32_t(mesh.indices.size()), 1, 0, 0, slot},
                      levels.empty() ? nullptr : &levels,
                      levels.solid_indices};
    });
  }
  const gpuscene::DrawnMesh& drawn(core::Slot slot) const { return drawn_[slot]; }
  bool empty() const { return levels_.empty(); }

 private:
  template <class Visit>
  static void for_each_slot(const core::Snapshot& snapshot, const Visit& visit) {
    for (const core::Kind kind : {core::Kind::kMesh, core::Kind::kFacetGroup})
      std::ranges::for_each(snapshot.of_kind(kind).members, visit);
  }

  std::unordered_map<const core::Mesh*, lod::MeshLevels> levels_;
  std::vector<gpuscene::DrawnMesh> drawn_;  // by slot
};

/// The frames of some views. A frame shows either what may cover a sample, or what the occluder polygons of solids
/// leave of that.
class Frames {
 public:
  Frames(const core::Snapshot& snapshot, const Meshes& meshes, std::span<const core::View> views, double lod_error)
      : snapshot_(snapshot),
        culler_(snapshot.bounds()),
        views_(views),
        lod_error_(lod_error),
        meshes_(meshes),
        seen_(views.size()),
        sampled_(views.size()),
        open_(views.size()),
        passes_(views.size()) {
    ThreadPool threads;
    for (std::size_t i = 0; i < views.size(); ++i) {
      cull(i, threads);
      test_samples(i, threads);
      test_occlusion(i, threads);
    }
  }

  void cull(std::size_t i, ThreadPool&) { culler_.cull(views_[i], seen_[i]); }
  void test_samples(std::size_t i, ThreadPool& threads) {
    const culling::SampleTest test(views_[i], bounds().origin, kSamples);
    test.filter(bounds(), seen_[i], sampled_[i], {}, &threads);
  }
  void list_sampled(std::size_t i, ThreadPool& threads) { records_.assign(snapshot_, sampled_[i], &threads); }
  void list_open(std::size_t i, ThreadPool& threads) { records_.assign(snapshot_, open_[i], &threads); }
  void test_contribution(std::size_t i, ThreadPool& threads) {
    const culling::ContributionTest test(views_[i], bounds().origin, kWidth, kHeight);
    const auto large = [&](const core::VisibleSet& in, core::VisibleSet& out) { test.filter(bounds(), in, 1.0f, out); };
    culling::filter_in_parts(seen_[i], large_, &threads, large);
  }
  /// As OcclusionPrepass of engine does.
  void test_occlusion(std::size_t i, ThreadPool& threads) {
    culling::OcclusionPasses& passes = passes_[i];
    pyramid_.clear(kWidth, kHeight);
    const culling::OcclusionTest test(views_[i], bounds().origin, kWidth, kHeight, pyramid_, 0.0, kSnap);
    solids_.begin(snapshot_, views_[i], kWidth, kHeight, kSnap);
    passes.begin(seen_[i], {}, &culler_.hierarchy(), threads, culling::OcclusionPasses::Next::kNearest);
    while (passes.next(test, bounds())) {
      solids_.add(passes.pass(), &threads);
      solids_.build(pyramid_, {}, &threads);
    }
    passes.list_drawn(bounds(), open_[i]);
    parts_.split(open_[i], 512);
    parts_.for_each(&threads, [&](core::VisibleSet& part, std::uint32_t) {
      test.filter(bounds(), part, part);
      solids_.leave_out_occluded(part, pyramid_, 0.0);
    });
    parts_.join(open_[i]);
    passes.remember(open_[i], bounds());
  }

  /// A hash of all that so many threads prepare for the first view.
  std::uint64_t digest(int threads) {
    ThreadPool pool(threads);
    std::uint64_t digest = core::kFnvBasis;
    const auto add = [&]<class T>(std::span<const T> list) {
      digest = core::fnv1a({reinterpret_cast<const char*>(list.data()), list.size_bytes()}, digest);
    };
    const auto add_set = [&](const core::VisibleSet& set) {
      add(std::span<const core::SlotRange>(set.ranges));
      add(std::span<const core::Slot>(set.single_slots));
    };
    const auto add_records = [&] {
      for (const auto& batch : records_.batches) {
        add(std::span<const gpuscene::VisibleRecords::Run>(batch.runs));
        add(std::span<const std::uint32_t>(batch.singles));
      }
      add(std::span<const core::Slot>(records_.meshes));
    };
    test_contribution(0, pool), add_set(large_);
    test_samples(0, pool), add_set(sampled_[0]);
    list_sampled(0, pool), add_records();
    passes_[0] = {};  // else it goes on from what it remembers
    test_occlusion(0, pool), add_set(open_[0]);
    list_open(0, pool), add_records();
    for (const bool tested : {false, true}) {
      tested ? choose_triangles(0, pool) : choose_cuts(0, pool);
      for (const auto& runs : {draws_.fronts, draws_.both_faces}) std::ranges::for_each(runs, add);
      std::ranges::for_each(draws_.indices, add);
    }
    return digest;
  }

  /// Chooses for the meshes that may cover a sample.
  void choose_cuts(std::size_t i, ThreadPool& threads) { choose_meshes(i, threads, nullptr); }
  void choose_triangles(std::size_t i, ThreadPool& threads) {
    const culling::TriangleTest test(views_[i], kSamples);
    choose_meshes(i, threads, &test);
  }

  TimedStage stage(const char* name, void (Frames::*prepare)(std::size_t, ThreadPool&)) {
    const auto run = [this, prepare](int threads) {
      ThreadPool& pool = pools_.try_emplace(threads, threads).first->second;
      for (std::size_t i = 0; i < views_.size(); ++i) (this->*prepare)(i, pool);
    };
    return {name, run, int(views_.size())};
  }

 private:
  const core::ItemBounds& bounds() const { return snapshot_.bounds(); }

  void choose_meshes(std::size_t i, ThreadPool& threads, const culling::TriangleTest* triangles) {
    const lod::ImageError error(views_[i], kWidth, kHeight, lod_error_);
    records_.assign(snapshot_, sampled_[i], &threads);
    draws_ = choice_.choose(snapshot_, records_.meshes, [&](core::Slot slot) { return meshes_.drawn(slot); },
                            {.view = views_[i], .error = &error, .triangles = triangles, .threads = &threads});
  }

  const core::Snapshot& snapshot_;
  culling::CpuCuller culler_;
  std::span<const core::View> views_;
  double lod_error_;
  const Meshes& meshes_;
  engine::DrawChoice choice_;
  gpuscene::MeshDraws draws_;
  std::vector<core::VisibleSet> seen_, sampled_, open_;  // by view
  std::vector<culling::OcclusionPasses> passes_;         // by view
  core::VisibleSet large_;
  culling::DepthPyramid pyramid_;
  culling::SolidOccluders solids_;
  culling::SetParts parts_;
  gpuscene::VisibleRecords records_;
  std::map<int, ThreadPool> pools_;
};

core::Expected<int> verify(const core::Snapshot& snapshot, const Meshes& meshes, std::span<const core::View> views,
                           const Options& options) {
  apps::Progress progress("verifying", views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    Frames frames(snapshot, meshes, views.subspan(i, 1), options.lod_error);
    const std::uint64_t wanted = frames.digest(1);
    for (const int threads : {2, 3, 5, 16})
      if (frames.digest(threads) != wanted)
        return core::fail("view " + std::to_string(i) + ": expected that " + std::to_string(threads) +
                          " threads prepare what one does");
    progress.advance(i + 1);
  }
  return finish(options.stages.json, {{"views", views.size()}, {"verified", true}});
}

core::Expected<int> run(const Options& options) {
  const std::unique_ptr<core::Scene> scene = need(model_or_plant(options.stages.model, options.stages.items));
  const core::Snapshot snapshot(*scene);
  const auto views = need(tour_views(snapshot, options.frames, double(kWidth) / kHeight));
  const Meshes meshes(snapshot);
  if (options.verify) return verify(snapshot, meshes, views, options);
  Frames frames(snapshot, meshes, views, options.lod_error);
  std::vector<TimedStage> stages = {
      frames.stage("cull", &Frames::cull),
      frames.stage("test areas", &Frames::test_contribution),
      frames.stage("test samples", &Frames::test_samples),
      frames.stage("list records of these", &Frames::list_sampled),
      frames.stage("test occlusion", &Frames::test_occlusion),
      frames.stage("list records of these", &Frames::list_open),
  };
  if (!meshes.empty()) {
    stages.push_back(frames.stage("choose cuts", &Frames::choose_cuts));
    stages.push_back(frames.stage("the same, and triangles", &Frames::choose_triangles));
  }
  return report_stages(stages, snapshot.size(), options.stages);
}

}  // namespace
}  // namespace sightline::bench::prepare_bench

sightline::bench::Run sightline::bench::add_prepare(apps::CommandLine& line) {
  using namespace prepare_bench;
  return add_subcommand<Options>(line, add_options, run);
}
