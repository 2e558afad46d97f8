// sightline-bench passes: what the passes of an image take on the GPU's own clock, kind by kind, and how many fragments
// they shade for each sample that they colour.
//
// Each pass is alone on the GPU, which a frame's passes are not, so that sums are upper bounds. On a software
// rasteriser the wall clock stands in for the GPU's.
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/table.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/engine/looks.h"
#include "sightline/gl/internal/query.h"
#include "sightline/gl/internal/timer.h"
#include "sightline/render/internal/depth_shading_pass.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::bench::passes_bench {
namespace {

using apps::need;
using Json = json::Value;

constexpr int kRepeats = 5;
constexpr GLenum kFragmentsShaded = 0x82F4;  // GL_FRAGMENT_SHADER_INVOCATIONS of ARB_pipeline_statistics_query

struct Options {
  ModelOrPlant model;
  int frames = 16, samples = 1;
  gl::ContextPlatform platform = {};
  std::string size = "1280x720", json;
};

void add_options(apps::CommandLine& line, Options& o) {
  add_model_or_plant_options(line, o.model);
  add_frames_option(line, o.frames, 1);
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  line.add("--samples", o.samples, "Per pixel").in_range(1, 32).shows_default();
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench passes plant.rvm\n"
      "  sightline-bench passes --items 100000 --size 1920x1080 --samples 4 --json passes.json");
}

constexpr apps::Column kColumns[] = {{"pass", "title"},
                                     {"items", "items", "{:.0f}"},
                                     {"ms, mean", "ms/mean", "{:.3f}"},
                                     {"p99", "ms/p99", "{:.3f}"},
                                     {"fragments a sample coloured", "fragments", "{:.2f}"},
                                     {"samples coloured, of the image", "coloured", "{:.2f}"}};

/// The figures of one pass, view by view.
struct Pass {
  std::string title;
  std::vector<double> items = {}, ms = {}, shaded = {}, coloured = {};

  Json to_json(double samples) const {
    Json json = {{"title", title}, {"ms", apps::to_json(apps::summarise(ms))}};
    if (!items.empty()) json["items"] = apps::summarise(items).mean;
    const double passed = coloured.empty() ? 0.0 : apps::summarise(coloured).mean;
    if (passed > 0.0) json["coloured"] = passed / samples;
    if (passed > 0.0 && !shaded.empty()) json["fragments"] = apps::summarise(shaded).mean / passed;
    return json;
  }
};

/// Draws with all of a scene on the GPU.
class Studio {
 public:
  Studio(const gl::Context& context, const core::Snapshot& snapshot, const std::array<int, 2>& size, int samples)
      : context_(context),
        snapshot_(snapshot),
        culler_(snapshot.bounds()),
        scene_(need(gpuscene::GpuScene::create(context, snapshot))),
        lists_(need(gpuscene::DrawLists::create(context, scene_))),
        target_(need(render::RenderTarget::create(context, size[0], size[1], {.ids = true, .samples = samples}))),
        renderer_(need(render::Renderer::create(context, scene_, target_.format()))),
        shading_(context.functions()),
        timer_(context.functions()),
        coloured_(context.functions(), GL_SAMPLES_PASSED),
        shaded_(context.functions(), kFragmentsShaded) {
    gl::discard_errors(context.functions());  // of drivers that do not count fragments
    for (const gpuscene::Batch& batch : scene_.batches()) passes_.push_back({std::string(name_of(batch.kind))});
    for (const char* title : {"all kinds", "all kinds again, over their depth", "resolve samples", "depth shading"})
      passes_.push_back({title});
  }

  void measure(const core::View& view) {
    see(view);
    auto pass = passes_.begin();
    for (const gpuscene::Batch& batch : scene_.batches()) {
      list(of_batch(batch.kind));
      measure_drawing(*pass++, view, true);
    }
    list(seen_);
    measure_drawing(*pass++, view, true);
    measure_drawing(*pass++, view, false);
    if (target_.format().samples > 1) pass->ms.push_back(time([] {}, [&] { (void)target_.resolved(); }));
    const engine::DepthShading looks = engine::Looks::standard().depth_shading;
    (++pass)->ms.push_back(time([] {}, [&] { need(shading_.draw(target_, view, looks.strength, looks.edge_lines)); }));
  }

  Json to_json() const {
    Json rows;
    const double samples = double(target_.width()) * target_.height() * target_.format().samples;
    for (const Pass& pass : passes_)
      if (!pass.ms.empty()) rows[pass.title] = pass.to_json(samples);
    return rows;
  }

