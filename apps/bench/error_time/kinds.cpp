#include <algorithm>
#include <array>
#include <cassert>

#include "sightline/apps/bench/error_time/error_time.h"
#include "sightline/apps/bench/error_time/field.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/visible_set.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::bench {
namespace {

using core::Kind;
using Method = Form::Method;

constexpr std::array kKinds = {Kind::kCylinder,         Kind::kSnout,  Kind::kCircularTorus,
                               Kind::kRectangularTorus, Kind::kSphere, Kind::kSphericalDish,
                               Kind::kEllipticalDish,   Kind::kBox,    Kind::kPyramid};

/// Form of the frames that errors are measured on.
constexpr render::TargetFormat kSampledForm{.ids = false, .normals = true};

bool curved(Kind kind) {
  return kind != Kind::kBox && kind != Kind::kPyramid;
}

std::vector<Form> forms_of(Kind kind, const KindConfig& config) {
  std::vector<Form> forms;
  if (curved(kind)) {
    for (const int segments : config.segments) forms.push_back({Method::kTriangles, segments});
  } else {
    forms.push_back({Method::kTriangles, 0});
  }
  for (const Method method : {Method::kGlsl, Method::kDouble}) forms.push_back({method, 0});
  return forms;
}

/// A scene on the GPU with everything visible in any view: culling is not measured.
class Stage {
 public:
  static core::Expected<Stage> create(const gl::Context& context, const core::Scene& scene,
                                      const render::TargetFormat& form) {
    core::Snapshot snapshot(scene);
    auto gpu = gpuscene::GpuScene::create(context, snapshot);
    if (!gpu) return tl::unexpected(gpu.error());
    auto lists = gpuscene::DrawLists::create(context, *gpu);
    if (!lists) return tl::unexpected(lists.error());
    auto renderer = render::Renderer::create(context, *gpu, form);
    if (!renderer) return tl::unexpected(renderer.error());
    core::VisibleSet all;
    all.generation = snapshot.generation();
    if (snapshot.size() > 0) all.ranges.push_back({0, std::uint32_t(snapshot.size())});
    if (auto done = lists->update(snapshot, *gpu, all); !done) return tl::unexpected(done.error());
    return Stage(std::move(snapshot), std::move(*gpu), std::move(*lists), std::move(*renderer));
  }

  core::Expected<void> draw(const core::View& view, const render::RenderTarget& target) {
    return renderer_.draw(view, snapshot_, gpu_, lists_, target);
  }

  /// Bytes of the records in use and of the triangles.
  std::size_t bytes() const {
    std::size_t bytes = gpu_.meshes().vertices().size() + gpu_.meshes().indices().size();
    for (const gpuscene::Batch& batch : gpu_.batches()) bytes += batch.count * gpuscene::record_bytes(batch.kind);
    return bytes;
  }

 private:
  Stage(core::Snapshot&& snapshot, gpuscene::GpuScene&& gpu, gpuscene::DrawLists&& lists, render::Renderer&& renderer)
      : snapshot_(std::move(snapshot)),
        gpu_(std::move(gpu)),
        lists_(std::move(lists)),
        renderer_(std::move(renderer)) {}

  core::Snapshot snapshot_;
  gpuscene::GpuScene gpu_;
  gpuscene::DrawLists lists_;
  render::Renderer renderer_;
};

/// Measures all images of a kind at one size, in every form.
class KindMeasurement {
 public:
  KindMeasurement(const gl::Context& context, Kind kind, const FieldSize& size, const KindConfig& config,
                  const Report& report)
      : context_(context), config_(config), report_(report), result_{kind, size, 0.0, 0.0, {}} {
    for (int i = 0; i < size.images; ++i)
      fields_.push_back(make_field(kind, size, config.width, config.height, config.seed + std::uint32_t(i)));
    for (const Form& form : forms_of(kind, config)) result_.forms.push_back({form, {}});
  }

  core::Expected<KindResult> run() {
    if (auto done = make_targets(); !done) return tl::unexpected(done.error());
    if (auto done = measure_errors(); !done) return tl::unexpected(done.error());
    if (auto done = measure_frames(); !done) return tl::unexpected(done.error());
    measure_casts();
    return std::move(result_);
  }

 private:
  core::Expected<void> make_targets() {
    auto timed = render::RenderTarget::create(context_, config_.width, config_.height);
    if (!timed) return tl::unexpected(timed.error());
    timed_ = std::move(*timed);
    auto sampled = render::RenderTarget::create(context_, config_.samples * config_.width,
                                                config_.samples * config_.height, kSampledForm);
    if (!sampled) return tl::unexpected(sampled.error());
    sampled_ = std::move(*sampled);
    return {};
  }

  core::Scene scene_of(const Field& field, const Form& form) const {
    core::Scene scene = field.scene();
    constexpr int kAny = 8;
    if (form.method == Method::kTriangles) scene = apps::tessellated(scene, form.segments > 0 ? form.segments : kAny);
    [[maybe_unused]] const auto done = scene.commit();
    assert(done);
    return scene;
  }

