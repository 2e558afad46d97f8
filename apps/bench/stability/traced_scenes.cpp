#include "sightline/apps/bench/stability/traced_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/gpuprims/internal/tessellation.h"

namespace sightline::bench {
namespace {

using core::dmat3;
using core::dvec3;
using core::Kind;
using core::Primitive;
using core::Ray;
using core::Slot;

/// Up to 1, often much less.
float length(Random& random, double decades) {
  return float(random.below(3) ? random.log_uniform(-decades, 0.0) : random.uniform(0.3, 1.0));
}
float sweep(Random& random) {
  return random.below(3) ? float(random.uniform(0.001, 6.28)) : random.below(4) ? kWhole : length(random, 4.0);
}

/// Thin, flat, needles, near the horn, leaning: of size 1 or a few.
Primitive extreme_shape(Kind kind, Random& random) {
  const auto shift = [&](double most) { return random.below(2) ? float(random.uniform(-most, most)) : 0.0f; };
  switch (kind) {
    case Kind::kPyramid: {
      const bool apex = random.below(4) == 0;
      return core::Pyramid{length(random, 4),
                           length(random, 4),
                           apex ? 0.0f : length(random, 4),
                           apex ? 0.0f : length(random, 4),
                           shift(3.0),
                           shift(3.0),
                           length(random, 5)};
    }
    case Kind::kBox:
      return core::Box{length(random, 6), length(random, 6), length(random, 6)};
    case Kind::kRectangularTorus: {
      const float wall = length(random, 6);
      return core::RectangularTorus{float(1.0 - wall), 1.0f, length(random, 5), sweep(random)};
    }
    case Kind::kCircularTorus: {
      const float tube = length(random, 4);
      if (random.below(2)) return core::CircularTorus{1.0f, tube, sweep(random)};
      return core::CircularTorus{float(0.5 * (1.0 + random.sign() * random.log_uniform(-7.0, -0.5))), 0.5f,
                                 sweep(random)};  // near the horn
    }
    case Kind::kEllipticalDish:
      return core::EllipticalDish{length(random, 3), length(random, 6)};
    case Kind::kSphericalDish:
      return core::SphericalDish{length(random, 3), length(random, 6)};
    case Kind::kSnout: {
      const float top = random.below(3) ? length(random, 6) : 0.0f;
      const bool slanted = random.below(3) == 0;
      return core::Snout{length(random, 4),
                         top,
                         length(random, 4),
                         shift(3.0),
                         shift(3.0),
                         slanted ? shift(1.3) : 0.0f,
                         slanted ? shift(1.3) : 0.0f,
                         slanted ? shift(1.3) : 0.0f,
                         slanted ? shift(1.3) : 0.0f};
    }
    case Kind::kCylinder:
      return core::Cylinder{length(random, 5), length(random, 5)};
    default:
      return core::Sphere{length(random, 6)};
  }
}

/// Solids of eight sides, and loose triangles of bad shape: needles, slivers, large beside small, without area.
core::Mesh extreme_mesh(Random& random) {
  if (random.below(2)) {
    core::Mesh mesh;
    while (mesh.indices.empty())
      mesh = gpuprims::tessellate(extreme_shape(kSolids[random.below(9)], random),
                                  {.fixed_segments = 3 + random.below(6)});
    return mesh;
  }
  core::Mesh mesh;
  for (int i = 4 + random.below(20); i > 0; --i) {
    const dvec3 a = random.unit() * random.direction(), along = random.log_uniform(-5.0, 0.0) * random.direction();
    dvec3 b = a + along, c = a + random.log_uniform(-7.0, 0.0) * random.direction();
    if (random.below(4) == 0)
      c = a + random.uniform(-1.0, 2.0) * along + random.log_uniform(-8.0, -1.0) * random.direction();
    if (random.below(50) == 0) c = a;
    for (const dvec3& p : {a, b, c}) {
      mesh.indices.push_back(std::uint32_t(mesh.positions.size()));
      mesh.positions.emplace_back(p);
    }
  }
  return mesh;
}

dmat3 rotation(Random& random) {
  const dvec3 z = random.direction(),
              x = glm::normalize(glm::cross(z, std::fabs(z.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const double turn = random.uniform(0.0, 2.0 * std::numbers::pi);
  const dvec3 turned = std::cos(turn) * x + std::sin(turn) * glm::cross(z, x);
  return {turned, glm::cross(z, turned), z};
}

/// Rotated, often mirrored, sometimes stretched or sheared.
core::Affine placement(const dvec3& centre, double half, double scale, Random& random) {
  const double stretch = random.below(3) ? 1.0 : random.log_uniform(-3.0, 0.0);
  dmat3 linear = rotation(random) * dmat3{{scale * random.sign(), 0, 0}, {0, scale, 0}, {0, 0, scale * stretch}};
  if (random.below(4) == 0) linear = linear * rotation(random);
  return {linear, centre + half * random.unit() * random.direction()};
}

TracedItem item_of(const core::Snapshot& snapshot, Slot slot) {
  TracedItem item;
  item.slot = slot;
  item.frame = snapshot.world_from_item(slot);
  item.item_from_world = glm::inverse(item.frame.linear);
  core::AabbD box;
  if (snapshot.kind(slot) == Kind::kMesh) {
    item.mesh = &snapshot.mesh(slot);
    item.closed = core::enclosure(*item.mesh) != core::Enclosure::kNothing;
    for (const core::vec3& p : item.mesh->positions) {
      item.box.grow(dvec3(p));
      box.grow(core::transform_point(item.frame, dvec3(p)));
    }
    const dvec3 reach = glm::max(glm::abs(item.box.min), glm::abs(item.box.max));
    item.mesh_size = std::max({reach.x, reach.y, reach.z, 2.0 * glm::length(item.box.size())});
  } else {
    item.solid = snapshot.primitive(slot);
    item.reference.emplace(*item.solid);
    item.box = core::bounds(*item.solid, {});
    box = core::bounds(*item.solid, item.frame);
    Random random(1);
    constexpr int kPoints = 16;
    for (int i = 0; i < kPoints; ++i) item.inside += surface_point(*item.solid, random).point / double(kPoints);
    item.inside = core::transform_point(item.frame, item.inside);
  }
  item.diagonal = glm::length(box.size());
  return item;
}

/// A point on the item's surface, or near an edge of it, and a direction along the surface; in the world.
struct Target {
  dvec3 point, along;
};
Target target_on(const TracedItem& item, Random& random) {
  dvec3 point, along;
  if (item.mesh) {
    const auto& mesh = *item.mesh;
    const std::size_t triangle = std::size_t(random.below(int(mesh.indices.size() / 3)));
    const auto corner = [&](std::size_t i) { return dvec3(mesh.positions[mesh.indices[3 * triangle + i]]); };
    double u = random.unit(), v = random.unit();
    if (random.below(5) == 0) v = random.below(2) ? 0.0 : double(random.below(2));  // on an edge, or a corner
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    along = corner(1) - corner(0);
    point = corner(0) + u * along + v * (corner(2) - corner(0));
  } else {
    const SurfacePoint p = random.below(5) ? surface_point(*item.solid, random) : edge_point(*item.solid, random);
    point = p.point;
    along = p.along;
  }
  if (random.below(3) == 0)
    point += item.item_from_world * (0.5 * item.diagonal * random.log_uniform(-12.0, 0.0) * random.direction());
  return {core::transform_point(item.frame, point), item.frame.linear * along};
}

/// Ends of a ray that meets its target at t: up to twice as far, or just before or behind it.
void set_ends(Ray& ray, double t, Random& random) {
  const auto end = [&] {
    return t * (random.below(2) ? random.uniform(0.0, 2.0) : 1.0 + random.sign() * random.log_uniform(-12.0, 0.0));
  };
  if (random.below(3)) ray.t_max = end();
  if (random.below(3) == 0) ray.t_min = end();
}

Ray make_ray(const TracedScene& world, Random& random) {
  const TracedItem& item = world.items[std::size_t(random.below(int(world.items.size())))];
  const Target target = target_on(item, random);
  dvec3 direction = random.direction();
  if (random.below(5) == 0) {  // nearly along the surface
    const double size = glm::length(target.along);
    if (size > 0.0) direction = glm::normalize(target.along / size + random.log_uniform(-8.0, -1.0) * direction);
  } else if (random.below(4) == 0) {  // across what is thin
    const Target other = target_on(item, random);
    const double size = glm::length(other.point - target.point);
    if (size > 0.0) direction = (other.point - target.point) / size;
  } else if (random.below(10) == 0) {
    direction = dvec3(0.0);
    direction[random.below(3)] = random.sign();
  }
  if (!core::is_finite(direction) || direction == dvec3(0.0)) direction = {0.0, 0.0, 1.0};
  const double far = world.half * random.log_uniform(random.below(4) ? -1.0 : -4.0, random.below(4) ? 1.0 : 4.0);
  Ray ray{target.point - far * direction, random.log_uniform(-2.0, 2.0) * direction};
  if (!core::is_finite(ray.origin)) ray.origin = world.centre;
  if (random.below(4) == 0) set_ends(ray, far / glm::length(ray.direction), random);
  return ray;
}

/// The largest axis of the direction, and its signs. Rays that are traced side by side have them in common.
int direction_class(const Ray& ray) {
  const dvec3 size = glm::abs(ray.direction);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return 8 * axis + 4 * std::signbit(ray.direction.x) + 2 * std::signbit(ray.direction.y) +
         std::signbit(ray.direction.z);
}

}  // namespace

std::unique_ptr<TracedScene> make_traced_scene(TracedKind kind, Random& random) {
  auto world = std::make_unique<TracedScene>();
  world->half = random.log_uniform(-3.0, 4.0);
  if (random.below(4)) world->centre = random.log_uniform(0.0, 7.0) * random.direction();
  for (int i = 3 + random.below(6); i > 0; --i) {
    const Kind own = kind ? *kind : random.below(4) ? kSolids[random.below(9)] : Kind::kMesh;
    const double scale = world->half * random.log_uniform(-2.0, 0.0);
    const core::Affine placed = placement(world->centre, world->half, scale, random);
    if (own == Kind::kMesh) {
      const auto mesh = world->scene.add_mesh(extreme_mesh(random));
      if (mesh) world->scene.add_mesh_instance(world->scene.root(), *mesh, placed);
    } else {
      world->scene.add_primitive(world->scene.root(), extreme_shape(own, random), placed);
    }
  }
  if (!world->scene.commit()) return nullptr;
  world->snapshot = std::make_unique<core::Snapshot>(world->scene);
  auto tracer = raytrace::Tracer::create(*world->snapshot);
  if (!tracer) return nullptr;
  world->tracer = std::make_unique<raytrace::Tracer>(std::move(*tracer));
  for (Slot slot = 0; slot < world->snapshot->size(); ++slot)
    if (!world->snapshot->vacant(slot)) world->items.push_back(item_of(*world->snapshot, slot));
  return world;
}

std::vector<Ray> rays_at(const TracedScene& world, std::int64_t count, Random& random) {
  std::vector<Ray> rays;
  while (std::int64_t(rays.size()) < count) rays.push_back(make_ray(world, random));
  std::stable_sort(rays.begin(), rays.end(),
                   [](const Ray& a, const Ray& b) { return direction_class(a) < direction_class(b); });
  return rays;
}

}  // namespace sightline::bench
