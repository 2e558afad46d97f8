#include "sightline/analysis/measure/snap.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "sightline/analysis/measure/internal/closest.h"
#include "sightline/analysis/measure/internal/item_data.h"
#include "sightline/core/internal/section_rounding.h"

namespace sightline::measure {
namespace {

constexpr double kGrazing = 4.0;  // a slanted surface looks shorter: how much farther edges are sought

/// Parameters of a segment (0 to 1) or an arc (radians).
struct Interval {
  double from, to;
};
using Intervals = std::vector<Interval>;

/// The part of features that section planes keep, also where it lies in a plane up to the rounding of items, which are
/// drawn there.
class Sections {
 public:
  /// `origin`: the item's.
  Sections(std::span<const core::Plane> planes, core::SectionMode mode, const dvec3& origin)
      : mode_(mode), origin_(origin) {
    for (const core::Plane& plane : planes)
      if (plane.normal != dvec3(0.0)) planes_.push_back(core::normalised(plane));
  }

  bool keep(const dvec3& p) const {
    const auto on_kept_side = [&](const core::Plane& plane) { return value(plane, p) >= 0.0; };
    return planes_.empty() ||
           (mode_ == core::SectionMode::kIntersection ? std::all_of(planes_.begin(), planes_.end(), on_kept_side)
                                                      : std::any_of(planes_.begin(), planes_.end(), on_kept_side));
  }
  /// The nearest kept point, if it is that near: what is picked on a plane lies beside it by rounding.
  std::optional<dvec3> kept(const dvec3& p, double most) const {
    if (keep(p)) return p;
    dvec3 moved = p;
    if (mode_ == core::SectionMode::kIntersection) {
      for (const core::Plane& plane : planes_) moved -= std::min(0.0, core::evaluate(plane, moved)) * plane.normal;
    } else {
      const auto& nearest = *std::max_element(planes_.begin(), planes_.end(), [&](const auto& a, const auto& b) {
        return core::evaluate(a, p) < core::evaluate(b, p);
      });
      moved -= core::evaluate(nearest, p) * nearest.normal;
    }
    return keep(moved) && glm::length(moved - p) <= most ? std::optional(moved) : std::nullopt;
  }
  Intervals kept(const Segment& s) const {
    return kept_of({0.0, 1.0}, [&](const core::Plane& plane) {
      return kept(plane, s, value(plane, s.from) >= 0.0, value(plane, s.to) >= 0.0);
    });
  }
  /// Without the rounding of items.
  Intervals kept_of_sight(const Segment& s) const {
    return kept_of({0.0, 1.0}, [&](const core::Plane& plane) {
      return kept(plane, s, core::evaluate(plane, s.from) >= 0.0, core::evaluate(plane, s.to) >= 0.0);
    });
  }
  Intervals kept(const Arc& arc) const {
    return kept_of({arc.from, arc.to}, [&](const core::Plane& plane) -> Intervals {
      // centre + reach cos(t - middle) >= 0
      const double centre = value(plane, arc.centre);
      const double u = glm::dot(plane.normal, arc.u), v = glm::dot(plane.normal, arc.v), reach = std::hypot(u, v);
      if (centre >= reach) return {{arc.from, arc.to}};
      if (centre < -reach) return {};
      const double middle = std::atan2(v, u), half = std::acos(std::clamp(-centre / reach, -1.0, 1.0));
      Intervals parts;
      for (double turn = core::kFullTurn * std::floor((arc.from - middle - half) / core::kFullTurn);
           middle + turn - half <= arc.to; turn += core::kFullTurn) {
        const Interval part{std::max(arc.from, middle + turn - half), std::min(arc.to, middle + turn + half)};
        if (part.from <= part.to) parts.push_back(part);
      }
      return parts;
    });
  }

