#include "sightline/apps/bench/stability/traced_rays.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>

#include "sightline/apps/bench/stability/traced_scenes.h"

namespace sightline::bench {
namespace {

using core::dmat3;
using core::dvec3;
using core::Primitive;
using core::Ray;
using core::Slot;
using raytrace::Hit;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kRaysPerScene = 1000;

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

class AnswerJudge {
 public:
  AnswerJudge(const TracedScene& world, std::string place, TracedCounts& counts)
      : world_(world), place_(std::move(place)), counts_(counts) {}

  /// `of_many`: nothing if they were refused.
  void add(const Ray& ray, const std::optional<ManyAnswer>& of_many) {
    ++counts_.rays;
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
    counts_.grazes += graze_;
    counts_.wrong += wrong_;
  }

 private:
  void fail(const std::string& what) {
    wrong_ = true;
    if (counts_.examples.size() >= 10) return;
    char text[400];
    std::snprintf(text, sizeof(text),
                  "%s: %s; from (%.17g %.17g %.17g) along (%.17g %.17g %.17g), t from %.17g to %.17g", place_.c_str(),
                  what.c_str(), ray_.origin.x, ray_.origin.y, ray_.origin.z, ray_.direction.x, ray_.direction.y,
                  ray_.direction.z, ray_.t_min, ray_.t_max);
    counts_.examples.emplace_back(text);
  }
  std::string name(const TracedItem& item) const {
    return std::string(core::name_of(world_.snapshot->kind(item.slot))) + " in slot " + std::to_string(item.slot);
  }
  static std::string described(const TracedItem& item) {
    std::string text = "parameters";
    for (const float v : core::parameters(*item.solid)) text += " " + digits(v);
    return text;
  }
  /// The coordinates involved, in metres.
  double size(const TracedItem& item) const {
    return glm::length(ray_.origin) + glm::length(item.frame.origin) + item.diagonal;
  }

