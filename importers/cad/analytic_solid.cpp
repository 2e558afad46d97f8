#include "sightline/importers/cad/internal/analytic_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace sightline::importers {
namespace {

using core::Affine;
using core::dvec3;

constexpr double kPi = std::numbers::pi;
/// Areas and volumes that Open CASCADE integrates are right to this share, which any other shape would miss.
constexpr double kShare = 1e-6;

/// The primitive of a patch, with the area of its curved surface.
struct Piece {
  AnalyticPart part;
  double area = 0.0, volume = 0.0, error = 0.0;
};
using Pieces = std::optional<std::vector<Piece>>;

dvec3 any_across(const dvec3& axis) {
  const dvec3 a = glm::abs(axis);
  const dvec3 least = a.x <= a.y && a.x <= a.z ? dvec3(1, 0, 0) : a.y <= a.z ? dvec3(0, 1, 0) : dvec3(0, 0, 1);
  return glm::normalize(glm::cross(axis, least));
}

/// Right-handed, with local z along the axis and local x along `x`, which is made to stand on it.
Affine frame_at(const dvec3& origin, const dvec3& axis, const dvec3& x) {
  const dvec3 across = glm::normalize(x - glm::dot(x, axis) * axis);
  return {core::dmat3(across, glm::cross(axis, across), axis), origin};
}

Affine frame_at(const dvec3& origin, const dvec3& axis) {
  return frame_at(origin, axis, any_across(axis));
}

/// The largest change of a parameter by its rounding to float, as a length; `lever` is what an angle counts with.
double rounding(std::initializer_list<double> lengths, double angle = 0.0, double lever = 0.0) {
  double largest = 0.0;
  for (const double length : lengths) largest = std::max(largest, std::abs(double(float(length)) - length));
  return largest + lever * std::abs(double(float(angle)) - angle);
}

bool near(double a, double b, double share) {
  return std::abs(a - b) <= share * std::max(std::abs(a), std::abs(b));
}

// --- pieces of a chain -----------------------------------------------------------------------------------------------

/// Where a plane cuts an axis, and its slant in a frame whose z is the axis.
struct Cut {
  double height = 0.0, tan_x = 0.0, tan_y = 0.0, slant = 0.0;  // slant: of both
};

std::optional<Cut> cut_of(const Border& border, const dvec3& origin, const Affine& frame) {
  constexpr double kLeastCosine = 0.1;
  const dvec3 n = glm::transpose(frame.linear) * border.normal;
  if (std::abs(n.z) < kLeastCosine) return std::nullopt;
  const double along = glm::dot(border.centre - origin, border.normal) / n.z;
  return Cut{along, -n.x / n.z, -n.y / n.z, std::hypot(n.x, n.y) / std::abs(n.z)};
}

/// Volume, and area of the curved surface, of a cone from its apex to a plane that cuts the axis `height` from there.
struct Cone {
  double volume = 0.0, area = 0.0;
};
std::optional<Cone> cone_to(double height, double slope, double slant) {
  const double k = std::abs(slope), rest = 1.0 - k * k * slant * slant;
  if (rest <= 0.01) return std::nullopt;  // nearly a parabola, or steeper
  const double projected = kPi * k * k * height * height / (rest * std::sqrt(rest));
  return Cone{projected * std::abs(height) / 3.0, projected * std::sqrt(1.0 + k * k) / k};
}

core::Snout snout_of(double r0, double r1, double height, const Cut& bottom, const Cut& top) {
  return {float(r0),
          float(r1),
          float(height),
          0.0f,
          0.0f,
          float(std::atan(bottom.tan_x)),
          float(std::atan(bottom.tan_y)),
          float(std::atan(top.tan_x)),
          float(std::atan(top.tan_y))};
}

/// A cylinder or cone between its borders, or from its border to the apex.
std::optional<Piece> straight_piece(const SurfacePatch& patch, double tolerance) {
  const bool cone = patch.kind == SurfaceKind::kCone;
  if (patch.borders.empty() || patch.borders.size() > 2 || (patch.borders.size() == 1 && !cone)) return std::nullopt;
  const Affine across = frame_at(patch.origin, patch.axis);
  std::array<Cut, 2> ends;
  for (std::size_t i = 0; i < patch.borders.size(); ++i) {
    const auto cut = cut_of(patch.borders[i], patch.origin, across);
    if (!cut) return std::nullopt;
    ends[i] = *cut;
  }
  const double apex = cone ? -patch.radius / patch.slope : 0.0;
  if (patch.borders.size() == 1) ends[1] = {apex, 0.0, 0.0, 0.0};
  if (ends[0].height > ends[1].height) std::swap(ends[0], ends[1]);
  const auto radius_at = [&](double height) { return std::max(0.0, patch.radius + patch.slope * height); };
  Piece piece;
  for (Cut& end : ends)
    if (end.slant * radius_at(end.height) <= tolerance) {  // as good as straight
      piece.error = std::max(piece.error, end.slant * radius_at(end.height));
      end.tan_x = end.tan_y = end.slant = 0.0;
    }
  const double height = ends[1].height - ends[0].height, r0 = radius_at(ends[0].height), r1 = radius_at(ends[1].height);
  if (height <= tolerance) return std::nullopt;
  const bool straight = ends[0].slant == 0.0 && ends[1].slant == 0.0;
  piece.part.solid_from_primitive =
      frame_at(patch.origin + 0.5 * (ends[0].height + ends[1].height) * patch.axis, patch.axis);
  if (!cone && straight)
    piece.part.primitive = core::Cylinder{float(r0), float(height)};
  else
    piece.part.primitive = snout_of(r0, r1, height, ends[0], ends[1]);
  // Rounded angles of slanted ends move their rims by no more than this.
  piece.error += rounding({r0, r1, height}) + (straight ? 0.0 : 1e-7 * (r0 + r1));
  if (!cone) {
    piece.volume = kPi * r0 * r0 * height;
    piece.area = 2.0 * kPi * r0 * height;
    return piece;
  }
  const auto low = cone_to(ends[0].height - apex, patch.slope, ends[0].slant),
             high = cone_to(ends[1].height - apex, patch.slope, ends[1].slant);
  if (!low || !high) return std::nullopt;
  piece.volume = std::abs(high->volume - low->volume);
  piece.area = std::abs(high->area - low->area);
  return piece;
}

/// A torus between two planes through its axis, or all of it.
std::optional<Piece> torus_piece(const SurfacePatch& patch, double tolerance) {
  if (patch.tube_radius > patch.radius || (patch.borders.size() != 2 && !patch.borders.empty())) return std::nullopt;
  Piece piece;
  double sweep = core::kFullTurn;
  dvec3 from = any_across(patch.axis);
  if (!patch.borders.empty()) {
    const double reach = patch.radius + patch.tube_radius;
    std::array<dvec3, 2> to;
    for (std::size_t i = 0; i < 2; ++i) {
      const Border& border = patch.borders[i];
      const double off = std::max(std::abs(glm::dot(border.centre - patch.origin, border.normal)),
                                  reach * std::abs(glm::dot(border.normal, patch.axis)));
      if (off > tolerance) return std::nullopt;
      piece.error = std::max(piece.error, off);
      const dvec3 out = border.centre - patch.origin;
      to[i] = out - glm::dot(out, patch.axis) * patch.axis;
    }
    const auto angle_to = [&](const dvec3& v) {
      const dvec3 y = glm::cross(patch.axis, to[0]);
      const double angle = std::atan2(glm::dot(v, y), glm::dot(v, to[0]));
      return angle < 0.0 ? angle + core::kFullTurn : angle;
    };
    from = to[0];
    sweep = angle_to(to[1]);
    if (angle_to(patch.inside - patch.origin) > sweep) {
      from = to[1];
      sweep = core::kFullTurn - sweep;
    }
  }
  piece.part = {core::CircularTorus{float(patch.radius), float(patch.tube_radius), float(sweep)},
                frame_at(patch.origin, patch.axis, from)};
  piece.error += rounding({patch.radius, patch.tube_radius}, patch.borders.empty() ? 0.0 : sweep,
                          patch.radius + patch.tube_radius);
  piece.area = 2.0 * kPi * patch.tube_radius * patch.radius * sweep;
  piece.volume = 0.5 * patch.tube_radius * piece.area;
  return piece;
}

/// A sphere, or what a plane leaves of it.
std::optional<Piece> sphere_piece(const SurfacePatch& patch, double tolerance) {
  Piece piece;
  const double r = patch.radius;
  if (patch.borders.empty()) {
    piece.part = {core::Sphere{float(2.0 * r)}, frame_at(patch.origin, {0.0, 0.0, 1.0})};
    piece.error = rounding({r});
    piece.area = 4.0 * kPi * r * r;
    piece.volume = r * piece.area / 3.0;
    return piece;
  }
  if (patch.borders.size() != 1) return std::nullopt;
  dvec3 up = patch.borders[0].normal;
  if (glm::dot(up, patch.inside - patch.borders[0].centre) < 0.0) up = -up;
  const double below = glm::dot(patch.borders[0].centre - patch.origin, up), height = r - below;
  if (height <= tolerance || std::abs(below) >= r) return std::nullopt;
  const double base = std::sqrt((r - below) * (r + below));
  piece.part = {core::SphericalDish{float(base), float(height)}, frame_at(patch.origin + below * up, up)};
  // The radius follows from base and height: it changes by less than both do, times twice their ratio.
  piece.error = rounding({base, height}) * (1.0 + 2.0 * std::max(base / height, height / base));
  piece.area = 2.0 * kPi * r * height;
  piece.volume = kPi * height * height * (r - height / 3.0);
  return piece;
}

std::optional<Piece> piece_of(const SurfacePatch& patch, double tolerance) {
  switch (patch.kind) {
    case SurfaceKind::kCylinder:
    case SurfaceKind::kCone:
      return straight_piece(patch, tolerance);
    case SurfaceKind::kTorus:
      return torus_piece(patch, tolerance);
    case SurfaceKind::kSphere:
      return sphere_piece(patch, tolerance);
    case SurfaceKind::kPlane:
      break;
  }
  return std::nullopt;
}

/// Curved patches that are convex and have planar borders, with nothing but planes or one another between.
Pieces chain(const SolidSurfaces& solid) {
  std::vector<Piece> pieces;
  for (const SurfacePatch& patch : solid.patches) {
    const bool plane = patch.kind == SurfaceKind::kPlane;
    if (!plane && !patch.convex) return std::nullopt;
    for (const Border& border : patch.borders)
      if (border.off_plane > solid.tolerance || (plane && solid.patches[border.neighbour].kind == SurfaceKind::kPlane))
        return std::nullopt;
    if (plane) continue;
    auto piece = piece_of(patch, solid.tolerance);
    if (!piece || !near(piece->area, patch.area, kShare)) return std::nullopt;
    for (const Border& border : patch.borders) piece->error = std::max(piece->error, border.off_plane);
    pieces.push_back(std::move(*piece));
  }
  return pieces;
}

// --- rings -----------------------------------------------------------------------------------------------------------

/// The axis that all cylinders share, with the planes across it and those along it.
struct Coaxial {
  const SurfacePatch* first = nullptr;
  std::vector<const SurfacePatch*> cylinders, across, along;
  double error = 0.0;
};

std::optional<Coaxial> coaxial(const SolidSurfaces& solid) {
  Coaxial found;
  for (const SurfacePatch& patch : solid.patches)
    if (patch.kind == SurfaceKind::kCylinder) found.cylinders.push_back(&patch);
  if (found.cylinders.empty()) return std::nullopt;
  found.first = *std::max_element(found.cylinders.begin(), found.cylinders.end(),
                                  [](const auto* a, const auto* b) { return a->radius < b->radius; });
  const dvec3 origin = found.first->origin, axis = found.first->axis;
  double reach = found.first->radius;
  for (const dvec3& corner : solid.corners) reach = std::max(reach, glm::length(corner - origin));
  for (const SurfacePatch& patch : solid.patches) {
    const double cosine = glm::dot(patch.axis, axis), turned = glm::length(glm::cross(patch.axis, axis));
    const dvec3 away = patch.origin - origin;
    double off = 0.0;
    if (patch.kind == SurfaceKind::kCylinder) {
      off = glm::length(away - glm::dot(away, axis) * axis) + turned * reach;
    } else if (patch.kind != SurfaceKind::kPlane) {
      return std::nullopt;
    } else if (std::abs(cosine) > 0.5) {
      off = turned * found.first->radius;
      found.across.push_back(&patch);
    } else {
      off = std::abs(glm::dot(away, patch.axis)) + std::abs(cosine) * reach;
      found.along.push_back(&patch);
    }
    if (off > solid.tolerance) return std::nullopt;
    found.error = std::max(found.error, off);
  }
  return found;
}

/// Radii from inner to outer, heights along the axis from low to high.
Piece ring(const Coaxial& of, const std::array<double, 2>& radii, const std::array<double, 2>& heights,
           const dvec3& from, double sweep) {
  const auto [inner, outer] = radii;
  const auto [low, high] = heights;
  const double height = high - low;
  Piece piece;
  piece.part.solid_from_primitive =
      frame_at(of.first->origin + 0.5 * (low + high) * of.first->axis, of.first->axis, from);
  if (inner == 0.0 && sweep == core::kFullTurn)
    piece.part.primitive = core::Cylinder{float(outer), float(height)};
  else
    piece.part.primitive = core::RectangularTorus{float(inner), float(outer), float(height), float(sweep)};
  piece.volume = 0.5 * sweep * (outer - inner) * (outer + inner) * height;
  piece.error = of.error + rounding({inner, outer, height}, sweep == core::kFullTurn ? 0.0 : sweep, outer);
  return piece;
}

/// Whole turns. The planes across the axis divide the solid into layers with one outer and at most one inner radius.
Pieces stack(const SolidSurfaces& solid) {
  const auto found = coaxial(solid);
  if (!found || !found->along.empty() || found->across.size() < 2) return std::nullopt;
  const dvec3 origin = found->first->origin, axis = found->first->axis;
  const auto height_of = [&](const dvec3& p) { return glm::dot(p - origin, axis); };
  std::vector<double> heights;
  for (const SurfacePatch* plane : found->across) heights.push_back(height_of(plane->origin));
  std::sort(heights.begin(), heights.end());
  heights.erase(
      std::unique(heights.begin(), heights.end(), [&](double a, double b) { return b - a <= solid.tolerance; }),
      heights.end());
  std::vector<double> outer(heights.size() - 1, 0.0), inner(outer);
  for (const SurfacePatch* cylinder : found->cylinders) {
    if (cylinder->borders.size() != 2) return std::nullopt;
    double low = height_of(cylinder->borders[0].centre), high = height_of(cylinder->borders[1].centre);
    if (low > high) std::swap(low, high);
    if (!near(cylinder->area, 2.0 * kPi * cylinder->radius * (high - low), kShare)) return std::nullopt;
    for (std::size_t i = 0; i < outer.size(); ++i) {
      const double middle = 0.5 * (heights[i] + heights[i + 1]);
      if (middle < low || middle > high) continue;
      double& radius = cylinder->convex ? outer[i] : inner[i];
      if (radius != 0.0) return std::nullopt;
      radius = cylinder->radius;
    }
  }
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < outer.size(); ++i) {
    if (outer[i] <= inner[i]) return std::nullopt;
    pieces.push_back(
        ring(*found, {inner[i], outer[i]}, {heights[i], heights[i + 1]}, any_across(axis), core::kFullTurn));
  }
  return pieces;
}

