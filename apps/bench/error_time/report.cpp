#include "sightline/apps/bench/error_time/report.h"

#include <cmath>
#include <sstream>

#include "sightline/apps/common/output.h"
#include "sightline/apps/common/svg_plot.h"

namespace sightline::bench {
namespace {

using Json = json::Value;
using Method = Form::Method;

std::string kind_of(const KindResult& result) {
  return std::string(core::name_of(result.kind));
}

/// Short text with three significant digits.
std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value >= 100.0 ? "%.0f" : "%.3g", value);
  return text;
}

Json spread(const apps::Summary& s) {
  return {{"mean", s.mean}, {"p99", s.p99}, {"max", s.max}};
}

Json image_json(const image::ImageMetrics& m, std::uint64_t wrong_ids) {
  return {{"psnr", m.psnr},
          {"ssim", m.ssim},
          {"flip", {{"mean", m.flip_mean}, {"p99", m.flip_p99}}},
          {"wrong_ids", wrong_ids}};
}

double silhouette_of(const SampleErrors& e) {
  return e.silhouette_mean;
}
double depth_of(const SampleErrors& e) {
  return e.depth.mean;
}
double normal_of(const SampleErrors& e) {
  return e.normal.mean;
}

/// The first triangles with that many segments, or else the last ones; and the GLSL.
template <class Figures>
std::pair<const Figures*, const Figures*> compared(const std::vector<Figures>& forms) {
  constexpr int kSegments = 24;
  const Figures *triangles = nullptr, *glsl = nullptr;
  for (const Figures& f : forms) {
    const bool enough = triangles && triangles->form.segments >= kSegments;
    if (f.form.method == Method::kTriangles && !enough) triangles = &f;
    if (f.form.method == Method::kGlsl) glsl = &f;
  }
  return {triangles, glsl};
}

std::string size_name(const KindResult& result) {
  return short_text(result.size.pixels) + " px";
}

/// Triangles are one line; each other form is a point.
std::vector<apps::PanelSeries> series_of(const KindResult& result, double (*error)(const SampleErrors&)) {
  std::vector<apps::PanelSeries> all{{"triangles, " + size_name(result), {}}};
  for (const KindFigures& f : result.forms) {
    if (f.form.method == Method::kDouble) continue;  // the reference
    const apps::PanelSeries::Point point{f.ms, error(f.errors),
                                         f.form.segments > 0 ? std::to_string(f.form.segments) : ""};
    if (f.form.method == Method::kTriangles) {
      all[0].points.push_back(point);
    } else {
      all.push_back({name_of(f.form) + ", " + size_name(result), {point}});
    }
  }
  return all;
}

core::Expected<void> write_kind_plot(const std::vector<KindResult>& results, const std::string& file,
                                     const std::string& label, double (*error)(const SampleErrors&)) {
  std::vector<apps::Panel> panels;
  for (const KindResult& result : results) {
    if (panels.empty() || panels.back().title != kind_of(result)) panels.push_back({kind_of(result), {}});
    for (auto& series : series_of(result, error)) panels.back().series.push_back(std::move(series));
  }
  return apps::write_text(file, apps::svg_panels({"Error against time", "ms per frame", label, std::move(panels)}));
}

core::Expected<void> write_model_plot(const std::vector<NamedModel>& models, const std::string& file,
                                      const std::string& label, double (*cost)(const ModelFigures&)) {
  std::vector<apps::Panel> panels;
  for (const NamedModel& model : models)
    for (const ModelResult& view : model.views) {
      apps::PanelSeries triangles{"triangles", {}}, ray_cast{"GLSL", {}};
      for (std::size_t i = 0; i + 1 < view.forms.size(); ++i) {  // the last is the reference
        const ModelFigures& f = view.forms[i];
        if (f.form.method == Method::kTriangles) {
          triangles.points.push_back({cost(f), f.to_triangles.flip_mean, std::to_string(f.form.segments)});
        } else {
          ray_cast.points.push_back({cost(f), f.to_triangles.flip_mean, ""});
        }
      }
      panels.push_back({model.name + ", " + view.view, {std::move(triangles), std::move(ray_cast)}});
    }
  return apps::write_text(
      file, apps::svg_panels({"Error of the image against its cost", label, "mean FLIP", std::move(panels)}));
}

}  // namespace

