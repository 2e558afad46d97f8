// sightline-study transparency: how far blended and dithered transparency are from surfaces that are sorted exactly,
// and what they cost.
//
// Balls of random places and colours lie behind one another. The reference draws each of them alone and opaque, and
// blends these images pixel by pixel, from the farthest to the nearest.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/scene.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::transparency_bench {
namespace {

using Json = json::Value;
using core::ItemId;
using engine::Engine;
using engine::Transparency;

constexpr int kCell = 4;  // pixels: the side of the dither's pattern

struct Options {
  int frames = 9, seed = 1;
  std::string size = "640x360", json;
};

void add_options(apps::CommandLine& line, Options& o) {
  line.add("--frames", o.frames, "Timed for each image; the least counts").in_range(1, 1000).shows_default();
  line.add("--seed", o.seed, "Of places and colours").shows_default();
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(apps::parse_size);
  apps::add_json_option(line, o.json);
  line.examples("  sightline-study transparency\n  sightline-study transparency --seed 2 --json -");
}

/// Balls, each in front of the one before it.
struct Balls {
  core::Scene scene;
  std::vector<core::MaterialId> looks;
  std::vector<ItemId> items;

  Balls(int count, float alpha, unsigned seed) {
    std::mt19937 random(seed);
    const auto unit = [&] { return std::uniform_real_distribution<float>(0.0f, 1.0f)(random); };
    for (int i = 0; i < count; ++i) {
      looks.push_back(scene.add_material({"", {unit(), unit(), unit()}, alpha}));
      const core::dvec3 at(4.0 * unit() - 2.0, 3.0 * unit() - 1.5, -20.0 + 16.0 * (i + 0.5) / count);
      items.push_back(scene.add_primitive(scene.root(), core::Sphere{6.0f}, core::translation(at), looks.back()));
    }
  }
};

using Pixels = std::vector<double>;  // three channels each, 0 … 255

struct Image {
  Pixels colour;
  std::vector<std::uint32_t> ids;
  std::vector<float> depth;
  double ms = 0.0;  // of a frame
};

core::Expected<Image> draw(Engine& engine, const core::View& view, int frames) {
  Image image;
  for (int i = 0; i < frames; ++i) {
    const double start = milliseconds();
    if (auto report = engine.frame(view); !report) return tl::unexpected(report.error());
    engine.finish();
    const double ms = milliseconds() - start;
    image.ms = i == 0 ? ms : std::min(image.ms, ms);
  }
  const auto read = apps::read_image(engine, view);
  if (!read) return tl::unexpected(read.error());
  image.colour.assign(read->colour.pixels.begin(), read->colour.pixels.end());
  image.ids = read->ids.ids;
  image.depth = read->depth.metres;
  return image;
}

/// What exact sorting shows, from images of each ball alone.
Pixels sorted(const std::vector<Image>& alone, const Pixels& background, double alpha) {
  Pixels shown = background;
  std::vector<std::pair<float, const Image*>> layers;
  for (std::size_t pixel = 0; pixel < shown.size() / 3; ++pixel) {
    layers.clear();
    for (const Image& one : alone)
      if (one.ids[pixel] != 0) layers.emplace_back(one.depth[pixel], &one);
    std::sort(layers.rbegin(), layers.rend());
    for (std::size_t at = 3 * pixel; at < 3 * pixel + 3; ++at)
      for (const auto& [depth, one] : layers) shown[at] += alpha * (one->colour[at] - shown[at]);
  }
  return shown;
}

/// Means over cells of the dither's pattern.
Pixels blurred(const Pixels& colour, int width) {
  Pixels means;
  const int height = int(colour.size()) / 3 / width;
  for (int y = 0; y + kCell <= height; y += kCell)
    for (int x = 0; x + kCell <= width; x += kCell)
      for (int channel = 0; channel < 3; ++channel) {
        double sum = 0.0;
        for (int i = 0; i < kCell * kCell; ++i)
          sum += colour[std::size_t(3 * ((y + i / kCell) * width + x + i % kCell) + channel)];
        means.push_back(sum / (kCell * kCell));
      }
  return means;
}

Json error_of(const Pixels& shown, const Pixels& wanted) {
  double sum = 0.0, most = 0.0;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const double error = std::abs(shown[i] - wanted[i]);
    sum += error;
    most = std::max(most, error);
  }
  return {{"mean", sum / double(shown.size())}, {"max", most}};
}