/// A part of a turn between two planes through the axis.
Pieces sector(const SolidSurfaces& solid) {
  const auto found = coaxial(solid);
  if (!found || found->along.size() != 2 || found->across.size() != 2 || found->cylinders.size() > 2)
    return std::nullopt;
  const dvec3 origin = found->first->origin, axis = found->first->axis;
  double inner = 0.0;
  for (const SurfacePatch* cylinder : found->cylinders)
    if (cylinder != found->first) inner = cylinder->radius;
  std::array<double, 2> heights;
  for (std::size_t i = 0; i < 2; ++i) heights[i] = glm::dot(found->across[i]->origin - origin, axis);
  if (heights[0] > heights[1]) std::swap(heights[0], heights[1]);
  // The solid lies behind both end planes, whose outward normals say in which direction it begins.
  dvec3 from{0.0}, to{0.0};
  for (const SurfacePatch* plane : found->along) {
    dvec3 out = glm::cross(axis, plane->axis);  // along the plane, away from the axis or towards it
    for (const dvec3& corner : solid.corners) {
      const dvec3 away = corner - origin - glm::dot(corner - origin, axis) * axis;
      if (glm::length(away) > 0.5 * found->first->radius && std::abs(glm::dot(away, plane->axis)) <= solid.tolerance)
        out = away;
    }
    (glm::dot(glm::cross(axis, out), plane->axis) < 0.0 ? from : to) = out;
  }
  if (from == dvec3(0.0) || to == dvec3(0.0)) return std::nullopt;
  double sweep = std::atan2(glm::dot(to, glm::cross(axis, from)), glm::dot(to, from));
  if (sweep <= 0.0) sweep += core::kFullTurn;
  for (const SurfacePatch* cylinder : found->cylinders)
    if (!near(cylinder->area, cylinder->radius * sweep * (heights[1] - heights[0]), kShare)) return std::nullopt;
  return std::vector{ring(*found, {inner, found->first->radius}, heights, from, sweep)};
}