void print(const KindResult& result, std::FILE* out) {
  std::fprintf(out,
               "\n%s, %s across: %d items in %d image(s), %llu samples hit, %.0f rays a frame, empty frame %.2f ms\n\n"
               "| form         | ms/frame | ns/ray | bytes/item | depth, mean |     p99 | normal, mean ° |    p99 | "
               "silhouette, mean px |    max | false hits | false misses |\n"
               "| ------------ | -------: | -----: | ---------: | ----------: | ------: | -------------: | -----: | "
               "------------------: | -----: | ---------: | -----------: |\n",
               kind_of(result).c_str(), size_name(result).c_str(),
               result.size.columns * result.size.rows * result.size.images, result.size.images,
               (unsigned long long)result.forms.front().errors.hits, result.rays, result.empty_frame_ms);
  for (const KindFigures& f : result.forms) {
    const std::string ns = f.form.on_cpu() ? short_text(f.ns_per_ray) : "";
    const std::string bytes = f.form.on_cpu() ? "" : short_text(f.bytes_per_item);
    const SampleErrors& e = f.errors;
    std::fprintf(out, "| %-12s | %8s | %6s | %10s | ", name_of(f.form).c_str(), short_text(f.ms).c_str(), ns.c_str(),
                 bytes.c_str());
    if (f.form.method == Method::kDouble) {
      std::fprintf(out, "%11s | %7s | %14s | %6s | %19s | %6s | %10s | %12s |\n", "reference", "", "", "", "", "", "",
                   "");
      continue;
    }
    std::fprintf(out, "%11s | %7s | %14s | %6s | %19s | %6s | %10llu | %12llu |\n", short_text(e.depth.mean).c_str(),
                 short_text(e.depth.p99).c_str(), short_text(e.normal.mean).c_str(), short_text(e.normal.p99).c_str(),
                 short_text(e.silhouette_mean).c_str(), short_text(e.silhouette_max).c_str(),
                 (unsigned long long)e.false_hits, (unsigned long long)e.false_misses);
  }
}

void print(const NamedModel& model, std::FILE* out) {
  for (const ModelResult& view : model.views) {
    std::fprintf(out,
                 "\n%s, %s: %zu items\n\n"
                 "| form         | ms/frame |  GPU kB |  PSNR |    SSIM | FLIP, mean |    p99 | wrong ids |    ties | "
                 "FLIP to GLSL | "
                 "ids to GLSL |\n"
                 "| ------------ | -------: | ------: | ----: | ------: | ---------: | -----: | --------: | ------: | "
                 "-----------: | "
                 "----------: |\n",
                 model.name.c_str(), view.view.c_str(), model.items);
    for (const ModelFigures& f : view.forms) {
      const image::ImageMetrics& m = f.to_triangles;
      std::fprintf(out, "| %-12s | %8s | %7.0f | %5.2f | %.5f | %10.5f | %6.4f | %9llu | %7llu | %12.5f | %11llu |\n",
                   name_of(f.form).c_str(), short_text(f.ms).c_str(), double(f.gpu_bytes) / 1024.0, m.psnr, m.ssim,
                   m.flip_mean, m.flip_p99, (unsigned long long)f.to_triangles.wrong_ids,
                   (unsigned long long)f.to_triangles.ties, f.to_ray_cast.flip_mean,
                   (unsigned long long)f.to_ray_cast.wrong_ids);
    }
  }
}

