#include <memory>

#include "sightline/apps/bench/error_time/error_time.h"
#include "sightline/apps/common/tessellated_scene.h"

namespace sightline::bench {
namespace {

using Method = Form::Method;

using apps::DrawnImage;
using apps::DrawnVariant;

core::Expected<DrawnVariant> make_variant(gl::Context& context, const core::Scene& scene, const Form& form,
                                          const ModelConfig& config) {
  auto drawn = std::make_shared<core::Scene>(form.method == Method::kTriangles ? apps::tessellated(scene, form.segments)
                                                                               : scene);
  engine::EngineConfig engine_config;
  engine_config.width = config.width;
  engine_config.height = config.height;
  engine_config.context.application = &context;
  return DrawnVariant::create(std::move(drawn), engine_config);
}

struct Reference {
  std::vector<DrawnImage> images;  // by view
  std::vector<double> ms;
  std::size_t gpu_bytes = 0;
};

core::Expected<Reference> draw_reference(gl::Context& context, const core::Scene& scene,
                                         std::span<const NamedView> views, const ModelConfig& config) {
  auto variant = make_variant(context, scene, {Method::kTriangles, config.reference_segments}, config);
  if (!variant) return tl::unexpected(variant.error());
  Reference reference;
  for (const NamedView& named : views) {
    auto ms = variant->draw(named.view);
    if (!ms) return tl::unexpected(ms.error());
    auto image = variant->image(named.view);
    if (!image) return tl::unexpected(image.error());
    reference.ms.push_back(*ms);
    reference.images.push_back(std::move(*image));
  }
  reference.gpu_bytes = variant->gpu_bytes();
  return reference;
}

core::Expected<void> compare(const DrawnImage& triangles, const DrawnImage& ray_cast, const DrawnImage& image,
                             ModelFigures& figures) {
  const auto to_triangles = apps::image_errors(triangles, image), to_ray_cast = apps::image_errors(ray_cast, image);
  if (!to_triangles || !to_ray_cast) return tl::unexpected((to_triangles ? to_ray_cast : to_triangles).error());
  figures.to_triangles = *to_triangles;
  figures.to_ray_cast = *to_ray_cast;
  return {};
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
  std::vector<DrawnVariant> variants;
  for (const Form& form : forms) {
    auto variant = make_variant(context, scene, form, config);
    if (!variant) return tl::unexpected(variant.error());
    variants.push_back(std::move(*variant));
  }

  std::vector<ModelResult> results;
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto times = apps::time_in_turns(variants, views[v].view, config.passes);
    if (!times) return tl::unexpected(times.error());
    ModelResult result{views[v].name, {}};
    DrawnImage ray_cast;
    const auto add = [&](const Form& form, double ms, std::size_t gpu_bytes, const DrawnImage& image) {
      ModelFigures figures;
      figures.form = form;
      figures.ms = ms;
      figures.gpu_bytes = gpu_bytes;
      auto done = compare(reference->images[v], ray_cast, image, figures);
      result.forms.push_back(figures);
      return done;
    };
    for (std::size_t i = 0; i < variants.size(); ++i) {
      if (auto ms = variants[i].draw(views[v].view); !ms) return tl::unexpected(ms.error());
      const auto image = variants[i].image(views[v].view);
      if (!image) return tl::unexpected(image.error());
      if (i == 0) ray_cast = *image;
      if (auto done = add(forms[i], (*times)[i], variants[i].gpu_bytes(), *image); !done)
        return tl::unexpected(done.error());
    }
    const Form last{Method::kTriangles, config.reference_segments};
    if (auto done = add(last, reference->ms[v], reference->gpu_bytes, reference->images[v]); !done)
      return tl::unexpected(done.error());
    results.push_back(std::move(result));
    if (report) report((double(v) + 2.0) / steps);
  }
  return results;
}

}  // namespace sightline::bench