// --- boxes and pyramids ----------------------------------------------------------------------------------------------

struct Rectangle {
  dvec3 centre, x, y;  // whole edges
};

std::optional<Rectangle> rectangle(std::vector<dvec3> p, double tolerance) {
  if (p.size() != 4) return std::nullopt;
  const auto far = std::max_element(p.begin() + 1, p.end(), [&](const dvec3& a, const dvec3& b) {
    return glm::length(a - p[0]) < glm::length(b - p[0]);
  });
  std::iter_swap(far, p.begin() + 3);
  const dvec3 x = p[1] - p[0], y = p[2] - p[0];
  const double off = std::abs(glm::dot(x, y)) / std::max(glm::length(x), glm::length(y));
  if (!(off <= tolerance) || glm::length(p[0] + x + y - p[3]) > tolerance) return std::nullopt;
  return Rectangle{0.25 * (p[0] + p[1] + p[2] + p[3]), x, y};
}

/// The top of a solid on a rectangle: another one along the same directions, a line along one of them, or a point.
std::optional<Rectangle> top_above(const Rectangle& base, const std::vector<dvec3>& p, double tolerance) {
  const auto along = [&](const dvec3& v, const dvec3& edge) {
    return glm::length(glm::cross(v, glm::normalize(edge))) <= tolerance;
  };
  if (p.size() == 1) return Rectangle{p[0], dvec3(0.0), dvec3(0.0)};
  if (p.size() == 2) {
    const dvec3 line = p[1] - p[0], centre = 0.5 * (p[0] + p[1]);
    if (along(line, base.x)) return Rectangle{centre, line, dvec3(0.0)};
    if (along(line, base.y)) return Rectangle{centre, dvec3(0.0), line};
    return std::nullopt;
  }
  auto top = rectangle(p, tolerance);
  if (!top) return std::nullopt;
  if (!along(top->x, base.x)) std::swap(top->x, top->y);
  return along(top->x, base.x) && along(top->y, base.y) ? top : std::nullopt;
}