  core::Expected<void> measure_errors() {
    const int width = sampled_.width(), height = sampled_.height(), images = int(fields_.size());
    std::vector<std::vector<ItemRays>> rays;
    for (const Field& field : fields_) rays.push_back(field_rays(field, width, height));
    SampleImage reference(width, images * height);
    for (int i = 0; i < images; ++i) cast(fields_[std::size_t(i)], rays[std::size_t(i)], i * height, reference);
    for (KindFigures& figures : result_.forms) {
      SampleImage image(width, images * height);
      for (int i = 0; i < images; ++i) {
        const Field& field = fields_[std::size_t(i)];
        if (figures.form.method == Method::kDouble) {
          cast(field, rays[std::size_t(i)], i * height, image);
        } else if (auto done = sample_frame(field, figures.form, i * height, image); !done) {
          return done;
        }
      }
      figures.errors = compare_samples(reference, image, config_.samples);
      progress();
    }
    return {};
  }

  core::Expected<void> sample_frame(const Field& field, const Form& form, int first_row, SampleImage& image) {
    const core::Scene scene = scene_of(field, form);
    auto stage = Stage::create(context_, scene, kSampledForm);
    if (!stage) return tl::unexpected(stage.error());
    if (auto done = stage->draw(field.view, sampled_); !done) return done;
    const image::DepthImage depth = sampled_.read_depth(field.view);
    const image::NormalImage normals = sampled_.read_normals();
    const std::size_t first = std::size_t(first_row) * std::size_t(image.width);
    for (std::size_t i = 0; i < depth.metres.size(); ++i) {
      image.depth[first + i] = depth.metres[i];
      const auto& n = normals.normals[i];
      image.normals[first + i] = {n[0], n[1], n[2]};
    }
    return {};
  }

  /// Times all forms in turns, so that other load of the machine affects all equally.
  core::Expected<void> measure_frames() {
    for (const Field& field : fields_) {
      std::vector<core::Scene> scenes(1);  // the empty one
      std::vector<KindFigures*> drawn{nullptr};
      for (KindFigures& figures : result_.forms) {
        if (figures.form.on_cpu()) continue;
        scenes.push_back(scene_of(field, figures.form));
        drawn.push_back(&figures);
      }
      std::vector<Stage> stages;
      stages.reserve(scenes.size());
      for (const core::Scene& scene : scenes) {
        auto stage = Stage::create(context_, scene, {});
        if (!stage) return tl::unexpected(stage.error());
        stages.push_back(std::move(*stage));
      }
      auto times = time_in_turns(stages, field.view);
      if (!times) return tl::unexpected(times.error());
      const double share = 1.0 / double(fields_.size());
      result_.empty_frame_ms += share * (*times)[0];
      for (std::size_t i = 1; i < stages.size(); ++i) {
        drawn[i]->ms += share * (*times)[i];
        drawn[i]->bytes_per_item += share * double(stages[i].bytes()) / double(field.items.size());
      }
    }
    progress();
    return {};
  }

  core::Expected<std::vector<double>> time_in_turns(std::vector<Stage>& stages, const core::View& view) {
    const gl::Functions& gl = context_.functions();
    constexpr int kWarmUps = 1;  // it compiles
    return apps::medians(
        apps::in_turns(stages.size(), config_.passes, kWarmUps, [&](std::size_t i) -> core::Expected<double> {
          gl.Finish();
          const double begin = milliseconds();
          if (auto done = stages[i].draw(view, timed_); !done) return tl::unexpected(done.error());
          gl.Finish();
          return milliseconds() - begin;
        }));
  }

  void measure_casts() {
    std::vector<std::vector<ItemRays>> rays;
    double count = 0.0;
    for (const Field& field : fields_) {
      rays.push_back(field_rays(field, config_.width, config_.height));
      for (const ItemRays& item : rays.back()) count += double(item.rays.size());
    }
    result_.rays = count / double(fields_.size());
    for (KindFigures& figures : result_.forms) {
      if (!figures.form.on_cpu()) continue;
      std::vector<double> times(std::size_t(config_.passes));
      for (double& ms : times) ms = time_casts(rays);
      const double ms = apps::median(std::move(times));
      figures.ms = ms / double(fields_.size());
      figures.ns_per_ray = 1e6 * ms / count;
      progress();
    }
  }

  double time_casts(const std::vector<std::vector<ItemRays>>& rays) {
    const double begin = milliseconds();
    for (std::size_t f = 0; f < fields_.size(); ++f)
      for (std::size_t item = 0; item < fields_[f].items.size(); ++item)
        for (const core::Ray& ray : rays[f][item].rays)
          crossings_ += std::size_t(gpuprims::intersect(fields_[f].items[item].primitive, ray).count);
    return milliseconds() - begin;
  }

  void progress() {
    ++steps_;
    if (report_) report_(double(steps_) / double(result_.forms.size() + 3));
  }

  const gl::Context& context_;
  const KindConfig& config_;
  const Report& report_;
  KindResult result_;
  std::vector<Field> fields_;
  render::RenderTarget timed_, sampled_;
  std::size_t crossings_ = 0;  // keeps the compiler from removing the timed work
  int steps_ = 0;
};

}  // namespace

std::string name_of(const Form& form) {
  switch (form.method) {
    case Method::kTriangles:
      return form.segments > 0 ? std::to_string(form.segments) + " segments" : "triangles";
    case Method::kGlsl:
      return "GLSL";
    default:
      return "C++ double";
  }
}

std::span<const Kind> measured_kinds() {
  return kKinds;
}

core::Expected<KindResult> measure_kind(const gl::Context& context, Kind kind, const FieldSize& size,
                                        const KindConfig& config, const Report& report) {
  return KindMeasurement(context, kind, size, config, report).run();
}

}  // namespace sightline::bench