 private:
  /// Finds what an engine draws of the view.
  void see(const core::View& view) {
    core::VisibleSet inside;
    culler_.cull(view, inside);
    culling::ImageSamples samples{target_.width(), target_.height(), {}, culling::kCoarsestSnap};
    for (const glm::vec2& offset : target_.sample_offsets()) samples.offsets.push_back({offset.x, offset.y});
    const core::ItemBounds& bounds = snapshot_.bounds();
    culling::SampleTest(view, bounds.origin, samples).filter(bounds, inside, seen_);
  }

  core::VisibleSet of_batch(gpuscene::BatchKind kind) const {
    core::VisibleSet set;
    set.generation = seen_.generation;
    seen_.for_each_slot([&](core::Slot slot) {
      if (gpuscene::batch_of(snapshot_.kind(slot)) == kind) set.single_slots.push_back(slot);
    });
    return set;
  }

  void list(const core::VisibleSet& set) {
    need(lists_.update(snapshot_, scene_, set));
    listed_ = double(snapshot_.count(set));
  }

  /// `alone`: on an empty image.
  void measure_drawing(Pass& pass, const core::View& view, bool alone) {
    const auto prepare = [&] {
      if (alone) need(renderer_.clear(target_));
    };
    const auto draw = [&] { need(renderer_.draw({view, snapshot_, scene_, lists_, target_})); };
    pass.items.push_back(listed_);
    pass.ms.push_back(time(prepare, draw));
    prepare();
    coloured_.begin(), shaded_.begin();
    draw();
    coloured_.end(), shaded_.end();
    pass.coloured.push_back(double(coloured_.result()));
    if (!shaded_.empty()) pass.shaded.push_back(double(shaded_.result()));
  }

  /// The median of some times, in milliseconds.
  double time(const std::function<void()>& prepare, const std::function<void()>& draw) {
    const gl::Functions& gl = context_.functions();
    std::vector<double> times;
    for (int i = 0; i < kRepeats; ++i) {
      prepare();
      gl.Finish();
      const double begin = milliseconds();
      const bool timed = timer_.begin() && !context_.capabilities().software;
      draw();
      timer_.end();
      gl.Finish();
      const double wall = milliseconds() - begin;
      const auto on_gpu = timer_.poll();
      times.push_back(timed && on_gpu && *on_gpu >= 0.0 ? *on_gpu : wall);
    }
    return apps::median(times);
  }

  const gl::Context& context_;
  const core::Snapshot& snapshot_;
  culling::CpuCuller culler_;
  gpuscene::GpuScene scene_;
  gpuscene::DrawLists lists_;
  render::RenderTarget target_;
  render::Renderer renderer_;
  render::DepthShadingPass shading_;
  gl::GpuTimer timer_;
  gl::Query coloured_, shaded_;
  core::VisibleSet seen_;
  double listed_ = 0.0;
  std::vector<Pass> passes_;
};

core::Expected<int> run(const Options& o) {
  const auto size = need(apps::parse_size(o.size));
  const std::unique_ptr<core::Scene> scene = need(model_or_plant(o.model.model, o.model.items));
  const core::Snapshot snapshot(*scene);
  gl::ContextOptions options;
  options.platform = o.platform;
  const gl::Context context = need(gl::Context::create_offscreen(options));
  const auto views = need(tour_views(snapshot, o.frames, double(size[0]) / size[1]));
  Studio studio(context, snapshot, size, o.samples);
  {
    apps::Progress progress("measuring", views.size());
    for (std::size_t i = 0; i < views.size(); ++i) studio.measure(views[i]), progress.advance(i + 1);
  }
  Json json = renderer_json(context);
  json.update({{"model", o.model.model.files},
               {"items", snapshot.size()},
               {"size", o.size},
               {"samples", o.samples},
               {"clock", context.capabilities().software ? "wall" : "GPU"},
               {"passes", studio.to_json()}});
  return finish(o.json, json, [&](const Json& all, std::FILE* out) {
    std::fprintf(out, "%s, %s, %d views of the tour, %s clock, %s\n\n", engine::count_text(snapshot.size()).c_str(),
                 o.size.c_str(), o.frames, all["clock"].get<std::string>().c_str(), renderer_line(context).c_str());
    apps::print_table(all["passes"], kColumns, out);
  });
}

}  // namespace
}  // namespace sightline::bench::passes_bench

sightline::bench::Run sightline::bench::add_passes(apps::CommandLine& line) {
  using namespace passes_bench;
  return add_subcommand<Options>(line, add_options, run);
}
