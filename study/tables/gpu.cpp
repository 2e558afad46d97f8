#include "sightline/study/tables/gpu.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "sightline/apps/bench/models/platforms.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/gl/internal/query.h"
#include "sightline/study/brute_force.h"
#include "sightline/study/gpu/flat.h"
#include "sightline/study/gpu/frontier.h"
#include "sightline/study/gpu/in_draw.h"
#include "sightline/study/production.h"

namespace sightline::study {
namespace {

constexpr int kWidth = 640, kHeight = 480;

// --- figure 5.15: culling alone --------------------------------------------------------------------------------------

/// Gathers methods to be run in turn.
class Bench {
 public:
  Bench(const Model& model, const SessionOptions& options) : model_(model), options_(options) {}

  /// `make()` gives a method, or fails: then it is left out.
  template <class Make>
  void add(const std::string& name, Origin origin, const Make& make) {
    const auto& names = options_.variants;
    if (!names.empty() && std::find(names.begin(), names.end(), name) == names.end()) return;
    const auto start = std::chrono::steady_clock::now();
    core::Expected<std::unique_ptr<Method>> made = make();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    if (made)
      contestants_.push_back({name, origin, std::move(*made), taken.count()});
    else
      std::fprintf(stderr, "%s: %s is left out: %s\n", model_.name.c_str(), name.c_str(), made.error().message.c_str());
  }

  Results run(const Path& path) const {
    options_.progress(std::to_string(contestants_.size()) + " methods in turn");
    Results results;
    results.model = &model_;
    results.path = &path;
    results.runs = measure(path, contestants_, options_.passes);
    return results;
  }

 private:
  const Model& model_;
  const SessionOptions& options_;
  std::vector<Contestant> contestants_;
};

const ProductionForm kLinear{"production without hierarchy", std::nullopt, false, false};
constexpr const char* kFrontier = "GPU frontier";

Results run_culling(const gl::Context& context, const Model& model, const SessionOptions& options) {
  Bench bench(model, options);
  for (const bool signed_answers : {false, true})
    bench.add(flat_name(signed_answers), Origin::kStudy,
              [&] { return make_flat(context, signed_answers, model.boxes); });
  bench.add(kFrontier, Origin::kStudy, [&] { return Frontier::create(context, model.sah, model.boxes); });
  const auto forms = production_forms();
  for (const ProductionForm& form : {forms[0], forms[1], kLinear})
    bench.add(form.name, Origin::kProduction, [&] { return make_production(form, model.boxes); });
  bench.add(BruteForce::name(), Origin::kBaseline, [&] { return std::make_unique<BruteForce>(model.boxes); });
  return bench.run(model.paths.front());
}

// --- figure 5.14: whole frames ---------------------------------------------------------------------------------------

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

/// What drawing takes.
struct Stage {
  const gl::Context& context;
  core::Snapshot snapshot;
  gpuscene::GpuScene scene;
  gpuscene::DrawLists lists;
  render::Renderer renderer;
  render::RenderTarget target;

  static core::Expected<Stage> create(const gl::Context& context, const core::Scene& model) {
    core::Snapshot snapshot(model);
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
};

/// A frame from cull to the last pixel. Ids are not asked for: the paths that it flies have no sampled frames.
class Drawing : public Method {
 public:
  explicit Drawing(Stage& stage) : stage_(&stage) {}
  void cull(const core::View& view) final {
    if (!frame(view)) failed_ = true;
    stage_->context.functions().Finish();
  }
  std::uint64_t count() const final { return failed_ ? 0 : drawn(); }
  std::vector<std::uint32_t> ids() const final { return {}; }

 protected:
  virtual core::Expected<void> frame(const core::View& view) = 0;
  virtual std::uint64_t drawn() const = 0;
  Stage* stage_;

 private:
  bool failed_ = false;
};

class DrawAll : public Drawing {
 public:
  using Drawing::Drawing;
  core::Expected<void> frame(const core::View& view) override {
    if (auto done = stage_->lists.update(stage_->snapshot, stage_->scene, all()); !done) return done;
    return stage_->draw(view);
  }
  std::uint64_t drawn() const override { return all().count(); }

 private:
  core::VisibleSet all() const {
    core::VisibleSet set;
    set.ranges = {{0, std::uint32_t(stage_->snapshot.size())}};
    return set;
  }
};

class DrawCulledByCpu : public Drawing {
 public:
  explicit DrawCulledByCpu(Stage& stage) : Drawing(stage), culler_(stage.snapshot.bounds()) {}
  core::Expected<void> frame(const core::View& view) override {
    culler_.cull(view, set_);
    if (auto done = stage_->lists.update(stage_->snapshot, stage_->scene, set_); !done) return done;
    return stage_->draw(view);
  }
  std::uint64_t drawn() const override { return set_.count(); }
  std::size_t memory_bytes() const override { return culler_.memory_bytes(); }

 private:
  culling::CpuCuller culler_;
  core::VisibleSet set_;
};

/// Production on the GPU: the separate pass.
class DrawCulledByGpu : public Drawing {
 public:
  DrawCulledByGpu(Stage& stage, culling::GpuCuller culler) : Drawing(stage), culler_(std::move(culler)) {}
  core::Expected<void> frame(const core::View& view) override {
    if (auto done = culler_.cull(view, stage_->snapshot, stage_->scene, stage_->lists); !done) return done;
    return stage_->draw(view);
  }
  std::uint64_t drawn() const override { return culler_.read_back(stage_->lists).count(); }
  std::size_t memory_bytes() const override { return culler_.memory_bytes(); }