Pieces pyramid(const SolidSurfaces& solid) {
  const double tolerance = solid.tolerance;
  const std::size_t corners = solid.corners.size();
  if (corners != 5 && corners != 6 && corners != 8) return std::nullopt;
  for (const SurfacePatch& patch : solid.patches)
    if (patch.kind != SurfaceKind::kPlane) return std::nullopt;
  for (const SurfacePatch& bottom : solid.patches) {
    std::vector<dvec3> low, high;
    for (const dvec3& corner : solid.corners)
      (std::abs(glm::dot(corner - bottom.origin, bottom.axis)) <= tolerance ? low : high).push_back(corner);
    const auto base = rectangle(low, tolerance);
    if (!base) continue;
    const auto top = top_above(*base, high, tolerance);
    if (!top) continue;
    const dvec3 up = -bottom.axis, lean = top->centre - base->centre;
    const double height = glm::dot(lean, up);
    const bool level = std::all_of(high.begin(), high.end(), [&](const dvec3& corner) {
      return std::abs(glm::dot(corner - top->centre, up)) <= tolerance;
    });
    if (!level || height <= tolerance) continue;
    const Affine frame = frame_at(0.5 * (base->centre + top->centre), up, base->x);
    const double bx = glm::length(base->x), by = glm::length(base->y), tx = glm::length(top->x),
                 ty = glm::length(top->y), ox = glm::dot(lean, frame.linear[0]), oy = glm::dot(lean, frame.linear[1]);
    Piece piece;
    piece.part.solid_from_primitive = frame;
    if (std::max({std::abs(bx - tx), std::abs(by - ty), std::abs(ox), std::abs(oy)}) <= tolerance)
      piece.part.primitive = core::Box{float(bx), float(by), float(height)};
    else
      piece.part.primitive =
          core::Pyramid{float(bx), float(by), float(tx), float(ty), float(ox), float(oy), float(height)};
    piece.volume = height / 6.0 * (bx * by + (bx + tx) * (by + ty) + tx * ty);  // Simpson's rule, exact here
    piece.error = tolerance + rounding({bx, by, tx, ty, ox, oy, height});
    return std::vector{piece};
  }
  return std::nullopt;
}

}  // namespace

std::optional<AnalyticSolid> analytic_solid(const SolidSurfaces& solid) {
  for (const auto form : {pyramid, chain, stack, sector}) {
    const Pieces pieces = form(solid);
    if (!pieces || pieces->empty()) continue;
    AnalyticSolid found;
    double volume = 0.0;
    for (const Piece& piece : *pieces) {
      volume += piece.volume;
      found.parts.push_back(piece.part);
      found.deviation = std::max(found.deviation, piece.error);
    }
    if (!near(volume, solid.volume, kShare)) continue;
    found.deviation += solid.merge_error;
    return found;
  }
  return std::nullopt;
}

}  // namespace sightline::importers