  /// Whether the line comes near the item's box, in its frame. The margin is far above double's rounding.
  bool comes_near(const TracedItem& item) const {
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
  static double per_metre(const TracedItem& item) {
    const dmat3& inverse = item.item_from_world;
    return std::sqrt(glm::dot(inverse[0], inverse[0]) + glm::dot(inverse[1], inverse[1]) +
                     glm::dot(inverse[2], inverse[2]));
  }

  void judge_all() {
    counts_.crossings += std::int64_t(all_.size());
    for (const TracedItem& item : world_.items) {
      found_.clear();
      for (const Hit& hit : all_)
        if (hit.slot == item.slot) found_.push_back(hit);
      judge_item(item);
    }
  }

  void judge_item(const TracedItem& item) {
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

  double sine(const TracedItem& item, const dvec3& local_normal) const {
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
  static bool same_face(const TracedItem& item, const Hit& hit, const Crossing& crossing) {
    if (has_apex(*item.solid)) return true;
    switch (hit.face) {
      case core::Face::kBottom:
      case core::Face::kBottomLevel:
      case core::Face::kBelow:
        return crossing.face == kBottom;
      case core::Face::kTop:
      case core::Face::kTopLevel:
      case core::Face::kAbove:
        return crossing.face == kTop;
      default:
        return crossing.face == kSide;
    }
  }

  void judge_solid(const TracedItem& item, const QuadRay& local) {
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
      counts_.worst = std::max(counts_.worst, worst);
      return;
    }
    expected_.resize(expected_.size() - base.size());
    judge_graze(item, base, shift);
  }

  /// Unit vectors across the ray. Evenly spread ones alone miss what is narrow: the few ways into a solid whose
  /// placement is nearly flat, which are spread evenly in its frame; and the two ways along a surface that the ray
  /// grazes where it touches another one.
  std::vector<dvec3> ways_aside(const TracedItem& item, const std::vector<Crossing>& base) const {
    std::vector<dvec3> ways;
    const dvec3 along = ray_.direction / length_;
    const auto add = [&](const dvec3& way) {
      const dvec3 across = way - glm::dot(way, along) * along;
      if (const double size = glm::length(across); size > 0.0) ways.push_back(across / size);
    };
    const auto add_circle = [&](const dvec3& axis, const dmat3& to_world) {
      const dvec3 u = glm::normalize(glm::cross(axis, std::fabs(axis.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
      const dvec3 v = glm::cross(axis, u);
      for (int j = 0; j < 16; ++j) {
        const double angle = std::numbers::pi / 8.0 * j;
        add(to_world * (std::cos(angle) * u + std::sin(angle) * v));
      }
    };
    const auto add_along_surface = [&](const dvec3& normal) {
      for (const double sign : {1.0, -1.0}) add(sign * glm::cross(along, normal));
    };
    add_circle(along, dmat3(1.0));
    add_circle(glm::normalize(item.item_from_world * along), item.frame.linear);
    for (const Crossing& c : base) add_along_surface(glm::transpose(item.item_from_world) * c.normal);
    for (const Hit& hit : found_) add_along_surface(hit.normal);
    return ways;
  }

  /// Rays displaced by no more than the bound have other crossings, and so may this. The steps go down to about
  /// double's rounding, since solids may be as thin.
  static constexpr int kSteps = 9;
  void judge_graze(const TracedItem& item, const std::vector<Crossing>& base, double shift) {
    const dvec3 along = ray_.direction / length_;
    const dvec3 inwards = item.inside - ray_.origin, across = inwards - glm::dot(inwards, along) * along;
    const std::vector<dvec3> ways = ways_aside(item, base);
    Neighbours beside;
    const auto displace = [&](const dvec3& by) {
      beside.push_back(item.reference->crossings(in_item_frame(item.frame, {ray_.origin + by, ray_.direction})));
    };
    for (int i = 0; i < kSteps; ++i) {
      const double by = shift * std::pow(0.25, i);
      for (const dvec3& way : ways) displace(by * way);
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
  void judge_each(const TracedItem& item, const std::vector<Crossing>& base, const Neighbours& beside, double step) {
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
        fail(name(item) + " shows its " + std::string(core::name_of(found_[i].face)) + "; " + described(item));
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

  void judge_mesh(const TracedItem& item, const QuadRay& local) {
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
  std::optional<Expected> judge_triangle(const TracedItem& item, const Seen& s, std::uint32_t triangle, double shift,
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

  /// The slope of t over the triangle's plane, per unit across the ray.
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
  bool match(const TracedItem& item, const Expected& expected) {
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
    counts_.hits += hit->has_value();
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
    if (how.empty() && nearest && nearest->slot != hit->slot && hit->t >= nearest->low) ++counts_.ties;
  }

  /// Along the ray meshes are known to kMeshError, too.
  double mesh_slack(Slot slot) const {
    const auto item =
        std::find_if(world_.items.begin(), world_.items.end(), [&](const TracedItem& i) { return i.slot == slot; });
    if (!item->mesh) return 0.0;
    return raytrace::kMeshError * item->mesh_size / glm::length(item->item_from_world * ray_.direction);
  }

  const TracedScene& world_;
  std::string place_;
  TracedCounts& counts_;
  Ray ray_;
  double length_ = 1.0;
  bool wrong_ = false, graze_ = false;
  std::vector<Hit> all_, found_;
  std::vector<Expected> expected_;
};

/// Traces the rays each by itself and all together.
void judge_rays(const TracedScene& world, const std::string& place, const std::vector<Ray>& rays,
                TracedCounts& counts) {
  std::vector<Hit> hits(rays.size());
  const auto any = std::make_unique<bool[]>(rays.size());
  const bool traced = world.tracer->nearest(rays, hits) && world.tracer->any(rays, {any.get(), rays.size()});
  for (std::size_t i = 0; i < rays.size(); ++i) {
    AnswerJudge judge(world, place + ", ray " + std::to_string(i), counts);
    judge.add(rays[i], traced ? std::optional(ManyAnswer{hits[i], any[i]}) : std::nullopt);
  }
}

}  // namespace

void TracedCounts::add(const TracedCounts& other) {
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

TracedCounts trace_rays(TracedKind kind, std::int64_t rays, std::uint64_t seed) {
  TracedCounts counts;
  Random seeds(seed);
  while (counts.rays < rays) {
    Random random(seeds.bits());
    const auto world = make_traced_scene(kind, random);
    if (!world || world->items.empty()) continue;
    const std::string place = "seed " + std::to_string(seed) + ", scene " + std::to_string(counts.scenes);
    ++counts.scenes;
    judge_rays(*world, place, rays_at(*world, std::min<std::int64_t>(kRaysPerScene, rays - counts.rays), random),
               counts);
  }
  return counts;
}

}  // namespace sightline::bench
