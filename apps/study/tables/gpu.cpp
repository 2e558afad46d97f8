// sightline-study cull-gpu: the GPU forms of culling (apps/study/gpu) beside the CPU's, on the paths of the subcommand
// cull.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <memory>

#include "sightline/apps/bench/brute_force.h"
#include "sightline/apps/bench/models/platforms.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/study/gpu/flat.h"
#include "sightline/apps/study/gpu/in_draw.h"
#include "sightline/apps/study/production.h"
#include "sightline/apps/study/tables/cull.h"
#include "sightline/apps/study/tables/report.h"
#include "sightline/apps/study/tables/subcommands.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/gl/internal/query.h"

namespace sightline::study {
namespace {

constexpr int kWidth = 640, kHeight = 480;

/// Gathers methods to be run in turn.
class Turns {
 public:
  Turns(const Model& model, const SessionOptions& options) : model_(model), options_(options) {}

  /// `make()` gives a method, or fails: then it is left out, with a line on stderr.
  template <class Make>
  void add(const std::string& name, Origin origin, const Make& make) {
    if (!options_.wants(name)) return;
    auto made = Contestant::create(name, origin, std::nullopt, make);
    if (made)
      contestants_.push_back(std::move(*made));
    else
      std::fprintf(stderr, "%s: %s is left out: %s\n", model_.name.c_str(), name.c_str(), made.error().message.c_str());
  }

  Results run(const Path& path) const {
    options_.progress(std::to_string(contestants_.size()) + " methods in turn");
    Results results;
    results.model = &model_;
    results.runs = measure(path, contestants_, options_.passes);
    apps::show_step("");
    return results;
  }

 private:
  const Model& model_;
  const SessionOptions& options_;
  std::vector<Contestant> contestants_;
};

// --- figure 5.15: culling alone, with read-back where it is the GPU's ------------------------------------------------

Results run_culling(const gl::Context& context, const Model& model, const SessionOptions& options) {
  Turns turns(model, options);
  for (const bool signed_answers : {false, true})
    turns.add(flat_name(signed_answers), Origin::kStudy,
              [&] { return make_flat(context, signed_answers, model.boxes); });
  for (const bool ids : {false, true})
    turns.add(ids ? kProductionIds : kProduction, Origin::kProduction,
              [&] { return make_production(model.boxes, ids); });
  turns.add(bench::BruteForce::name(), Origin::kBaseline, [&] { return make_brute_force(model.boxes); });
  return turns.run(model.path);
}

// --- figure 5.14: whole frames of models that have cylinders ---------------------------------------------------------

/// Each box of a cylinder gets one along its longest side.
core::Expected<core::Scene> cylinders_of(const Model& model) {
  core::Scene scene;
  for (std::size_t i = 0; i < model.kinds.size(); ++i) {
    if (model.kinds[i] != bench::kCylinders) continue;
    const core::dvec3 low(model.boxes[i].min), high(model.boxes[i].max), size = high - low;
    const int z = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2, x = (z + 1) % 3, y = (z + 2) % 3;
    core::Affine placement = core::translation(0.5 * (low + high));
    placement.linear = core::dmat3(0.0);
    placement.linear[0][x] = placement.linear[1][y] = placement.linear[2][z] = 1.0;
    scene.add_primitive(scene.root(), core::Cylinder{float(0.5 * std::min(size[x], size[y])), float(size[z])},
                        placement);
  }
  if (auto done = scene.commit(); !done) return tl::unexpected(done.error());
  return scene;
}

/// A scene of cylinders, and what draws it.
struct Stage {
  const gl::Context& context;
  core::Snapshot snapshot;
  gpuscene::GpuScene scene;
  gpuscene::DrawLists lists;
  render::Renderer renderer;
  render::RenderTarget target;

