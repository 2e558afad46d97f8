#include "sightline/apps/bench/stability/view_rays.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"

namespace sightline::bench {
namespace {

using core::dmat3;
using core::dvec3;
using core::Kind;

constexpr int kWidth = 40, kHeight = 30;
constexpr double kDegree = std::numbers::pi / 180.0;

/// Largest distance of the bounds' corners from their centre.
double half_size(const core::AabbD& box) {
  return 0.5 * glm::length(box.max - box.min);
}

struct Seen {
  dvec3 site{0.0};
  double distance = 8.0;  // radii
  double fovy = 0.0;      // 0: the one that the shape fills from there; otherwise the distance follows from it
};

/// A plain shape, seen as wanted.
ViewCase make_case(Kind kind, const char* family, double magnitude, const Seen& seen, Random& random) {
  const auto& [site, distance, fovy] = seen;
  ViewCase c{kind, family, magnitude, {}, {}};
  Image& p = c.image;
  p.primitive = plain_shape(kind, random);
  p.radius = radius_of(p.primitive);
  p.world_from_item.origin = site;
  const core::AabbD box = core::bounds(p.primitive, p.world_from_item);
  const dvec3 middle = 0.5 * (box.min + box.max);
  const double size = half_size(box);
  double away = distance * p.radius;
  if (fovy > 0.0) away = size * std::max(1.1, 1.0 / std::tan(0.5 * fovy));
  p.fovy = fovy > 0.0 ? fovy : 2.0 * std::atan(size / away);
  const dvec3 direction = random.direction();
  p.pose = {middle + away * direction, middle, {0.0, 0.0, 1.0}};
  p.near = 1e-3 * away;

  const double radii = (away + size) / p.radius, pixel = 2.0 * radii * std::tan(0.5 * p.fovy) / kHeight;
  const double reach = size / p.radius;
  c.limits = {1e-4 + 0x1p-22 * radii, 1.0, 0x1p-21 * reach + pixel / 128.0, 0.0};
  return c;
}

core::Ray pixel_ray(const Image& p, const dmat3& world_from_eye, int x, int y) {
  const double up = std::tan(0.5 * p.fovy), across = up * kWidth / kHeight;
  const dvec3 eye((2.0 * (x + 0.5) / kWidth - 1.0) * across, (1.0 - 2.0 * (y + 0.5) / kHeight) * up, -1.0);
  return {p.pose.eye, world_from_eye * eye};
}

}  // namespace

std::string ViewCase::name() const {
  char text[64];
  std::snprintf(text, sizeof(text), "%s %.7g", family.c_str(), magnitude);
  return text;
}

std::vector<ViewCase> view_cases(std::uint64_t seed) {
  std::vector<ViewCase> cases;
  for (const Kind kind : {Kind::kCylinder, Kind::kSnout, Kind::kCircularTorus, Kind::kRectangularTorus, Kind::kSphere,
                          Kind::kSphericalDish, Kind::kEllipticalDish, Kind::kBox, Kind::kPyramid}) {
    Random random(seed + std::uint64_t(kind));
    for (int e = 1; e <= 8; ++e) {
      const double ratio = std::pow(10.0, e);
      cases.push_back(make_case(kind, "near-far", ratio, {}, random));
      Image& p = cases.back().image;
      // The near and far plane are as far apart as requested, with the item between them.
      const core::AabbD box = core::bounds(p.primitive, p.world_from_item);
      const double size = half_size(box), away = glm::length(p.pose.eye - p.pose.target);
      p.near =
          std::max(1e-3, std::min(0.9, std::pow(ratio, -random.unit()))) * std::max(0.5 * size, away - 1.05 * size);
      p.far = std::max(ratio * p.near, away + 1.05 * size);
    }
    for (const double degrees : {0.01, 0.1, 1.0, 10.0, 45.0, 90.0, 120.0, 150.0, 170.0})
      cases.push_back(make_case(kind, "field-of-view", degrees, {.fovy = degrees * kDegree}, random));
    for (int e = 0; e <= 7; ++e)
      cases.push_back(
          make_case(kind, "view-offset", std::pow(10.0, e), {.site = std::pow(10.0, e) * random.direction()}, random));
    for (int e = 1; e <= 7; ++e)
      cases.push_back(make_case(kind, "view-distance", std::pow(10.0, e), {.distance = std::pow(10.0, e)}, random));
  }
  return cases;
}

core::Expected<ViewRays> ViewRays::create(gl::ContextPlatform platform) {
  auto context = gl::Context::create_offscreen({.platform = platform});
  if (!context) return tl::unexpected(context.error());
  return ViewRays(std::move(*context));
}

core::Expected<CaseErrors> ViewRays::judge_image(const ViewCase& c, int rays) {
  const Image& p = c.image;
  core::Scene scene;
  const core::NodeId node = scene.add_node(scene.root(), "item", p.world_from_item);
  scene.add_primitive(node, p.primitive);
  engine::EngineConfig config;
  config.culling.culler = engine::CullerChoice::kLinear;
  config.draw = true;
  config.drawing.ids = true;
  config.width = kWidth;
  config.height = kHeight;
  config.context.application = &context_;
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return tl::unexpected(engine.error());
  const auto view = core::View::perspective(p.pose, p.fovy, double(kWidth) / kHeight, p.near, p.far);
  if (!view) return tl::unexpected(view.error());
  if (const auto drawn = engine->frame(*view); !drawn) return tl::unexpected(drawn.error());
  engine->finish();
  const image::DepthImage depth = engine::EngineParts::drawing(*engine)->target().read_depth(*view);
  const image::IdImage ids = engine::EngineParts::drawing(*engine)->target().read_ids();

  const dmat3 world_from_eye = glm::transpose(dmat3(view->eye_from_world()));
  std::vector<Sample> samples;
  std::vector<Truth> truths;
  std::vector<Answer> answers;
  const bool wide = p.fovy > 100.0 * kDegree;  // the item fills only a few pixels, so test all of them
  const int step = wide ? 1 : std::max(1, kWidth * kHeight / rays);
  for (int pixel = 0; pixel < kWidth * kHeight; pixel += step) {
    samples.push_back(
        {p.primitive, p.world_from_item, pixel_ray(p, world_from_eye, pixel % kWidth, pixel / kWidth), p.radius});
    truths.push_back(find_truth(samples.back()));
    const std::vector<Crossing>& crossings = truths.back().crossings;  // all lie between near and far plane
    Answer answer;
    answer.first_only = true;
    const double t = double(depth.metres[std::size_t(pixel)]);
    // The id says whether the pixel shows the item. If it does, depth must be a number.
    if (ids.ids[std::size_t(pixel)] != 0)
      answer.hits.insert({t, crossings.empty() ? dvec3(0.0, 0.0, 1.0) : crossings.front().normal, 0});
    answers.push_back(answer);
  }
  return judge(samples, truths, answers, c.limits);
}

}  // namespace sightline::bench