 private:
  /// `of_plane` gives the intervals that one plane keeps. In a union intervals may overlap.
  template <class OfPlane>
  Intervals kept_of(const Interval& whole, const OfPlane& of_plane) const {
    if (planes_.empty()) return {whole};
    Intervals all;
    if (mode_ == core::SectionMode::kIntersection) all.push_back(whole);
    for (const core::Plane& plane : planes_) {
      const Intervals parts = of_plane(plane);
      if (mode_ == core::SectionMode::kUnion) {
        all.insert(all.end(), parts.begin(), parts.end());
        continue;
      }
      Intervals both;
      for (const Interval& a : all)
        for (const Interval& b : parts)
          if (std::max(a.from, b.from) <= std::min(a.to, b.to))
            both.push_back({std::max(a.from, b.from), std::min(a.to, b.to)});
      all = std::move(both);
    }
    return all;
  }

  double value(const core::Plane& plane, const dvec3& p) const {
    constexpr double kChunk = 16.0;  // metres: items lie so far from the origin that their floats count from
    return core::evaluate(plane, p) + core::section_margin(plane, kChunk + glm::abs(p - origin_), glm::abs(p));
  }
  /// The kept part of a segment whose ends are kept or not: it is cut in the plane itself.
  static Intervals kept(const core::Plane& plane, const Segment& s, bool from, bool to) {
    if (!from && !to) return {};
    const double at_from = core::evaluate(plane, s.from), at_to = core::evaluate(plane, s.to);
    const double cut = from != to ? std::clamp(at_from / (at_from - at_to), 0.0, 1.0) : 0.0;
    return {{from ? 0.0 : cut, to ? 1.0 : cut}};
  }

  core::SectionMode mode_;
  dvec3 origin_;
  std::vector<core::Plane> planes_;  ///< with unit normals
};

Segment part_of(const Segment& s, const Interval& i) {
  const dvec3 along = s.to - s.from;
  return {i.from > 0.0 ? s.from + i.from * along : s.from, i.to < 1.0 ? s.from + i.to * along : s.to};
}
Arc part_of(Arc arc, const Interval& i) {
  arc.from = i.from, arc.to = i.to;
  return arc;
}

class Snapper {
 public:
  Snapper(const Item& item, const Aim& aim, const Sections& sections) : item_(item), aim_(aim), sections_(sections) {}

  struct Found {
    Feature feature;
    dvec3 at;
    std::size_t index;  ///< of the feature; their number for a point of the surface that belongs to none
  };
  std::optional<Found> first_of(std::span<const Feature> features) const {
    for (const FeatureKind kind :
         {FeatureKind::kCorner, FeatureKind::kEdge, FeatureKind::kCentre, FeatureKind::kAxis, FeatureKind::kFace})
      if (auto found = best_of(kind, features)) return found;
    const auto point = surface_point();
    if (!point) return std::nullopt;
    return Found{{FeatureKind::kSurface, item_.kind(), "", *point}, *point, features.size()};
  }

  /// How far a feature may lie off the aim at the aim's point.
  double reach() const { return reach_at(aim_.point); }

 private:
  static bool is_inner(const Feature& f) { return f.kind == FeatureKind::kCentre || f.kind == FeatureKind::kAxis; }
  double depth(const dvec3& p) const { return glm::dot(p - aim_.ray->origin, aim_.ray->direction); }
  double reach_at(const dvec3& p) const {
    return aim_.radius + (aim_.ray ? aim_.ray->slope * std::max(0.0, depth(p)) : 0.0);
  }
  double off_aim(const dvec3& p) const {
    if (!aim_.ray) return glm::length(p - aim_.point);
    const dvec3 from_origin = p - aim_.ray->origin;
    return glm::length(from_origin - aim_.ray->direction * glm::dot(from_origin, aim_.ray->direction));
  }
  bool within_reach(const dvec3& p) const { return (!aim_.ray || depth(p) >= 0.0) && off_aim(p) <= reach_at(p); }