  static core::Expected<Stage> create(const gl::Context& context, const Model& model) {
    const auto cylinders = cylinders_of(model);
    if (!cylinders) return tl::unexpected(cylinders.error());
    core::Snapshot snapshot(*cylinders);
    auto scene = gpuscene::GpuScene::create(context, snapshot);
    if (!scene) return tl::unexpected(scene.error());
    auto lists = gpuscene::DrawLists::create(context, *scene);
    if (!lists) return tl::unexpected(lists.error());
    auto renderer = render::Renderer::create(context, *scene);
    if (!renderer) return tl::unexpected(renderer.error());
    auto target = render::RenderTarget::create(context, kWidth, kHeight);
    if (!target) return tl::unexpected(target.error());
    return Stage{context,           std::move(snapshot),  std::move(*scene),
                 std::move(*lists), std::move(*renderer), std::move(*target)};
  }
  core::Expected<void> draw(const core::View& view) { return renderer.draw(view, snapshot, scene, lists, target); }
  core::Expected<void> draw(const core::View& view, const core::VisibleSet& visible) {
    if (auto done = lists.update(snapshot, scene, visible); !done) return done;
    return draw(view);
  }
};

/// A frame from cull to the last pixel. Ids are not asked for: the path that it flies has no sampled frames.
class Drawing : public Method {
 public:
  using Frame = std::function<core::Expected<void>(const core::View&)>;
  using Drawn = std::function<std::uint64_t()>;

  Drawing(Stage& stage, Frame frame, Drawn drawn) : stage_(stage), frame_(std::move(frame)), drawn_(std::move(drawn)) {}
  void cull(const core::View& view) override {
    if (!frame_(view)) failed_ = true;
    stage_.context.functions().Finish();
  }
  std::uint64_t count() const override { return failed_ ? 0 : drawn_(); }
  std::vector<std::uint32_t> ids() const override { return {}; }

