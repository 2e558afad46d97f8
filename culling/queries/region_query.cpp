#include "sightline/culling/queries/region_query.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>

namespace sightline::culling {
namespace {

using core::AabbD;
using core::Affine;
using core::dvec3;
using core::Plane;
using core::Slot;

constexpr double kCoordinateRounding = 1e-12;  // of the coordinates involved

/// A convex part of space, bounded by a box about the scene.
class Region {
 public:
  Region(const std::vector<Plane>& planes, const AabbD& bounds) : all_(planes) {
    for (int axis = 0; axis < 3; ++axis) {
      dvec3 normal(0.0);
      normal[axis] = 1.0;
      all_.push_back({normal, -bounds.min[axis]});
      all_.push_back({-normal, bounds.max[axis]});
    }
    given_ = planes.size();
    for (Plane& plane : all_) {
      const double length = glm::length(plane.normal);
      plane = {plane.normal / length, plane.offset / length};
    }
    reach_ = glm::length(bounds.min) + glm::length(bounds.max);
    find_corners();
    find_edges();
  }

  bool empty() const { return corners_.empty(); }
  double rounding() const { return kCoordinateRounding * reach_; }
  std::span<const Plane> planes() const { return {all_.data(), given_}; }
  std::span<const Plane> faces() const { return all_; }       ///< those and the box's
  const std::vector<dvec3>& edges() const { return edges_; }  ///< directions
  /// Directions from corners and edges to a point.
  template <class Visit>
  bool any_towards(const dvec3& point, const Visit& visit) const {
    for (const Corner& corner : corners_)
      if (visit(point - corner.point)) return true;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const dvec3 from = point - starts_[i];
      if (visit(from - glm::dot(from, edges_[i]) * edges_[i])) return true;
    }
    return false;
  }
  /// The largest dot(direction, p) of the region's points.
  double support(const dvec3& direction) const {
    double most = -std::numeric_limits<double>::infinity();
    for (const Corner& corner : corners_) most = std::max(most, glm::dot(direction, corner.point));
    return most;
  }

 private:
  struct Corner {
    dvec3 point;
    std::uint32_t planes;  // a bit for each
  };

  void find_corners() {
    const std::size_t count = all_.size();
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = a + 1; b < count; ++b)
        for (std::size_t c = b + 1; c < count; ++c) {
          const dvec3 &u = all_[a].normal, &v = all_[b].normal, &w = all_[c].normal, x = glm::cross(v, w);
          const double determinant = glm::dot(u, x);
          if (std::fabs(determinant) < 1e-12) continue;
          const dvec3 p =
              -(all_[a].offset * x + all_[b].offset * glm::cross(w, u) + all_[c].offset * glm::cross(u, v)) /
              determinant;
          const double error = rounding() / std::fabs(determinant);
          if (std::all_of(all_.begin(), all_.end(),
                          [&](const Plane& plane) { return core::evaluate(plane, p) >= -error; }))
            corners_.push_back({p, 1u << a | 1u << b | 1u << c});
        }
  }
  /// Between corners with two planes in common.
  void find_edges() {
    for (std::size_t i = 0; i < corners_.size(); ++i)
      for (std::size_t j = i + 1; j < corners_.size(); ++j) {
        const std::uint32_t common = corners_[i].planes & corners_[j].planes;
        const dvec3 along = corners_[j].point - corners_[i].point;
        const double length = glm::length(along);
        if ((common & (common - 1)) == 0 || !(length > rounding())) continue;
        edges_.push_back(along / length);
        starts_.push_back(corners_[i].point);
      }
  }

  std::vector<Plane> all_;
  std::size_t given_ = 0;
  double reach_ = 0.0;
  std::vector<Corner> corners_;
  std::vector<dvec3> edges_, starts_;
};

