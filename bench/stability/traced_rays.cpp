#include "sightline/bench/stability/traced_rays.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>

#include "sightline/bench/stability/reference.h"
#include "sightline/bench/stability/shapes.h"
#include "sightline/core/scene.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/gpuprims/internal/tessellation.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::bench {
namespace {

using core::dmat3;
using core::dvec3;
using core::Kind;
using core::Primitive;
using core::Slot;
using raytrace::Hit;
using raytrace::Ray;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kRaysPerScene = 1000;
constexpr float kWhole = 6.2831855f;  // the float next above 2 pi
constexpr Kind kSolids[] = {Kind::kCylinder,         Kind::kSnout,  Kind::kCircularTorus,
                            Kind::kRectangularTorus, Kind::kSphere, Kind::kSphericalDish,
                            Kind::kEllipticalDish,   Kind::kBox,    Kind::kPyramid};

// --- scenes ----------------------------------------------------------------------------------------------------------

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

/// What one item is, for the reference.
struct Item {
  Slot slot = core::kNone;
  core::Affine frame;
  dmat3 item_from_world;
  core::AabbD box;        // in its frame
  double diagonal = 0.0;  // of its box in the world
  dvec3 inside{0.0};      // a solid, if it is convex; in the world
  std::optional<Primitive> solid;
  std::optional<ReferenceSolid> reference;
  const core::Mesh* mesh = nullptr;
  bool closed = false;
  double mesh_size = 0.0;  // as tracer.h has it, in the mesh's units
};

struct World {
  core::Scene scene;
  std::unique_ptr<core::Snapshot> snapshot;
  std::unique_ptr<raytrace::Tracer> tracer;
  std::vector<Item> items;  // by slot
  dvec3 centre{0.0};
  double half = 1.0;
};

Item item_of(const core::Snapshot& snapshot, Slot slot) {
  Item item;
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

std::unique_ptr<World> make_world(TracedKind kind, Random& random) {
  auto world = std::make_unique<World>();
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

// --- rays ------------------------------------------------------------------------------------------------------------

/// A point on the item's surface, or near an edge of it, and a direction along the surface; in the world.
struct Target {
  dvec3 point, along;
};
Target target_on(const Item& item, Random& random) {
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

Ray make_ray(const World& world, Random& random) {
  const Item& item = world.items[std::size_t(random.below(int(world.items.size())))];
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

std::vector<Ray> rays_at(const World& world, std::int64_t count, Random& random) {
  std::vector<Ray> rays;
  while (std::int64_t(rays.size()) < count) rays.push_back(make_ray(world, random));
  std::stable_sort(rays.begin(), rays.end(),
                   [](const Ray& a, const Ray& b) { return direction_class(a) < direction_class(b); });
  return rays;
}

// --- judging ---------------------------------------------------------------------------------------------------------

/// Where an item may be crossed: low … high are right.
struct Expected {
  Slot slot = core::kNone;
  std::uint32_t triangle = core::kNone;
  double low = 0.0, high = 0.0;
  bool sure = true;  ///< false: no crossing is right, too
};

std::string digits(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

/// What queries of many rays answer for one of them.
struct ManyAnswer {
  Hit hit;  ///< its slot is kNone if there is none
  bool any;
};

class Judge {
 public:
  Judge(const World& world, std::string place, TracedFigures& figures)
      : world_(world), place_(std::move(place)), figures_(figures) {}

  /// `of_many`: nothing if they were refused.
  void add(const Ray& ray, const std::optional<ManyAnswer>& of_many) {
    ++figures_.rays;
    ray_ = ray;
    length_ = glm::length(ray.direction);
    wrong_ = graze_ = false;
    expected_.clear();
    Ray line = ray;
    line.t_min = -kInfinity;
    line.t_max = kInfinity;
    if (world_.tracer->all(line, all_)) {
      judge_all();
      judge_nearest(of_many);
    } else {
      fail("all() refused the ray");
    }
    figures_.grazes += graze_;
    figures_.wrong += wrong_;
  }

 private:
  void fail(const std::string& what) {
    wrong_ = true;
    if (figures_.examples.size() >= 10) return;
    char text[400];
    std::snprintf(text, sizeof(text),
                  "%s: %s; from (%.17g %.17g %.17g) along (%.17g %.17g %.17g), t from %.17g to %.17g", place_.c_str(),
                  what.c_str(), ray_.origin.x, ray_.origin.y, ray_.origin.z, ray_.direction.x, ray_.direction.y,
                  ray_.direction.z, ray_.t_min, ray_.t_max);
    figures_.examples.emplace_back(text);
  }
  std::string name(const Item& item) const {
    return std::string(core::name_of(world_.snapshot->kind(item.slot))) + " in slot " + std::to_string(item.slot);
  }
  static std::string described(const Item& item) {
    std::string text = "parameters";
    for (const float v : core::parameters(*item.solid)) text += " " + digits(v);
    return text;
  }
  /// The coordinates involved, in metres.
  double size(const Item& item) const {
    return glm::length(ray_.origin) + glm::length(item.frame.origin) + item.diagonal;
  }

  /// Whether the line comes near the item's box, in its frame. The margin is far above double's rounding.
  bool comes_near(const Item& item) const {
    const dvec3 origin = item.item_from_world * (ray_.origin - item.frame.origin);
    const dvec3 direction = item.item_from_world * ray_.direction;
    const double loss = per_metre(item) * size(item);
    double from = -kInfinity, to = kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
      const double margin = 1e-5 * glm::length(item.box.size()) + 1e-10 * loss;
      const double low = item.box.min[axis] - margin - origin[axis], high = item.box.max[axis] + margin - origin[axis];
      if (std::fabs(direction[axis]) <= 1e-10 * glm::length(direction)) {
        if (low > 1e-9 * loss || high < -1e-9 * loss) return false;
        continue;
      }
      const double a = low / direction[axis], b = high / direction[axis],
                   error = 1e-9 * std::fabs(a) + 1e-9 * std::fabs(b);
      from = std::max(from, std::min(a, b) - error);
      to = std::min(to, std::max(a, b) + error);
    }
    return from <= to;
  }
  /// The most that lengths grow from the world into the item's frame.
  static double per_metre(const Item& item) {
    const dmat3& inverse = item.item_from_world;
    return std::sqrt(glm::dot(inverse[0], inverse[0]) + glm::dot(inverse[1], inverse[1]) +
                     glm::dot(inverse[2], inverse[2]));
  }

  void judge_all() {
    figures_.crossings += std::int64_t(all_.size());
    for (const Item& item : world_.items) {
      found_.clear();
      for (const Hit& hit : all_)
        if (hit.slot == item.slot) found_.push_back(hit);
      judge_item(item);
    }
  }

  void judge_item(const Item& item) {
    if (!comes_near(item)) {
      if (!found_.empty()) fail(name(item) + " is hit from beside");
      return;
    }
    const QuadRay local = in_item_frame(item.frame, {ray_.origin, ray_.direction});
    if (item.mesh)
      judge_mesh(item, local);
    else
      judge_solid(item, local);
  }

  // --- solids ---

  double sine(const Item& item, const dvec3& local_normal) const {
    const dvec3 n = glm::transpose(item.item_from_world) * local_normal;
    const double size = glm::length(n);
    return size > 0.0 ? std::fabs(glm::dot(n, ray_.direction)) / (size * length_) : 0.0;
  }

  /// Whether an end of a snout or pyramid is an apex, which may be taken for the end as for a side.
  static bool has_apex(const Primitive& solid) {
    if (const auto* s = std::get_if<core::Snout>(&solid)) return s->bottom_radius * s->top_radius == 0.0f;
    const auto* p = std::get_if<core::Pyramid>(&solid);
    return p && (p->bottom_x * p->bottom_y == 0.0f || p->top_x * p->top_y == 0.0f);
  }
  /// The reference knows sides and two ends, level or of a sweep.
  static bool same_face(const Item& item, const Hit& hit, const Crossing& crossing) {
    if (has_apex(*item.solid)) return true;
    switch (hit.face) {
      case raytrace::Face::kBottom:
      case raytrace::Face::kBottomLevel:
      case raytrace::Face::kBelow:
        return crossing.face == kBottom;
      case raytrace::Face::kTop:
      case raytrace::Face::kTopLevel:
      case raytrace::Face::kAbove:
        return crossing.face == kTop;
      default:
        return crossing.face == kLateral;
    }
  }

  void judge_solid(const Item& item, const QuadRay& local) {
    const std::vector<Crossing> base = item.reference->crossings(local);
    const double shift = raytrace::kSolidError * size(item), step = shift / length_;
    bool right = base.size() == found_.size();
    double worst = 0.0;
    for (std::size_t i = 0; i < base.size(); ++i) {
      const double bound = step / std::max(sine(item, base[i].normal), 1e-12), t = double(base[i].t);
      expected_.push_back({item.slot, core::kNone, t - bound, t + bound, true});
      if (!right) continue;
      worst = std::max(worst, double(fabsq(Quad(found_[i].t) - base[i].t)) / bound);
      if (!same_face(item, found_[i], base[i])) worst = kInfinity;
    }
    if (right && worst <= 1.0) {
      figures_.worst = std::max(figures_.worst, worst);
      return;
    }
    expected_.resize(expected_.size() - base.size());
    judge_graze(item, base, shift);
  }

  /// Rays displaced by no more than the bound have other crossings, and so may this. The steps go down to about
  /// double's rounding, since solids may be as thin.
  static constexpr int kSteps = 9;
  void judge_graze(const Item& item, const std::vector<Crossing>& base, double shift) {
    const dvec3 along = ray_.direction / length_;
    const dvec3 u = glm::normalize(glm::cross(along, std::fabs(along.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
    const dvec3 v = glm::cross(along, u);
    const dvec3 inwards = item.inside - ray_.origin, across = inwards - glm::dot(inwards, along) * along;
    Neighbours beside;
    const auto displace = [&](const dvec3& by) {
      beside.push_back(item.reference->crossings(in_item_frame(item.frame, {ray_.origin + by, ray_.direction})));
    };
    for (int i = 0; i < kSteps; ++i) {
      const double by = shift * std::pow(0.25, i);
      for (int j = 0; j < 16; ++j) {
        const double angle = std::numbers::pi / 8.0 * j;
        displace(by * (std::cos(angle) * u + std::sin(angle) * v));
      }
      if (glm::length(across) > by) displace(by * glm::normalize(across));  // finds apexes of any sharpness
    }
    graze_ = true;
    // What is thinner than the bound, such as an apex that alone is left of a solid, is met or not.
    const auto bound = [&](const Hit& hit) {
      return shift / length_ / std::max(1e-4, std::fabs(glm::dot(hit.normal, along)));
    };
    const bool slivers =
        base.empty() && found_.size() == 2 && found_[1].t - found_[0].t <= bound(found_[0]) + bound(found_[1]);
    if (slivers) {
      expected_.push_back({item.slot, core::kNone, found_[0].t, found_[1].t, false});
      return;
    }
    if (!near_tie(base, beside)) return judge_each(item, base, beside, shift / length_);
    beside.push_back(base);
    double low = kInfinity, high = -kInfinity;
    for (const std::vector<Crossing>& there : beside)
      for (const Crossing& c : there) low = std::min(low, double(c.t)), high = std::max(high, double(c.t));
    // Between two steps the ray may get as much farther as they differ.
    const double room = 3.0 * (high - low) + shift / length_;
    low -= room;
    high += room;
    expected_.push_back({item.slot, core::kNone, low, high, false});
    for (const Hit& hit : found_)
      if (!(hit.t >= low && hit.t <= high)) fail(name(item) + " is grazed at " + digits(hit.t));
  }

  /// All displaced rays meet the same faces, but some so flatly that t moves far.
  void judge_each(const Item& item, const std::vector<Crossing>& base, const Neighbours& beside, double step) {
    for (std::size_t i = 0; i < base.size(); ++i) {
      Expected expected{item.slot, core::kNone, double(base[i].t), double(base[i].t), true};
      for (const std::vector<Crossing>& there : beside) {
        expected.low = std::min(expected.low, double(there[i].t));
        expected.high = std::max(expected.high, double(there[i].t));
      }
      expected.low -= step;
      expected.high += step;
      expected_.push_back(expected);
      if (i < found_.size() && !(found_[i].t >= expected.low && found_[i].t <= expected.high))
        fail(name(item) + " is crossed at " + digits(found_[i].t) + ", not from " + digits(expected.low) + " to " +
             digits(expected.high) + "; " + described(item));
      if (i < found_.size() && !same_face(item, found_[i], base[i]))
        fail(name(item) + " shows its " + std::string(raytrace::name_of(found_[i].face)) + "; " + described(item));
    }
    if (found_.size() != base.size())
      fail(name(item) + " is crossed " + std::to_string(found_.size()) + " times, not " + std::to_string(base.size()) +
           "; " + described(item));
  }

  // --- meshes ---

  /// A triangle as the ray sees it: across the ray in the mesh's units, along it in t.
  struct Seen {
    Quad x[3], y[3], t[3];
  };

  void judge_mesh(const Item& item, const QuadRay& local) {
    const QuadVec& d = local.direction;
    const Quad square = dot(d, d), size_of_d = sqrtq(square);
    const QuadVec side = cross(d, fabsq(d.x) < size_of_d / 2 ? QuadVec(1, 0, 0) : QuadVec(0, 1, 0));
    const QuadVec u = (1 / sqrtq(dot(side, side))) * side, v = (1 / size_of_d) * cross(u, d);
    const double lost = raytrace::kSolidError * size(item) * per_metre(item);
    const double shift = raytrace::kMeshError * item.mesh_size + lost;
    const dvec3 near_o = to_double(local.origin), near_d = to_double((1 / size_of_d) * d);
    std::size_t matched = 0;
    for (std::uint32_t i = 0; i < item.mesh->indices.size() / 3; ++i) {
      dvec3 corner[3];
      for (std::uint32_t c = 0; c < 3; ++c) corner[c] = dvec3(item.mesh->positions[item.mesh->indices[3 * i + c]]);
      // Far beside the line: see judge_item().
      const dvec3 to = corner[0] - near_o;
      const double beside = glm::length(to - glm::dot(to, near_d) * near_d);
      const double reach = std::max(glm::length(corner[1] - corner[0]), glm::length(corner[2] - corner[0]));
      if (beside > 1.001 * reach + 2.0 * shift + 1e-12 * glm::length(to)) continue;
      Seen seen;
      for (int c = 0; c < 3; ++c) {
        const QuadVec at = QuadVec(corner[c]) - local.origin;
        seen.x[c] = dot(u, at);
        seen.y[c] = dot(v, at);
        seen.t[c] = dot(d, at) / square;
      }
      if (const auto expected = judge_triangle(item, seen, i, shift, lost, double(size_of_d))) {
        matched += match(item, *expected);
        expected_.push_back(*expected);
      }
    }
    if (matched != found_.size())
      fail(name(item) + ": " + std::to_string(found_.size() - matched) + " hits of triangles that the ray passes");
    if (item.closed && found_.size() % 2 != 0) fail(name(item) + " is closed and crossed an odd number of times");
  }

  /// Nothing where the ray passes the triangle.
  std::optional<Expected> judge_triangle(const Item& item, const Seen& s, std::uint32_t triangle, double shift,
                                         double lost, double unit) const {
    Quad area[3], most = 0, edge[3];
    double gap = kInfinity;  // to the nearest edge, above 0 inside
    for (int i = 0; i < 3; ++i) {
      const int a = (i + 1) % 3, b = (i + 2) % 3;
      area[i] = s.x[a] * s.y[b] - s.y[a] * s.x[b];
      edge[i] = hypotq(s.x[b] - s.x[a], s.y[b] - s.y[a]);
      most = std::max(most, edge[i]);
    }
    const Quad sum = area[0] + area[1] + area[2], sign = sum < 0 ? -1 : 1;
    const bool inside = sum != 0 && sign * area[0] >= 0 && sign * area[1] >= 0 && sign * area[2] >= 0;
    const double low = double(std::min({s.t[0], s.t[1], s.t[2]})), high = double(std::max({s.t[0], s.t[1], s.t[2]}));
    Quad at = 0;  // t where the ray passes, or where the triangle is nearest to it
    if (inside) {
      at = (area[0] * s.t[0] + area[1] * s.t[1] + area[2] * s.t[2]) / sum;
      for (int i = 0; i < 3; ++i) gap = std::min(gap, double(sign * area[i] / edge[i]));
    } else {
      gap = -kInfinity;
      for (int i = 0; i < 3; ++i) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        const Quad ex = s.x[b] - s.x[a], ey = s.y[b] - s.y[a], square = ex * ex + ey * ey;
        Quad part = square > 0 ? -(s.x[a] * ex + s.y[a] * ey) / square : Quad(0);
        part = std::min(Quad(1), std::max(Quad(0), part));
        const double away = double(hypotq(s.x[a] + part * ex, s.y[a] + part * ey));
        if (-away > gap) gap = -away, at = s.t[a] + part * (s.t[b] - s.t[a]);
      }
      if (gap < -shift) return std::nullopt;
    }
    // How far t moves for a step across the ray: at most from one end of the triangle to the other.
    const double thickness = most > 0 ? double(fabsq(sum) / most) : 0.0;
    Expected expected{item.slot, triangle, low, high, gap > shift};
    const double rounding = (lost + (expected.sure ? 0.0 : shift)) / unit;
    if (thickness > shift) {
      const double slope = slope_of(s, sum);
      const double step = expected.sure ? lost : 2.0 * shift;
      expected.low = std::max(low, double(at) - slope * step);
      expected.high = std::min(high, double(at) + slope * step);
    }
    expected.low -= rounding + 1e-15 * std::fabs(expected.low);
    expected.high += rounding + 1e-15 * std::fabs(expected.high);
    return expected;
  }

  /// Of t over the triangle's plane, per unit across the ray.
  static double slope_of(const Seen& s, Quad sum) {
    Quad x = 0, y = 0;
    for (int i = 0; i < 3; ++i) {
      const int a = (i + 1) % 3, b = (i + 2) % 3;
      x += s.t[i] * (s.y[a] - s.y[b]);
      y += s.t[i] * (s.x[b] - s.x[a]);
    }
    return double(hypotq(x, y) / fabsq(sum));
  }

  /// Whether all() has reported the triangle, once, and where it is.
  bool match(const Item& item, const Expected& expected) {
    const Hit* found = nullptr;
    for (const Hit& hit : found_) {
      if (hit.triangle != expected.triangle) continue;
      if (found) fail(name(item) + " is hit twice in triangle " + std::to_string(hit.triangle));
      found = &hit;
    }
    if (!expected.sure) graze_ = true;
    if (!found) {
      if (expected.sure) fail(name(item) + " is not hit in triangle " + std::to_string(expected.triangle));
      return false;
    }
    if (!(found->t >= expected.low && found->t <= expected.high))
      fail(name(item) + " is hit at " + digits(found->t) + " in triangle " + std::to_string(found->triangle) +
           ", not from " + digits(expected.low) + " to " + digits(expected.high));
    return true;
  }

  // --- the nearest ---

  void judge_nearest(const std::optional<ManyAnswer>& of_many) {
    const auto hit = world_.tracer->nearest(ray_);
    const auto any = world_.tracer->any(ray_);
    if (!hit || !any || !of_many) return fail("nearest() refused the ray");
    judge_answers("", *hit ? &**hit : nullptr, *any);
    figures_.hits += hit->has_value();
    judge_answers(" of many", of_many->hit.slot == core::kNone ? nullptr : &of_many->hit, of_many->any);
  }

  void judge_answers(const std::string& how, const Hit* hit, bool any) {
    // The first that is surely there ends by this t. Near the ray's ends nothing is sure.
    double last = kInfinity, first = kInfinity;
    const Expected* nearest = nullptr;
    for (const Expected& e : expected_) {
      if (e.high < ray_.t_min || e.low > ray_.t_max) continue;
      first = std::min(first, e.low);
      if (!e.sure || e.low < ray_.t_min || e.high > ray_.t_max) continue;
      if (!nearest || e.low + e.high < nearest->low + nearest->high) nearest = &e;
      last = std::min(last, e.high + mesh_slack(e.slot));
    }
    if (last < kInfinity && !any) fail("any()" + how + " finds nothing");
    if (first == kInfinity && any) fail("any()" + how + " finds what is not there");
    if (!hit) {
      if (last < kInfinity) fail("nearest()" + how + " finds nothing");
      return;
    }
    double width = -1.0;
    for (const Expected& e : expected_)
      if (e.slot == hit->slot && e.triangle == hit->triangle && hit->t >= e.low && hit->t <= e.high)
        width = std::max(width, e.high - e.low);
    const std::string found = "nearest()" + how + " finds slot " + std::to_string(hit->slot) + " at " + digits(hit->t);
    if (width < 0.0 || !(hit->t >= ray_.t_min && hit->t <= ray_.t_max)) return fail(found);
    if (hit->t - width - mesh_slack(hit->slot) > last) return fail(found + " behind what ends at " + digits(last));
    if (how.empty() && nearest && nearest->slot != hit->slot && hit->t >= nearest->low) ++figures_.ties;
  }

  /// Along the ray meshes are known to kMeshError, too.
  double mesh_slack(Slot slot) const {
    const auto item =
        std::find_if(world_.items.begin(), world_.items.end(), [&](const Item& i) { return i.slot == slot; });
    if (!item->mesh) return 0.0;
    return raytrace::kMeshError * item->mesh_size / glm::length(item->item_from_world * ray_.direction);
  }

  const World& world_;
  std::string place_;
  TracedFigures& figures_;
  Ray ray_;
  double length_ = 1.0;
  bool wrong_ = false, graze_ = false;
  std::vector<Hit> all_, found_;
  std::vector<Expected> expected_;
};

/// Traces the rays each by itself and all together.
void judge_rays(const World& world, const std::string& place, const std::vector<Ray>& rays, TracedFigures& figures) {
  std::vector<Hit> hits(rays.size());
  const auto any = std::make_unique<bool[]>(rays.size());
  const bool traced = world.tracer->nearest(rays, hits) && world.tracer->any(rays, {any.get(), rays.size()});
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Judge judge(world, place + ", ray " + std::to_string(i), figures);
    judge.add(rays[i], traced ? std::optional(ManyAnswer{hits[i], any[i]}) : std::nullopt);
  }
}

}  // namespace

void TracedFigures::add(const TracedFigures& other) {
  rays += other.rays;
  scenes += other.scenes;
  hits += other.hits;
  crossings += other.crossings;
  ties += other.ties;
  grazes += other.grazes;
  wrong += other.wrong;
  worst = std::max(worst, other.worst);
  for (const std::string& example : other.examples)
    if (examples.size() < 10) examples.push_back(example);
}

TracedFigures trace_rays(TracedKind kind, std::int64_t rays, std::uint64_t seed) {
  TracedFigures figures;
  Random seeds(seed);
  while (figures.rays < rays) {
    Random random(seeds.bits());
    const auto world = make_world(kind, random);
    if (!world || world->items.empty()) continue;
    const std::string place = "seed " + std::to_string(seed) + ", scene " + std::to_string(figures.scenes);
    ++figures.scenes;
    judge_rays(*world, place, rays_at(*world, std::min<std::int64_t>(kRaysPerScene, rays - figures.rays), random),
               figures);
  }
  return figures;
}

}  // namespace sightline::bench