  /// What the nearest point is near to: the ray for inner features, the aim's point for others.
  Geometry target(const Feature& feature) const {
    if (aim_.ray && is_inner(feature)) return Line{aim_.ray->origin, aim_.ray->direction};
    return aim_.point;
  }
  /// Only points within reach matter. Of equally near ones, such as those of a rim about its centre, any will do.
  SearchLimits limits(const Feature& feature) const {
    const bool along_ray = aim_.ray && is_inner(feature);  // the reach grows with the depth there
    return {along_ray ? std::numeric_limits<double>::infinity() : kGrazing * reach(), 1e-6 * reach()};
  }
  template <class Curve>
  std::optional<dvec3> nearest_kept(const Feature& feature, const Curve& curve) const {
    std::optional<dvec3> best;
    double least = std::numeric_limits<double>::infinity();
    const SearchLimits search = limits(feature);
    for (const Interval& interval : sections_.kept(curve)) {
      const Distance found = limited_distance(part_of(curve, interval), target(feature), search);
      if (found.distance < least && found.distance <= search.farthest) least = found.distance, best = found.from;
    }
    return best;
  }
  std::optional<dvec3> nearest(const Feature& feature, const dvec3& p) const {
    return sections_.kept(p, feature.kind == FeatureKind::kSurface ? reach() : 0.0);
  }
  std::optional<dvec3> nearest(const Feature& feature, const Segment& s) const { return nearest_kept(feature, s); }
  std::optional<dvec3> nearest(const Feature& feature, const Arc& a) const { return nearest_kept(feature, a); }
  std::optional<dvec3> nearest(const Feature&, const Line&) const { return std::nullopt; }
  std::optional<dvec3> nearest(const Feature& feature, const Face& face) const {
    return nearest(feature, distance(face, aim_.point).from);
  }

  /// The nearest feature of a kind. Surfaces are as good as faces.
  std::optional<Found> best_of(FeatureKind kind, std::span<const Feature> features) const {
    constexpr double kSame = 1e-6;  // an edge has two sides, whose points differ by rounding: the first side counts
    std::optional<Found> best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < features.size(); ++i) {
      const Feature& feature = features[i];
      if (std::min(feature.kind, FeatureKind::kFace) != kind) continue;
      const auto point = std::visit([&](const auto& g) { return nearest(feature, g); }, feature.geometry);
      if (!point || !within_reach(*point)) continue;
      const double off = is_inner(feature) ? off_aim(*point) : glm::length(*point - aim_.point);
      if (off >= least - kSame * reach() || !is_visible(feature, *point)) continue;
      least = off, best = {feature, *point, i};
    }
    return best;
  }

  /// The point of the item's surface that is aimed at. On the cap of a section it lies within the item.
  std::optional<dvec3> surface_point() const {
    const Distance gap = distance(aim_.point, item_);
    const bool is_mesh = item_.data().shape.form == Shape::Form::kTriangles;
    const dvec3 on = gap.touching && (!is_mesh || !within_reach(gap.to)) ? aim_.point : gap.to;
    if (std::isinf(gap.distance)) return std::nullopt;  // of a mesh without triangles
    const auto point = sections_.kept(on, reach());
    return point && within_reach(*point) ? point : std::nullopt;
  }

  /// Whether the kept part of the item leaves the way from the eye to the point free.
  bool is_visible(const Feature& feature, const dvec3& point) const {
    constexpr double kShort = 1e-6;  // of the way: it must not end on the surface
    if (!aim_.ray || feature.kind > FeatureKind::kEdge) return true;
    const AimRay& ray = *aim_.ray;
    const dvec3 eye = ray.slope > 0.0 ? ray.origin : point - ray.direction * depth(point);
    const Segment way{eye, point - kShort * (point - eye)};
    for (const Interval& interval : sections_.kept_of_sight(way))
      if (distance(part_of(way, interval), item_).touching) return false;
    return true;
  }

  const Item& item_;
  const Aim& aim_;
  const Sections& sections_;
};

/// Features of a mesh near a point, those of curved faces first: of an edge's two sides they say more.
class NearTriangles {
 public:
  NearTriangles(const Item::Data& data, const dvec3& point, double reach)
      : data_(data), point_(point - data.shape.origin), reach_(reach) {
    if (!data.shape.nodes.empty()) visit(0);
    for (const std::uint32_t face : std::set(of_triangles_.begin(), of_triangles_.end()))
      if (face != core::kNone)
        for (const Feature& feature : data.faces.faces[face].features) add(face, feature);
    std::stable_partition(near_.begin(), near_.end(), [&](const Near& n) { return is_curved(n.face); });
    for (Near& near : near_) features.push_back(std::move(near.feature)), faces.push_back(near.face);
  }
  std::vector<Feature> features;
  std::vector<std::uint32_t> faces;  ///< of these: kNone for those of no face that the file states

