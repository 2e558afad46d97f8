// sightline-study supersampling: what samples cost and gain in traced images, everywhere or only at edges. Table 6-1
// and graph 6-9 of the dissertation about RT² (2011), and beside them the error, which it does not tell.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/apps/study/tables/subcommands.h"
#include "sightline/raytrace/whitted.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::study {
namespace {

struct SampleOptions {
  apps::ModelOptions model;
  apps::ViewOptions view;
  std::vector<int> samples{4, 9, 16, 25};
  std::vector<double> thresholds{0.05, 0.2};
  int reference = 64, passes = 3;
  std::string json;
};

void add_options(apps::CommandLine& line, SampleOptions& o) {
  apps::add_model_options(line, o.model);
  apps::add_view_options(line, o.view);
  line.add("--samples", o.samples, "Per pixel").in_range(2, 4096).separated_by(',').shows_default();
  line.add("--thresholds", o.thresholds, "Gradients above which a pixel is at an edge")
      .in_range(0.0, 1.0)
      .separated_by(',')
      .shows_default();
  line.add("--reference", o.reference, "Samples per pixel of the image that errors are against")
      .in_range(2, 4096)
      .shows_default();
  line.add("--passes", o.passes, "Of which the least time counts").in_range(1, 1000).shows_default();
  apps::add_json_option(line, o.json);
  line.examples("  sightline-study supersampling plant.rvm --view view.json --size 960x540");
}

struct Sampling {
  int samples;
  std::optional<double> threshold;
  double seconds = std::numeric_limits<double>::infinity();
  raytrace::WhittedImage image = {};
};

std::vector<Sampling> variants_of(const SampleOptions& o) {
  std::vector<Sampling> variants{{1, {}}};
  for (const int samples : o.samples) {
    variants.push_back({samples, {}});
    for (const double threshold : o.thresholds) variants.push_back({samples, threshold});
  }
  return variants;
}

image::Image image_of(const raytrace::WhittedImage& image) {
  return {image.width, image.height, image.rgb};
}

void print_samples(const json::Value& json, std::FILE* out) {
  std::fprintf(out, "%7s %9s %9s %9s %9s %9s %9s\n", "samples", "threshold", "a pixel", "seconds", "speed-up", "FLIP",
               "FLIP p99");
  for (const json::Value& row : json["variants"]) {
    const std::string threshold = row["threshold"].is_null() ? "" : row["threshold"].dump();
    std::fprintf(out, "%7d %9s %9.2f %9.3f %9.2f %9.5f %9.4f\n", row["samples"].get<int>(), threshold.c_str(),
                 row["samples_per_pixel"].get<double>(), row["seconds"].get<double>(), row["speed_up"].get<double>(),
                 row["flip"]["mean"].get<double>(), row["flip"]["p99"].get<double>());
  }
}

core::Expected<int> run_samples(const SampleOptions& o) {
  const auto size = apps::parse_size(o.view.size);
  if (!size) return tl::unexpected(size.error());
  const auto [width, height] = *size;
  const auto model = apps::load_model(o.model);
  if (!model) return tl::unexpected(model.error());
  if (auto done = model->scene->commit(); !done) return tl::unexpected(done.error());
  const core::Snapshot snapshot(*model->scene);
  const auto view = apps::choose_view(o.view, *model, snapshot, double(width) / height);
  if (!view) return tl::unexpected(view.error());
  const auto tracer = raytrace::Tracer::create(snapshot);
  if (!tracer) return tl::unexpected(tracer.error());

  raytrace::WhittedOptions whitted;
  whitted.samples = o.reference;
  const auto reference = raytrace::render_whitted(*tracer, *view, width, height, whitted);
  if (!reference) return tl::unexpected(reference.error());
  std::vector<Sampling> variants = variants_of(o);
  whitted.threads = 1;
  for (int pass = 0; pass < o.passes; ++pass)  // in turns
    for (Sampling& variant : variants) {
      whitted.samples = variant.samples;
      whitted.edge_threshold = variant.threshold;
      const double start = bench::processor_milliseconds();
      auto image = raytrace::render_whitted(*tracer, *view, width, height, whitted);
      if (!image) return tl::unexpected(image.error());
      variant.seconds = std::min(variant.seconds, 1e-3 * (bench::processor_milliseconds() - start));
      variant.image = std::move(*image);
    }

  json::Value json{
      {"size", {width, height}}, {"items", snapshot.size()}, {"reference", o.reference}, {"passes", o.passes}};
  double uniform = 0.0;  // seconds for as many samples everywhere, which comes before
  for (const Sampling& variant : variants) {
    if (!variant.threshold) uniform = variant.seconds;
    const auto metrics = image::image_metrics(image_of(*reference), image_of(variant.image));
    if (!metrics) return tl::unexpected(metrics.error());
    json["variants"].push_back({{"samples", variant.samples},
                                {"threshold", variant.threshold ? json::Value(*variant.threshold) : json::Value()},
                                {"samples_per_pixel", double(variant.image.samples) / (double(width) * height)},
                                {"seconds", variant.seconds},
                                {"speed_up", uniform / variant.seconds},
                                {"flip", {{"mean", metrics->flip_mean}, {"p99", metrics->flip_p99}}}});
  }
  return bench::finish(o.json, json, print_samples);
}

}  // namespace

bench::Run add_supersampling(apps::CommandLine& line) {
  return bench::add_subcommand<SampleOptions>(line, add_options, run_samples);
}

}  // namespace sightline::study
