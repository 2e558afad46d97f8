// sightline-bench prepare: what is done for a frame on the processor before GL draws it, without GL, by step and by
// threads.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/stages.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/internal/occlusion_passes.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/culling/occlusion/solid_occluders.h"
#include "sightline/gpuscene/internal/visible_records.h"

namespace sightline::bench::prepare_bench {
namespace {

using apps::need;
using core::ThreadPool;

constexpr int kWidth = 1280, kHeight = 720;
constexpr float kSnap = culling::kCoarsestSnap;

struct Options {
  StageOptions stages;
  int frames = 16;
};

void add_options(apps::CommandLine& line, Options& o) {
  add_stage_options(line, o.stages);
  line.add("--frames", o.frames, "Of a tour, evenly spaced; each is prepared as if it came again")
      .in_range(1, 10'000)
      .shows_default();
  line.examples(
      "  sightline-bench prepare --items 5000000\n"
      "  sightline-bench prepare plant.slc --threads 8 --json prepare.json");
}

/// The frames of some views. A frame shows either what may cover a sample, or what the occluder polygons of solids
/// leave of that.
class Frames {
 public:
  Frames(const core::Snapshot& snapshot, const std::vector<core::View>& views)
      : snapshot_(snapshot),
        culler_(snapshot.bounds()),
        views_(views),
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
    const culling::SampleTest test(views_[i], bounds().origin, {kWidth, kHeight, {{0, 0}}, kSnap});
    test.filter(bounds(), seen_[i], sampled_[i], {}, &threads);
  }
  void list_sampled(std::size_t i, ThreadPool& threads) { records_.assign(snapshot_, sampled_[i], &threads); }
  void list_open(std::size_t i, ThreadPool& threads) { records_.assign(snapshot_, open_[i], &threads); }
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

  TimedStage stage(const char* name, void (Frames::*prepare)(std::size_t, ThreadPool&)) {
    const auto run = [this, prepare](int threads) {
      ThreadPool& pool = pools_.try_emplace(threads, threads).first->second;
      for (std::size_t i = 0; i < views_.size(); ++i) (this->*prepare)(i, pool);
    };
    return {name, run, int(views_.size())};
  }

 private:
  const core::ItemBounds& bounds() const { return snapshot_.bounds(); }

  const core::Snapshot& snapshot_;
  culling::CpuCuller culler_;
  const std::vector<core::View>& views_;
  std::vector<core::VisibleSet> seen_, sampled_, open_;  // by view
  std::vector<culling::OcclusionPasses> passes_;         // by view
  culling::DepthPyramid pyramid_;
  culling::SolidOccluders solids_;
  culling::SetParts parts_;
  gpuscene::VisibleRecords records_;
  std::map<int, ThreadPool> pools_;
};

core::Expected<int> run(const Options& options) {
  const std::unique_ptr<core::Scene> scene = need(model_or_plant(options.stages.model, options.stages.items));
  const core::Snapshot snapshot(*scene);
  const auto views = need(tour_views(snapshot, options.frames, double(kWidth) / kHeight));
  Frames frames(snapshot, views);
  const std::vector<TimedStage> stages = {
      frames.stage("cull", &Frames::cull),
      frames.stage("test samples", &Frames::test_samples),
      frames.stage("list records of these", &Frames::list_sampled),
      frames.stage("test occlusion", &Frames::test_occlusion),
      frames.stage("list records of these", &Frames::list_open),
  };
  return report_stages(stages, snapshot.size(), options.stages);
}

}  // namespace
}  // namespace sightline::bench::prepare_bench

sightline::bench::Run sightline::bench::add_prepare(apps::CommandLine& line) {
  using namespace prepare_bench;
  return add_subcommand<Options>(line, add_options, run);
}