/// The largest value of a plane in a box, or of its opposite the least.
double most_in(const AabbD& box, const Plane& plane) {
  double sum = plane.offset;
  for (int axis = 0; axis < 3; ++axis)
    sum += std::max(plane.normal[axis] * box.min[axis], plane.normal[axis] * box.max[axis]);
  return sum;
}
Plane opposite(const Plane& plane) {
  return {-plane.normal, -plane.offset};
}

/// A solid where it stands.
class Solid {
 public:
  Solid(const core::Primitive& primitive, const Affine& placed) : primitive_(primitive), placed_(placed) {}

  double support(const dvec3& direction) const {
    return core::support(primitive_, glm::transpose(placed_.linear) * direction) + glm::dot(direction, placed_.origin);
  }
  const Affine& placed() const { return placed_; }

 private:
  const core::Primitive& primitive_;
  const Affine& placed_;
};

bool inside(const Region& region, const Solid& solid) {
  return std::all_of(region.planes().begin(), region.planes().end(), [&](const Plane& plane) {
    return plane.offset - solid.support(-plane.normal) >= -region.rounding();
  });
}

/// Separating axes: S. Gottschalk, M. Lin, D. Manocha, "OBBTree", 1996.
bool meets(const Region& region, const Solid& solid, const dvec3& middle) {
  const auto separates = [&](const dvec3& direction) {  // the solid lies beyond the region
    const double length = glm::length(direction);
    if (!(length > 0.0)) return false;
    const dvec3 n = direction / length;
    return solid.support(-n) + region.support(n) < -region.rounding();
  };
  for (const Plane& plane : region.faces())
    if (separates(-plane.normal)) return false;
  if (region.any_towards(middle, [&](const dvec3& direction) { return separates(direction) || separates(-direction); }))
    return false;
  const core::dmat3& axes = solid.placed().linear;
  for (int axis = 0; axis < 3; ++axis) {
    const dvec3 normal = glm::cross(axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
    if (separates(normal) || separates(-normal)) return false;
    for (const dvec3& edge : region.edges()) {
      const dvec3 across = glm::cross(axes[axis], edge);
      if (glm::length(across) > 1e-9 * glm::length(axes[axis]) && (separates(across) || separates(-across)))
        return false;
    }
  }
  return true;
}

/// Whether any point of a triangle lies in the region: clipped by one plane after the other (I. Sutherland, G. Hodgman,
/// "Reentrant polygon clipping", 1974).
bool meets(const Region& region, const dvec3 (&corners)[3]) {
  std::vector<dvec3> polygon(corners, corners + 3), clipped;
  for (const Plane& plane : region.planes()) {
    clipped.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const dvec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double value_a = core::evaluate(plane, a), value_b = core::evaluate(plane, b);
      if (value_a >= 0.0) clipped.push_back(a);
      if ((value_a >= 0.0) != (value_b >= 0.0)) clipped.push_back(a + value_a / (value_a - value_b) * (b - a));
    }
    if (clipped.empty()) return false;
    polygon.swap(clipped);
  }
  return true;
}

bool holds_mesh(const Region& region, const core::Mesh& mesh, const Affine& placed, RegionRule rule) {
  const auto point = [&](std::size_t index) {
    return core::transform_point(placed, dvec3(mesh.positions[mesh.indices[index]]));
  };
  const auto in_region = [&](const dvec3& p) {
    return std::all_of(region.planes().begin(), region.planes().end(),
                       [&](const Plane& plane) { return core::evaluate(plane, p) >= -region.rounding(); });
  };
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const dvec3 corners[] = {point(i), point(i + 1), point(i + 2)};
    if (rule == RegionRule::kWholly) {
      if (!in_region(corners[0]) || !in_region(corners[1]) || !in_region(corners[2])) return false;
    } else if (meets(region, corners)) {
      return true;
    }
  }
  return rule == RegionRule::kWholly;
}

