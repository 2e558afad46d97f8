#include "sightline/apps/bench/error_time/kinds.h"

#include <deque>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/visible_set.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::bench {
namespace {

using apps::need;
using core::Kind;
using Json = json::Value;

/// Format of the frames that errors are measured on.
constexpr render::TargetFormat kSampledFormat{.ids = false, .normals = true};

/// Triangles with so many segments (0: the number does not matter), or the GLSL.
struct Form {
  bool triangles = true;
  int segments = 0;
};

std::vector<Form> forms_of(Kind kind, const KindConfig& config) {
  std::vector<Form> forms;
  if (kind == Kind::kBox || kind == Kind::kPyramid)
    forms.push_back({});
  else
    for (const int segments : config.segments) forms.push_back({true, segments});
  forms.push_back({false, 0});
  return forms;
}

core::Scene scene_of(const Field& field, const Form& form) {
  constexpr int kAny = 8;
  core::Scene scene = field.scene();
  if (form.triangles) scene = apps::tessellated(scene, form.segments > 0 ? form.segments : kAny);
  need(scene.commit());
  return scene;
}

/// A scene on the GPU with everything visible in any view: culling is not measured.
class Stage {
 public:
  Stage(const gl::Context& context, core::Scene scene, const render::TargetFormat& format)
      : scene_(std::move(scene)),
        snapshot_(scene_),
        gpu_(need(gpuscene::GpuScene::create(context, snapshot_))),
        lists_(need(gpuscene::DrawLists::create(context, gpu_))),
        renderer_(need(render::Renderer::create(context, gpu_, format))) {
    core::VisibleSet all;
    all.generation = snapshot_.generation();
    all.ranges.push_back({0, std::uint32_t(snapshot_.size())});
    need(lists_.update(snapshot_, gpu_, all));
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

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
  core::Scene scene_;
  core::Snapshot snapshot_;
  gpuscene::GpuScene gpu_;
  gpuscene::DrawLists lists_;
  render::Renderer renderer_;
};

/// Measures all images of a kind at one size, in every form.
class KindMeasurement {
 public:
  KindMeasurement(const gl::Context& context, Kind kind, const FieldSize& size, const KindConfig& config)
      : context_(context),
        config_(config),
        timed_(need(render::RenderTarget::create(context, config.width, config.height))),
        sampled_(need(render::RenderTarget::create(context, config.samples * config.width,
                                                   config.samples * config.height, kSampledFormat))),
        forms_(forms_of(kind, config)) {
    for (int i = 0; i < size.images; ++i)
      fields_.push_back(make_field(kind, size, config.width, config.height, config.seed + std::uint32_t(i)));
  }

  Json run() {
    Json rows = Json::array();
    for (const Form& form : forms_)
      rows.push_back({{"name", form.triangles ? "triangles" : "GLSL"}, {"threshold", form.segments}});
    add_errors(rows);
    add_times(rows);
    return rows;
  }

 private:
  void add_errors(Json& rows) {
    const int width = sampled_.width(), height = sampled_.height(), images = int(fields_.size());
    SampleImage reference(width, images * height);
    for (int i = 0; i < images; ++i) {
      const Field& field = fields_[std::size_t(i)];
      cast(field, field_rays(field, width, height), i * height, reference);
    }
    for (std::size_t f = 0; f < forms_.size(); ++f) {
      SampleImage image(width, images * height);
      for (int i = 0; i < images; ++i) sample_frame(fields_[std::size_t(i)], forms_[f], i * height, image);
      const SampleErrors errors = compare_samples(reference, image, config_.samples);
      rows[f].update({{"depth", apps::to_json(errors.depth)},
                      {"normal", apps::to_json(errors.normal)},
                      {"silhouette", {{"mean", errors.silhouette_mean}, {"max", errors.silhouette_max}}},
                      {"hits", errors.hits},
                      {"wrong", errors.wrong()}});
    }
  }

  void sample_frame(const Field& field, const Form& form, int first_row, SampleImage& image) {
    Stage stage(context_, scene_of(field, form), kSampledFormat);
    need(stage.draw(field.view, sampled_));
    const image::DepthImage depth = sampled_.read_depth(field.view);
    const image::NormalImage normals = sampled_.read_normals();
    const std::size_t first = std::size_t(first_row) * std::size_t(image.width);
    for (std::size_t i = 0; i < depth.metres.size(); ++i) {
      image.depth[first + i] = depth.metres[i];
      const auto& n = normals.normals[i];
      image.normals[first + i] = {n[0], n[1], n[2]};
    }
  }

  /// Times all forms in turns, so that other load of the machine affects all equally. The first pass compiles.
  void add_times(Json& rows) {
    const gl::Functions& gl = context_.functions();
    std::vector<double> ms(forms_.size()), bytes(forms_.size());
    for (const Field& field : fields_) {
      std::deque<Stage> stages;
      for (const Form& form : forms_) stages.emplace_back(context_, scene_of(field, form), render::TargetFormat{});
      const auto timed = [&](std::size_t i) -> core::Expected<double> {
        gl.Finish();
        const double begin = milliseconds();
        need(stages[i].draw(field.view, timed_));
        gl.Finish();
        return milliseconds() - begin;
      };
      const auto times = need(apps::medians(apps::in_turns(stages.size(), config_.passes, 1, timed)));
      for (std::size_t f = 0; f < forms_.size(); ++f) {
        ms[f] += times[f] / double(fields_.size());
        bytes[f] += double(stages[f].bytes()) / double(field.items.size() * fields_.size());
      }
    }
    for (std::size_t f = 0; f < forms_.size(); ++f) rows[f].update({{"ms", ms[f]}, {"bytes_per_item", bytes[f]}});
  }

  const gl::Context& context_;
  const KindConfig& config_;
  render::RenderTarget timed_, sampled_;
  std::vector<Form> forms_;
  std::vector<Field> fields_;
};

}  // namespace

Json measure_kind(const gl::Context& context, Kind kind, const FieldSize& size, const KindConfig& config) {
  return KindMeasurement(context, kind, size, config).run();
}

}  // namespace sightline::bench