core::Expected<Json> measure(int count, float alpha, const Options& o) {
  Balls balls(count, alpha, unsigned(o.seed));
  const auto [width, height] = *apps::parse_size(o.size);
  const core::View view =
      *core::View::perspective({{0, 0, 6}, {0, 0, -10}, {0, 1, 0}}, 0.6, double(width) / height, 0.1);
  Json row{{"balls", count}, {"alpha", alpha}};
  std::vector<Image> images;
  for (const Transparency mode : {Transparency::kBlended, Transparency::kDither}) {
    auto engine = Engine::create(
        balls.scene, {.draw = true, .width = width, .height = height, .drawing = {.ids = true, .transparency = mode}});
    if (!engine) return tl::unexpected(engine.error());
    auto image = draw(*engine, view, o.frames);
    if (!image) return tl::unexpected(image.error());
    images.push_back(std::move(*image));
  }
  for (const core::MaterialId look : balls.looks) {
    core::Material opaque = balls.scene.material(look);
    opaque.alpha = 1.0f;
    balls.scene.update_material(look, opaque);
  }
  auto engine = Engine::create(balls.scene, {.draw = true, .width = width, .height = height, .drawing = {.ids = true}});
  if (!engine) return tl::unexpected(engine.error());
  const auto opaque = draw(*engine, view, o.frames);
  if (!opaque) return tl::unexpected(opaque.error());
  if (auto done = engine->hide(balls.items); !done) return tl::unexpected(done.error());
  const auto background = draw(*engine, view, 1);
  if (!background) return tl::unexpected(background.error());
  std::vector<Image> alone;
  for (const ItemId item : balls.items) {
    if (auto done = engine->show({&item, 1}); !done) return tl::unexpected(done.error());
    auto one = draw(*engine, view, 1);
    if (!one) return tl::unexpected(one.error());
    alone.push_back(std::move(*one));
    if (auto done = engine->hide({&item, 1}); !done) return tl::unexpected(done.error());
  }
  const Pixels wanted = sorted(alone, background->colour, double(alpha));
  const Pixels wanted_means = blurred(wanted, width);
  for (const auto& [name, image] : {std::pair("blended", &images[0]), std::pair("dither", &images[1])})
    row[name] = {{"error", error_of(image->colour, wanted)},
                 {"error_of_means", error_of(blurred(image->colour, width), wanted_means)},
                 {"frame_ms", image->ms}};
  row["opaque_ms"] = opaque->ms;
  return row;
}

void print(const Json& json, std::FILE* out) {
  std::fprintf(out, "errors in steps of 255: mean (largest); of means over %d x %d pixels\n\n", kCell, kCell);
  std::fprintf(out, "%5s %5s | %-14s %-14s %8s | %-14s %-14s %8s | %8s\n", "balls", "alpha", "blended", "of means",
               "ms", "dither", "of means", "ms", "opaque ms");
  for (const Json& row : json["rows"]) {
    std::fprintf(out, "%5d %5.2f |", row["balls"].get<int>(), row["alpha"].get<double>());
    for (const char* mode : {"blended", "dither"}) {
      for (const char* error : {"error", "error_of_means"})
        std::fprintf(out, " %5.1f (%5.1f) ", row[mode][error]["mean"].get<double>(),
                     row[mode][error]["max"].get<double>());
      std::fprintf(out, "%8.2f |", row[mode]["frame_ms"].get<double>());
    }
    std::fprintf(out, " %8.2f\n", row["opaque_ms"].get<double>());
  }
}

core::Expected<int> run(const Options& o) {
  Json json{{"size", o.size}, {"seed", o.seed}, {"frames", o.frames}};
  for (const int count : {1, 2, 4, 8, 16, 32})
    for (const float alpha : {0.1f, 0.3f, 0.6f}) {
      auto row = measure(count, alpha, o);
      if (!row) return tl::unexpected(row.error());
      json["rows"].push_back(std::move(*row));
    }
  return finish(o.json, json, print);
}

}  // namespace
}  // namespace sightline::bench::transparency_bench

sightline::bench::Run sightline::bench::add_transparency(apps::CommandLine& line) {
  using namespace transparency_bench;
  return add_subcommand<Options>(line, add_options, run);
}