bool holds(const Region& region, const core::Snapshot& snapshot, Slot slot, RegionRule rule) {
  const core::ItemBounds& bounds = snapshot.bounds();
  const AabbD box = bounds.in_world(bounds.box(slot));
  bool within = true;
  for (const Plane& plane : region.planes()) {
    if (most_in(box, plane) < -region.rounding()) return false;
    within &= -most_in(box, opposite(plane)) >= 0.0;
  }
  if (within) return true;
  const Affine placed = snapshot.world_from_item(slot);
  if (int(snapshot.kind(slot)) >= core::kPrimitiveKindCount)
    return holds_mesh(region, snapshot.mesh(slot), placed, rule);
  const core::Primitive primitive = snapshot.primitive(slot);
  const Solid solid(primitive, placed);
  return rule == RegionRule::kWholly ? inside(region, solid) : meets(region, solid, box.centre());
}

}  // namespace

core::Expected<core::View> rectangle_view(const core::View& view, int width, int height, double x0, double y0,
                                          double x1, double y1) {
  if (width <= 0 || height <= 0 || !std::isfinite(x0) || !std::isfinite(y0) || !std::isfinite(x1) || !std::isfinite(y1))
    return core::fail("rectangle: coordinates must be finite, width and height above 0");
  constexpr double kLeast = 1e-3;
  const double half_x = std::max(0.5 * std::fabs(x1 - x0), kLeast) / width * 2.0;
  const double half_y = std::max(0.5 * std::fabs(y1 - y0), kLeast) / height * 2.0;
  const double middle_x = (x0 + x1) / width - 1.0, middle_y = 1.0 - (y0 + y1) / height;
  core::dmat4 crop(1.0);
  crop[0][0] = 1.0 / half_x;
  crop[1][1] = 1.0 / half_y;
  crop[3][0] = -middle_x / half_x;
  crop[3][1] = -middle_y / half_y;
  auto result = core::View::from_matrices(view.eye_from_world(), crop * view.clip_from_eye(), view.clip_depth());
  if (!result) return result;
  result->sections = view.sections;
  result->section_mode = view.section_mode;
  result->layers = view.layers;
  return result;
}

core::View region_view(std::vector<Plane> planes, std::uint32_t layers) {
  core::dmat4 everything(0.0);  // maps every point into the middle of the image
  everything[3] = {0.0, 0.0, 0.5, 1.0};
  core::View view = *core::View::from_matrices(core::dmat4(1.0), everything, core::ClipDepth::kReversedZeroToOne);
  view.sections = std::move(planes);
  view.layers = layers;
  return view;
}

std::vector<Slot> items_in_region(const core::Snapshot& snapshot, const core::View& view,
                                  const core::VisibleSet& candidates, RegionRule rule) {
  const auto is_plane = [](const Plane& plane) { return glm::dot(plane.normal, plane.normal) > 0.0; };
  std::vector<Plane> planes, sections;
  for (const Plane& plane : core::frustum_planes(view.clip_from_world(), view.clip_depth()))
    if (is_plane(plane)) planes.push_back(plane);
  std::copy_if(view.sections.begin(), view.sections.end(), std::back_inserter(sections), is_plane);
  const core::Aabb& extent = snapshot.bounds().extent();
  const dvec3 origin = snapshot.bounds().origin, room = 0.01 * (dvec3(extent.max) - dvec3(extent.min)) + 1e-3;
  const AabbD bounds{origin + dvec3(extent.min) - room, origin + dvec3(extent.max) + room};
  std::vector<Region> regions;
  const auto add = [&] {
    Region region(planes, bounds);
    if (!region.empty()) regions.push_back(std::move(region));
  };
  if (view.section_mode == core::SectionMode::kUnion && !sections.empty()) {
    for (const Plane& section : sections) {
      planes.push_back(section);
      add();
      planes.pop_back();
    }
  } else {
    planes.insert(planes.end(), sections.begin(), sections.end());
    add();
  }
  std::vector<Slot> found;
  candidates.for_each_slot([&](Slot slot) {
    if (!snapshot.vacant(slot) && std::any_of(regions.begin(), regions.end(), [&](const Region& region) {
          return holds(region, snapshot, slot, rule);
        }))
      found.push_back(slot);
  });
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace sightline::culling