 private:
  Stage& stage_;
  Frame frame_;
  Drawn drawn_;
  bool failed_ = false;
};

using Made = core::Expected<std::unique_ptr<Method>>;

Made draw_all(Stage& stage) {
  core::VisibleSet all;
  all.ranges = {{0, std::uint32_t(stage.snapshot.size())}};
  return std::make_unique<Drawing>(
      stage, [&stage, all](const core::View& view) { return stage.draw(view, all); }, [all] { return all.count(); });
}

Made draw_culled_by_cpu(Stage& stage) {
  const auto culler = std::make_shared<culling::CpuCuller>(stage.snapshot.bounds());
  const auto set = std::make_shared<core::VisibleSet>();
  const auto frame = [&stage, culler, set](const core::View& view) {
    culler->cull(view, *set);
    return stage.draw(view, *set);
  };
  return std::make_unique<Drawing>(stage, frame, [set] { return set->count(); });
}

/// Production on the GPU: the separate pass.
Made draw_culled_by_gpu(Stage& stage, culling::GpuVariant variant) {
  auto made = culling::GpuCuller::create(stage.context, stage.snapshot, stage.scene, {variant});
  if (!made) return tl::unexpected(made.error());
  const auto culler = std::make_shared<culling::GpuCuller>(std::move(*made));
  const auto frame = [&stage, culler](const core::View& view) -> core::Expected<void> {
    if (auto done = culler->cull(view, stage.snapshot, stage.scene, stage.lists); !done) return done;
    return stage.draw(view);
  };
  return std::make_unique<Drawing>(stage, frame, [&stage, culler] { return culler->read_back(stage.lists).count(); });
}

Made draw_culling_itself(Stage& stage) {
  auto made = InDraw::create(stage.context, stage.snapshot, stage.scene);
  if (!made) return tl::unexpected(made.error());
  const auto in_draw = std::make_shared<InDraw>(std::move(*made));
  const auto triangles = std::make_shared<gl::Query>(stage.context.functions(), GL_PRIMITIVES_GENERATED);
  const auto frame = [&stage, in_draw, triangles](const core::View& view) {
    triangles->begin();
    auto done = in_draw->draw(view, stage.snapshot, stage.scene, stage.renderer, stage.target);
    triangles->end();
    return done;
  };
  return std::make_unique<Drawing>(stage, frame,
                                   [triangles] { return triangles->result() / InDraw::kTrianglesPerCylinder; });
}

core::Expected<Results> run_drawing(const gl::Context& context, const Model& model, const SessionOptions& options) {
  auto made = Stage::create(context, model);
  if (!made) return tl::unexpected(made.error());
  Stage& stage = *made;
  Turns turns(model, options);
  turns.add("no culling", Origin::kBaseline, [&] { return draw_all(stage); });
  turns.add("GPU in the draw", Origin::kStudy, [&] { return draw_culling_itself(stage); });
  turns.add("GPU separate pass (geometry)", Origin::kProduction,
            [&] { return draw_culled_by_gpu(stage, culling::GpuVariant::kGeometry); });
  turns.add("GPU separate pass (compute)", Origin::kProduction,
            [&] { return draw_culled_by_gpu(stage, culling::GpuVariant::kCompute); });
  turns.add("CPU (production)", Origin::kProduction, [&] { return draw_culled_by_cpu(stage); });
  Path unsampled;
  unsampled.views = model.path.views;
  return turns.run(unsampled);
}

// --- what is printed -------------------------------------------------------------------------------------------------

void print_table(const Results& r, const char* title, std::FILE* out) {
  std::fprintf(out, "\n%s: %s (%zu boxes, %zu frames)\n", title, r.model->name.c_str(), r.model->boxes.size(),
               r.model->path.views.size());
  std::fprintf(out, "%-32s %10s %10s %10s %9s %9s %12s\n", "", "mean ms", "fast. ms", "visible", "false +", "false -",
               "bytes");
  for (const Run& run : r.runs)
    std::fprintf(out, "%-32s %10.4f %10.4f %10.1f %9.1f %9.1f %12zu\n", run.variant.c_str(), run.mean_ms,
                 run.fastest_ms, run.mean_visible, run.false_positives(), run.false_negatives(), run.memory_bytes);
}

core::Expected<int> run_gpu(const CullOptions& options) {
  auto context = gl::Context::create_offscreen();
  if (!context) return tl::unexpected(context.error());
  auto models = make_models(options);
  if (!models) return tl::unexpected(models.error());
  std::FILE* out = apps::table_stream(options.json);
  std::fprintf(out, "%s\n", bench::renderer_line(*context).c_str());
  json::Value json = json::Value::array();
  const auto report = [&](const Results& r, const char* figure, const char* title) -> core::Expected<void> {
    json.push_back(to_json(r));
    print_table(r, title, out);
    std::vector<const Run*> runs;
    for (const Run& run : r.runs) runs.push_back(&run);
    if (options.plots.empty() || runs.empty()) return {};
    return write_plot(r, figure, runs, options.plots);
  };
  for (const Model& model : *models) {
    const SessionOptions session = session_of(model, options);
    auto done = report(run_culling(*context, model, session), "5.15", "Figure 5.15  culling, answer on the CPU");
    if (!done) return tl::unexpected(done.error());
    if (std::find(model.kinds.begin(), model.kinds.end(), bench::kCylinders) == model.kinds.end()) continue;
    const auto drawing = run_drawing(*context, model, session);
    if (!drawing) return tl::unexpected(drawing.error());
    done = report(*drawing, "5.14", "Figure 5.14  cylinders drawn, 640x480");
    if (!done) return tl::unexpected(done.error());
  }
  return bench::finish(options.json, json);
}

}  // namespace

bench::Run add_cull_gpu(apps::CommandLine& line) {
  line.examples("  sightline-study cull-gpu --only P-38 --plots figures");
  return bench::add_subcommand<CullOptions>(line, add_options, run_gpu);
}

}  // namespace sightline::study
