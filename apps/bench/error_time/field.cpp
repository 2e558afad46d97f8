#include "sightline/apps/bench/error_time/field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <glm/gtc/quaternion.hpp>

namespace sightline::bench {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Kind;

constexpr std::array kKinds = {Kind::kCylinder,         Kind::kSnout,  Kind::kCircularTorus,
                               Kind::kRectangularTorus, Kind::kSphere, Kind::kSphericalDish,
                               Kind::kEllipticalDish,   Kind::kBox,    Kind::kPyramid};

constexpr double kFovy = std::numbers::pi / 6.0, kNear = 0.1, kBallRadius = 0.5;

class ItemRandom {
 public:
  explicit ItemRandom(std::uint32_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * double(engine_()) / 4294967296.0; }
  float length(double low, double high) { return float(uniform(low, high)); }

  dmat3 rotation() {
    for (;;) {
      const glm::dquat q(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      const double norm = glm::length(q);
      if (norm > 0.1 && norm <= 1.0) return glm::mat3_cast(q / norm);
    }
  }

 private:
  std::mt19937 engine_;
};

/// Proportions as in plants: neither needles nor sheets, which the stability report covers.
core::Primitive random_primitive(Kind kind, ItemRandom& random) {
  const auto length = [&](double low, double high) { return random.length(low, high); };
  switch (kind) {
    case Kind::kCylinder:
      return core::Cylinder{length(0.2, 1.0), length(0.3, 3.0)};
    case Kind::kSnout:
      return core::Snout{length(0.3, 1.0),  length(0.3, 1.0),  length(0.7, 2.0),  length(-0.4, 0.4), length(-0.4, 0.4),
                         length(-0.2, 0.2), length(-0.2, 0.2), length(-0.2, 0.2), length(-0.2, 0.2)};
    case Kind::kCircularTorus:
      return core::CircularTorus{1.0f, length(0.1, 0.7), length(0.5, 6.2)};
    case Kind::kRectangularTorus:
      return core::RectangularTorus{length(0.4, 0.8), length(1.0, 1.3), length(0.2, 0.8), length(0.5, 6.2)};
    case Kind::kSphere:
      return core::Sphere{length(0.5, 2.0)};
    case Kind::kSphericalDish:
      return core::SphericalDish{1.0f, length(0.15, 1.0)};
    case Kind::kEllipticalDish:
      return core::EllipticalDish{1.0f, length(0.15, 1.5)};
    case Kind::kBox:
      return core::Box{length(0.3, 1.5), length(0.3, 1.5), length(0.3, 1.5)};
    default:
      return core::Pyramid{length(0.5, 1.5),  length(0.5, 1.5),  length(0.1, 1.0), length(0.1, 1.0),
                           length(-0.4, 0.4), length(-0.4, 0.4), length(0.4, 1.5)};
  }
}

/// Scales and moves the primitive so that its ball is that of the item.
FieldItem place(const core::Primitive& primitive, const dmat3& rotation, const dvec3& centre) {
  const core::AabbD box = core::bounds(primitive, {});
  double radius = 0.0;
  for (const core::vec3& p : gpuprims::tessellate(primitive, {.fixed_segments = 64}).positions)
    radius = std::max(radius, glm::length(core::dvec3(p) - box.centre()));
  const dmat3 linear = rotation * dmat3(kBallRadius / radius);
  return {primitive, {linear, centre - linear * box.centre()}, centre};
}

/// Eye-space directions of unit depth through samples: x * right + y * up + ahead, with x and y in -1 … 1.
struct Directions {
  dvec3 right, up, ahead;
};
Directions directions(const core::View& view) {
  const dmat3 world_from_eye = glm::transpose(dmat3(view.eye_from_world()));
  return {world_from_eye[0] / view.clip_from_eye()[0][0], world_from_eye[1] / view.clip_from_eye()[1][1],
          -world_from_eye[2]};
}

ItemRays item_rays(const Field& field, const Directions& to, std::size_t item, int width, int height) {
  constexpr double kMargin = 1.005;  // balls are measured on triangles, which lie inside the surface
  const FieldItem& here = field.items[item];
  const int column = int(item) % field.columns, row = int(item) / field.columns;
  const dmat3 item_from_world = glm::inverse(here.world_from_item.linear);
  const dvec3 eye = field.view.eye(), origin = item_from_world * (eye - here.world_from_item.origin);
  const dvec3 to_centre = here.centre - eye;
  ItemRays out;
  for (int y = row * height / field.rows; y < (row + 1) * height / field.rows; ++y)
    for (int x = column * width / field.columns; x < (column + 1) * width / field.columns; ++x) {
      const dvec3 direction =
          (2.0 * (x + 0.5) / width - 1.0) * to.right + (1.0 - 2.0 * (y + 0.5) / height) * to.up + to.ahead;
      const double passes_at = glm::length(glm::cross(to_centre, direction)) / glm::length(direction);
      if (passes_at > kMargin * kBallRadius) continue;
      out.rays.push_back({origin, item_from_world * direction});
      out.samples.push_back(std::uint32_t(y) * std::uint32_t(width) + std::uint32_t(x));
    }
  return out;
}

}  // namespace

std::span<const Kind> measured_kinds() {
  return kKinds;
}

core::Scene Field::scene() const {
  core::Scene scene;
  for (const FieldItem& item : items) scene.add_primitive(scene.root(), item.primitive, item.world_from_item);
  return scene;
}

Field make_field(Kind kind, const FieldSize& size, int width, int height, std::uint32_t seed) {
  const double across = width / size.pixels, high = height / size.pixels;  // size of the image, in items
  const dvec3 eye(0.0, -0.5 * high / std::tan(0.5 * kFovy), 0.0);
  Field field{*core::View::perspective({eye, dvec3(0.0), {0, 0, 1}}, kFovy, double(width) / height, kNear),
              {},
              size.columns,
              size.rows};
  ItemRandom random(seed);
  for (int row = 0; row < size.rows; ++row)
    for (int column = 0; column < size.columns; ++column) {
      const dvec3 centre(across * ((column + 0.5) / size.columns - 0.5), 0.0, high * (0.5 - (row + 0.5) / size.rows));
      const core::Primitive primitive = random_primitive(kind, random);
      field.items.push_back(place(primitive, random.rotation(), centre));
    }
  return field;
}

std::vector<ItemRays> field_rays(const Field& field, int width, int height) {
  const Directions to = directions(field.view);
  std::vector<ItemRays> rays;
  for (std::size_t item = 0; item < field.items.size(); ++item)
    rays.push_back(item_rays(field, to, item, width, height));
  return rays;
}

void cast(const Field& field, const std::vector<ItemRays>& rays, int first_row, SampleImage& image) {
  const dmat3 eye_from_world(field.view.eye_from_world());
  const std::size_t first = std::size_t(first_row) * std::size_t(image.width);
  for (std::size_t item = 0; item < field.items.size(); ++item) {
    // Normals are gradients, so the inverse transpose transforms them.
    const dmat3 eye_from_gradient =
        eye_from_world * glm::transpose(glm::inverse(field.items[item].world_from_item.linear));
    for (std::size_t i = 0; i < rays[item].rays.size(); ++i) {
      const core::Ray& ray = rays[item].rays[i];
      const gpuprims::Hits hits = gpuprims::intersect(field.items[item].primitive, ray);
      const auto* end = hits.hit.begin() + hits.count;
      const auto* hit = std::find_if(hits.hit.begin(), end, [](const gpuprims::Hit& h) { return h.t >= kNear; });
      if (hit == end) continue;
      const std::size_t sample = first + rays[item].samples[i];
      const dvec3 normal = hit->normal * (glm::dot(hit->normal, ray.direction) > 0.0 ? -1.0 : 1.0);
      image.depth[sample] = hit->t;
      image.normals[sample] = core::vec3(glm::normalize(eye_from_gradient * normal));
    }
  }
}

}  // namespace sightline::bench
