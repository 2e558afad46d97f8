#include <cmath>
#include <memory>

#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/bench/error_time/error_time.h"
#include "sightline/bench/harness.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/drawing.h"

namespace sightline::bench {
namespace {

using Method = Form::Method;

struct Picture {
  image::Image colour;
  image::IdImage ids;
  image::DepthImage depth;
};

/// Counts pixels where several items show the same surface, so that any of them may be drawn.
std::uint64_t count_ties(const Picture& a, const Picture& b) {
  constexpr double kSameDepth = 1e-5;  // relative; float depths of touching faces differ by some 1e-7
  std::uint64_t ties = 0;
  for (std::size_t i = 0; i < a.ids.ids.size(); ++i) {
    const double za = a.depth.metres[i], zb = b.depth.metres[i];
    ties += a.ids.ids[i] != b.ids.ids[i] && std::abs(za - zb) <= kSameDepth * za;
  }
  return ties;
}

/// One form of the model, ready to be drawn.
class Subject {
 public:
  static core::Expected<Subject> create(gl::Context& context, const core::Scene& scene, const Form& form,
                                        const ModelConfig& config) {
    Subject subject;
    subject.form_ = form;
    subject.scene_ = std::make_unique<core::Scene>(
        form.method == Method::kTriangles ? apps::tessellated(scene, form.segments) : scene);
    engine::EngineConfig engine_config;
    engine_config.draw = true;
    engine_config.ids = true;
    engine_config.width = config.width;
    engine_config.height = config.height;
    engine_config.context = &context;
    auto engine = engine::Engine::create(*subject.scene_, engine_config);
    if (!engine) return tl::unexpected(engine.error());
    subject.engine_ = std::make_unique<engine::Engine>(std::move(*engine));
    return subject;
  }

  /// Milliseconds until the picture is complete.
  core::Expected<double> draw(const core::View& view) {
    engine_->finish();
    const double begin = milliseconds();
    auto frame = engine_->frame(view);
    if (!frame) return tl::unexpected(frame.error());
    engine_->finish();
    return milliseconds() - begin;
  }

  const Form& form() const { return form_; }
  Picture picture(const core::View& view) const {
    const render::RenderTarget& target = engine_->drawing()->target();
    return {target.read_colour(), target.read_ids(), target.read_depth(view)};
  }
  std::size_t gpu_bytes() const { return engine_->memory().gpu - engine_->drawing()->target().memory_bytes(); }

 private:
  Form form_;
  std::unique_ptr<core::Scene> scene_;  // must outlive the engine
  std::unique_ptr<engine::Engine> engine_;
};

struct Reference {
  std::vector<Picture> pictures;  // by view
  std::vector<double> ms;
  std::size_t gpu_bytes = 0;
};

core::Expected<Reference> draw_reference(gl::Context& context, const core::Scene& scene,
                                         std::span<const NamedView> views, const ModelConfig& config) {
  auto subject = Subject::create(context, scene, {Method::kTriangles, config.reference_segments}, config);
  if (!subject) return tl::unexpected(subject.error());
  Reference reference;
  for (const NamedView& named : views) {
    auto ms = subject->draw(named.view);
    if (!ms) return tl::unexpected(ms.error());
    reference.ms.push_back(*ms);
    reference.pictures.push_back(subject->picture(named.view));
  }
  reference.gpu_bytes = subject->gpu_bytes();
  return reference;
}

core::Expected<void> compare(const Picture& triangles, const Picture& ray_cast, const Picture& picture,
                             ModelFigures& figures) {
  auto metrics = image::image_metrics(triangles.colour, picture.colour);
  if (!metrics) return tl::unexpected(metrics.error());
  figures.to_triangles = *metrics;
  metrics = image::image_metrics(ray_cast.colour, picture.colour);
  if (!metrics) return tl::unexpected(metrics.error());
  figures.to_ray_cast = *metrics;
  figures.wrong_ids = *image::wrong_ids(triangles.ids, picture.ids);
  figures.ties = count_ties(triangles, picture);
  figures.wrong_ids_to_ray_cast = *image::wrong_ids(ray_cast.ids, picture.ids);
  return {};
}

/// Times all forms in turns, so that other load of the machine affects all equally.
core::Expected<std::vector<double>> time_in_turns(std::vector<Subject>& subjects, const core::View& view, int passes) {
  std::vector<std::vector<double>> times(subjects.size());
  for (int pass = -1; pass < passes; ++pass)  // the first pass compiles
    for (std::size_t i = 0; i < subjects.size(); ++i) {
      auto ms = subjects[i].draw(view);
      if (!ms) return tl::unexpected(ms.error());
      if (pass >= 0) times[i].push_back(*ms);
    }
  std::vector<double> medians;
  medians.reserve(times.size());
  for (auto& of_subject : times) medians.push_back(apps::median(std::move(of_subject)));
  return medians;
}

}  // namespace

core::Expected<std::vector<ModelResult>> measure_model(gl::Context& context, const core::Scene& scene,
                                                       std::span<const NamedView> views, const ModelConfig& config,
                                                       const Report& report) {
  const double steps = double(views.size()) + 1.0;
  auto reference = draw_reference(context, scene, views, config);
  if (!reference) return tl::unexpected(reference.error());
  if (report) report(1.0 / steps);

  std::vector<Form> forms{{Method::kGlsl, 0}};
  for (const int segments : config.segments) forms.push_back({Method::kTriangles, segments});
  std::vector<Subject> subjects;
  for (const Form& form : forms) {
    auto subject = Subject::create(context, scene, form, config);
    if (!subject) return tl::unexpected(subject.error());
    subjects.push_back(std::move(*subject));
  }

  std::vector<ModelResult> results;
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto times = time_in_turns(subjects, views[v].view, config.passes);
    if (!times) return tl::unexpected(times.error());
    ModelResult result{views[v].name, {}};
    Picture ray_cast;
    const auto add = [&](const Form& form, double ms, std::size_t gpu_bytes, const Picture& picture) {
      ModelFigures figures;
      figures.form = form;
      figures.ms = ms;
      figures.gpu_bytes = gpu_bytes;
      auto done = compare(reference->pictures[v], ray_cast, picture, figures);
      result.forms.push_back(figures);
      return done;
    };
    for (std::size_t i = 0; i < subjects.size(); ++i) {
      if (auto ms = subjects[i].draw(views[v].view); !ms) return tl::unexpected(ms.error());
      Picture picture = subjects[i].picture(views[v].view);
      if (i == 0) ray_cast = picture;
      if (auto done = add(subjects[i].form(), (*times)[i], subjects[i].gpu_bytes(), picture); !done)
        return tl::unexpected(done.error());
    }
    const Form last{Method::kTriangles, config.reference_segments};
    if (auto done = add(last, reference->ms[v], reference->gpu_bytes, reference->pictures[v]); !done)
      return tl::unexpected(done.error());
    results.push_back(std::move(result));
    if (report) report((double(v) + 2.0) / steps);
  }
  return results;
}

}  // namespace sightline::bench