void print_summary(const std::vector<KindResult>& results, std::FILE* out) {
  std::fprintf(
      out,
      "\nGLSL / triangles\n\n"
      "| kind, size | triangles | ms | ratio | bytes/item | silhouette, mean px | depth, mean | normal, mean ° | "
      "wrong samples of | ns/ray |\n"
      "| --- | --- | --: | --: | --: | --: | --: | --: | --: | --: |\n");
  for (const KindResult& result : results) {
    const auto [triangles, glsl] = compared(result.forms);
    std::string ns;
    for (const KindFigures& f : result.forms)
      if (f.form.on_cpu()) ns = short_text(f.ns_per_ray);
    const auto both = [&](double of_glsl, double of_triangles) {
      return short_text(of_glsl) + " / " + short_text(of_triangles);
    };
    const SampleErrors &g = glsl->errors, &t = triangles->errors;
    std::fprintf(out, "| %s, %s | %s | %s | %.2f | %s | %s | %s | %s | %llu / %llu of %llu | %s |\n",
                 kind_of(result).c_str(), size_name(result).c_str(), name_of(triangles->form).c_str(),
                 both(glsl->ms, triangles->ms).c_str(), glsl->ms / triangles->ms,
                 both(glsl->bytes_per_item, triangles->bytes_per_item).c_str(),
                 both(g.silhouette_mean, t.silhouette_mean).c_str(), both(g.depth.mean, t.depth.mean).c_str(),
                 both(g.normal.mean, t.normal.mean).c_str(), (unsigned long long)g.wrong(),
                 (unsigned long long)t.wrong(), (unsigned long long)g.hits, ns.c_str());
  }
}

void print_summary(const std::vector<NamedModel>& models, std::FILE* out) {
  std::fprintf(
      out,
      "\nGLSL / triangles\n\n"
      "| model, view | triangles | ms | ratio | GPU kB | ratio | PSNR | SSIM | FLIP, mean | FLIP, p99 | wrong ids "
      "but ties |\n"
      "| --- | --- | --: | --: | --: | --: | --: | --: | --: | --: | --: |\n");
  for (const NamedModel& model : models)
    for (const ModelResult& view : model.views) {
      const std::vector<ModelFigures> forms(view.forms.begin(), view.forms.end() - 1);  // without the reference
      const auto [triangles, glsl] = compared(forms);
      const apps::ImageErrors &g = glsl->to_triangles, &t = triangles->to_triangles;
      std::fprintf(out,
                   "| %s, %s | %s | %s / %s | %.2f | %.0f / %.0f | %.2f | %.1f / %.1f | %.5f / %.5f | %.5f / %.5f | "
                   "%.4f / %.4f | %llu / %llu |\n",
                   model.name.c_str(), view.view.c_str(), name_of(triangles->form).c_str(),
                   short_text(glsl->ms).c_str(), short_text(triangles->ms).c_str(), glsl->ms / triangles->ms,
                   double(glsl->gpu_bytes) / 1024.0, double(triangles->gpu_bytes) / 1024.0,
                   double(glsl->gpu_bytes) / double(triangles->gpu_bytes), g.psnr, t.psnr, g.ssim, t.ssim, g.flip_mean,
                   t.flip_mean, g.flip_p99, t.flip_p99, (unsigned long long)(g.wrong_ids - g.ties),
                   (unsigned long long)(t.wrong_ids - t.ties));
    }
}

Json to_json(const KindResult& result) {
  Json forms = Json::array();
  for (const KindFigures& f : result.forms) {
    const SampleErrors& e = f.errors;
    Json row{{"form", name_of(f.form)}, {"segments", f.form.segments}, {"ms", f.ms}};
    if (f.form.on_cpu()) {
      row["ns_per_ray"] = f.ns_per_ray;
    } else {
      row["bytes_per_item"] = f.bytes_per_item;
    }
    row.update({{"depth", spread(e.depth)},
                {"normal_deg", spread(e.normal)},
                {"silhouette_px", {{"mean", e.silhouette_mean}, {"max", e.silhouette_max}}},
                {"false_hits", e.false_hits},
                {"false_misses", e.false_misses}});
    forms.push_back(std::move(row));
  }
  return {{"primitive", kind_of(result)},
          {"pixels", result.size.pixels},
          {"items", result.size.columns * result.size.rows * result.size.images},
          {"images", result.size.images},
          {"samples_hit", result.forms.front().errors.hits},
          {"rays", result.rays},
          {"empty_frame_ms", result.empty_frame_ms},
          {"forms", std::move(forms)}};
}