 private:
  struct Near {
    Feature feature;
    std::uint32_t face;
  };

  void visit(std::uint32_t index) {
    const TriangleNode& node = data_.shape.nodes[index];
    const dvec3 outside = glm::max(glm::max(node.box.min - point_, point_ - node.box.max), dvec3(0.0));
    if (glm::length(outside) > reach_) return;
    if (node.second == 0) return add_triangle(node.begin);
    visit(index + 1);
    visit(node.second);
  }
  bool is_curved(std::uint32_t face) const {
    return face != core::kNone && data_.faces.faces[face].surface.kind != core::MeshSurface::Kind::kPlane;
  }
  void add_triangle(std::uint32_t triangle) {
    const TriangleFeatures& sharp = data_.triangles[triangle];
    const std::uint32_t face = data_.faces.of_triangle.empty() ? core::kNone : data_.faces.of_triangle[triangle];
    of_triangles_.push_back(face);
    const std::string_view part = is_curved(face) ? face_words(data_.faces.faces[face].surface.kind) : "";
    dvec3 corners[3];
    for (int i = 0; i < 3; ++i) corners[i] = data_.shape.origin + data_.shape.points[3 * std::size_t(triangle) + i];
    for (int i = 0; i < 3; ++i) {
      if (sharp.corners[i]) add(face, {FeatureKind::kCorner, data_.kind, "", corners[i]});
      if (sharp.edges[i]) add(face, {FeatureKind::kEdge, data_.kind, part, Segment{corners[i], corners[(i + 1) % 3]}});
    }
    const dvec3 n = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double size = glm::length(n);
    Face flat{(corners[0] + corners[1] + corners[2]) / 3.0, size > 0.0 ? n / size : dvec3(0.0), {corners, corners + 3}};
    if (face == core::kNone) return add(face, {FeatureKind::kFace, data_.kind, part, std::move(flat)});
    const core::MeshSurface& surface = data_.faces.faces[face].surface;
    if (surface.kind == core::MeshSurface::Kind::kPlane) {
      flat.normal = glm::dot(surface.axis, flat.normal) < 0.0 ? -surface.axis : surface.axis;
      return add(face, {FeatureKind::kFace, data_.kind, part, std::move(flat)});
    }
    const dvec3 on = distance(flat, data_.shape.origin + point_).from;
    add(face, {FeatureKind::kSurface, data_.kind, part, core::nearest_point(surface, on)});
  }
  void add(std::uint32_t face, Feature feature) { near_.push_back({std::move(feature), face}); }

  const Item::Data& data_;
  dvec3 point_;
  double reach_;
  std::vector<std::uint32_t> of_triangles_;
  std::vector<Near> near_;
};

std::optional<Segment> straight_axis(std::span<const Feature> features) {
  for (const Feature& feature : features)
    if (const auto* axis = std::get_if<Segment>(&feature.geometry); axis && feature.kind == FeatureKind::kAxis)
      return *axis;
  return std::nullopt;
}

}  // namespace

std::optional<Snap> snap(const Item& item, const Aim& aim, std::span<const core::Plane> planes,
                         core::SectionMode mode) {
  const Sections sections(planes, mode, item.data().shape.origin);
  const Snapper snapper(item, aim, sections);
  const Item::Data& data = item.data();
  if (data.shape.form != Shape::Form::kTriangles) {
    auto found = snapper.first_of(item.features());
    if (!found) return std::nullopt;
    return Snap{found->feature, found->at, describe(found->feature), data.dimensions, straight_axis(item.features())};
  }
  const NearTriangles near(data, aim.point, (aim.ray ? kGrazing : 1.0) * snapper.reach());
  auto found = snapper.first_of(near.features);
  if (!found) return std::nullopt;
  Snap made{found->feature, found->at, describe(found->feature)};
  if (found->index < near.faces.size() && near.faces[found->index] != core::kNone) {
    const MeshFace& face = data.faces.faces[near.faces[found->index]];
    made.dimensions = face.dimensions, made.axis = straight_axis(face.features);
  }
  return made;
}

}  // namespace sightline::measure