 private:
  culling::GpuCuller culler_;
};

class DrawCullingItself : public Drawing {
 public:
  DrawCullingItself(Stage& stage, InDraw in_draw)
      : Drawing(stage), in_draw_(std::move(in_draw)), triangles_(stage.context.functions(), GL_PRIMITIVES_GENERATED) {}
  core::Expected<void> frame(const core::View& view) override {
    triangles_.begin();
    auto done = in_draw_.draw(view, stage_->snapshot, stage_->scene, stage_->renderer, stage_->target);
    triangles_.end();
    return done;
  }
  std::uint64_t drawn() const override { return triangles_.result() / InDraw::kTrianglesPerCylinder; }
  std::size_t memory_bytes() const override { return in_draw_.memory_bytes(); }

 private:
  InDraw in_draw_;
  gl::Query triangles_;
};

/// A method out of what it is made of, which may have failed.
template <class Draw, class Part>
core::Expected<std::unique_ptr<Method>> drawing_with(Stage& stage, core::Expected<Part> part) {
  if (!part) return tl::unexpected(part.error());
  return std::make_unique<Draw>(stage, std::move(*part));
}

/// `path`: without sampled frames; outlives the results.
core::Expected<Results> run_drawing(const gl::Context& context, const Model& model, const Path& path,
                                    const SessionOptions& options) {
  auto scene = cylinders_of(model);
  if (!scene) return tl::unexpected(scene.error());
  auto made = Stage::create(context, *scene);
  if (!made) return tl::unexpected(made.error());
  Stage& stage = *made;
  Bench bench(model, options);
  bench.add("no culling", Origin::kBaseline, [&] { return std::make_unique<DrawAll>(stage); });
  bench.add("GPU in the draw", Origin::kStudy, [&] {
    return drawing_with<DrawCullingItself>(stage, InDraw::create(context, stage.snapshot, stage.scene));
  });
  for (const auto& [name, form] : {std::pair("GPU separate pass (geometry)", culling::GpuVariant::kGeometry),
                                   std::pair("GPU separate pass (compute)", culling::GpuVariant::kCompute)})
    bench.add(name, Origin::kProduction, [&, form = form] {
      return drawing_with<DrawCulledByGpu>(stage,
                                           culling::GpuCuller::create(context, stage.snapshot, stage.scene, {form}));
    });
  bench.add("CPU (production)", Origin::kProduction, [&] { return std::make_unique<DrawCulledByCpu>(stage); });
  return bench.run(path);
}

// --- what is printed -------------------------------------------------------------------------------------------------

void print_table(const Results& r, const char* title, bool errors) {
  if (r.runs.empty()) return;
  std::printf("\n%s: %s (%zu boxes, %zu frames)\n", title, r.model->name.c_str(), r.model->boxes.size(),
              r.path->views.size());
  std::printf("%-32s %10s %10s %10s", "", "mean ms", "fast. ms", "visible");
  if (errors) std::printf(" %9s %9s %9s %9s", "extra", "missing", "false +", "false -");
  std::printf(" %12s\n", "bytes");
  for (const Run& run : r.runs) {
    const double n = double(std::max<std::size_t>(1, run.samples));
    std::printf("%-32s %10.4f %10.4f %10.1f", run.variant.c_str(), run.mean_ms, run.fastest_ms, run.mean_visible);
    if (errors)
      std::printf(" %9.1f %9.1f %9.1f %9.1f", double(run.errors.extra) / n, double(run.errors.missing) / n,
                  run.false_positives(), run.false_negatives());
    std::printf(" %12zu\n", run.memory_bytes);
  }
}

}  // namespace

core::Expected<GpuResults> run_gpu(const gl::Context& context, const Model& model, const SessionOptions& options) {
  GpuResults results{run_culling(context, model, options), std::nullopt};
  if (std::find(model.kinds.begin(), model.kinds.end(), bench::kCylinders) == model.kinds.end()) return results;
  const Path& path = model.paths.front();
  const Path unsampled{path.name, path.views, path.seconds, {}, {}};
  auto drawing = run_drawing(context, model, unsampled, options);
  if (!drawing) return tl::unexpected(drawing.error());
  drawing->path = &path;
  results.drawing = std::move(*drawing);
  return results;
}

void print_gpu(const gl::Context& context, const std::vector<GpuResults>& all) {
  std::printf("%s%s\n", context.renderer().c_str(),
              context.capabilities().software ? ": the GPU's work is the CPU's here" : "");
  for (const GpuResults& r : all) {
    print_table(r.culling, "Figure 5.15  culling, answer on the CPU", true);
    if (r.drawing) print_table(*r.drawing, "Figure 5.14  cylinders drawn, 640x480", false);
  }
}

core::Expected<void> write_gpu_figures(const GpuResults& results, const std::filesystem::path& directory) {
  const auto all_of = [](const Results& r) {
    std::vector<const Run*> runs;
    for (const Run& run : r.runs) runs.push_back(&run);
    return runs;
  };
  std::vector<const Run*> shown;
  for (const char* name :
       {"GPU points", "GPU signed answers", kFrontier, "production", kLinear.name.c_str(), BruteForce::name()})
    if (const Run* run = results.culling.find(name)) shown.push_back(run);
  if (!shown.empty())
    if (auto w = write_figure(results.culling, "5.15", shown, directory); !w) return w;
  if (!results.drawing || results.drawing->runs.empty()) return {};
  return write_figure(*results.drawing, "5.14", all_of(*results.drawing), directory);
}

}  // namespace sightline::study