Json to_json(const NamedModel& model) {
  Json views = Json::array();
  for (const ModelResult& view : model.views) {
    Json forms = Json::array();
    for (const ModelFigures& f : view.forms)
      forms.push_back({{"form", name_of(f.form)},
                       {"segments", f.form.segments},
                       {"ms", f.ms},
                       {"gpu_bytes", f.gpu_bytes},
                       {"ties", f.to_triangles.ties},
                       {"to_triangles", image_json(f.to_triangles, f.to_triangles.wrong_ids)},
                       {"to_ray_cast", image_json(f.to_ray_cast, f.to_ray_cast.wrong_ids)}});
    views.push_back({{"view", view.view}, {"forms", std::move(forms)}});
  }
  return {{"model", model.name}, {"items", model.items}, {"views", std::move(views)}};
}

std::string to_csv(const std::vector<KindResult>& results) {
  std::ostringstream csv;
  csv << "primitive,pixels,form,segments,ms,ns_per_ray,bytes_per_item,depth_mean,depth_p99,depth_max,normal_deg_mean,"
         "normal_deg_p99,normal_deg_max,silhouette_px_mean,silhouette_px_max,samples_hit,false_hits,false_misses\n";
  for (const KindResult& result : results)
    for (const KindFigures& f : result.forms) {
      const SampleErrors& e = f.errors;
      csv << kind_of(result) << ',' << result.size.pixels << ',' << name_of(f.form) << ',' << f.form.segments << ','
          << f.ms << ',' << f.ns_per_ray << ',' << f.bytes_per_item;
      for (const apps::Summary& s : {e.depth, e.normal}) csv << ',' << s.mean << ',' << s.p99 << ',' << s.max;
      csv << ',' << e.silhouette_mean << ',' << e.silhouette_max << ',' << e.hits << ',' << e.false_hits << ','
          << e.false_misses << '\n';
    }
  return csv.str();
}

std::string to_csv(const std::vector<NamedModel>& models) {
  std::ostringstream csv;
  csv << "model,view,form,segments,ms,gpu_bytes,psnr,ssim,flip_mean,flip_p99,wrong_ids,ties,to_ray_cast_psnr,"
         "to_ray_cast_ssim,to_ray_cast_flip_mean,to_ray_cast_flip_p99,to_ray_cast_wrong_ids\n";
  for (const NamedModel& model : models)
    for (const ModelResult& view : model.views)
      for (const ModelFigures& f : view.forms) {
        csv << model.name << ',' << view.view << ',' << name_of(f.form) << ',' << f.form.segments << ',' << f.ms << ','
            << f.gpu_bytes;
        const auto add = [&](const image::ImageMetrics& m, std::uint64_t wrong) {
          csv << ',' << m.psnr << ',' << m.ssim << ',' << m.flip_mean << ',' << m.flip_p99 << ',' << wrong;
        };
        add(f.to_triangles, f.to_triangles.wrong_ids);
        csv << ',' << f.to_triangles.ties;
        add(f.to_ray_cast, f.to_ray_cast.wrong_ids);
        csv << '\n';
      }
  return csv.str();
}

core::Expected<void> write_plots(const std::vector<KindResult>& results, const std::string& prefix) {
  auto done = write_kind_plot(results, prefix + "-silhouette.svg", "silhouette error, mean, pixels", silhouette_of);
  if (done) done = write_kind_plot(results, prefix + "-depth.svg", "relative depth error, mean", depth_of);
  if (done) done = write_kind_plot(results, prefix + "-normal.svg", "normal error, mean, degrees", normal_of);
  return done;
}

core::Expected<void> write_plots(const std::vector<NamedModel>& models, const std::string& prefix) {
  auto done =
      write_model_plot(models, prefix + "-time.svg", "ms per frame", [](const ModelFigures& f) { return f.ms; });
  if (!done) return done;
  return write_model_plot(models, prefix + "-bytes.svg", "kB of GPU memory",
                          [](const ModelFigures& f) { return double(f.gpu_bytes) / 1024.0; });
}

}  // namespace sightline::bench
