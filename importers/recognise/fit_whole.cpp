// Primitives that are known from a solid as a whole.
#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/importers/recognise/internal/shape_fit.h"

namespace sightline::importers::recognition {
namespace {

using core::dmat3;
using core::dvec2;

/// Deepest facet of a sphere, as a share of its radius: eight segments around and four from pole to pole give 0.15,
/// an icosahedron 0.2.
constexpr double kDeepestFacet = 0.165;
constexpr std::uint32_t kMostFacetCorners = 6;  // of a sphere: a flat face with more is a cut
constexpr double kFaceNoise = 1.0 / 250.0;      // of a polyhedron's least size that grid noise may explain
constexpr std::size_t kMostSamples = 256;

std::vector<std::uint32_t> all_triangles(const Solid& solid) {
  std::vector<std::uint32_t> all(solid.triangle_count());
  for (std::uint32_t t = 0; t < all.size(); ++t) all[t] = t;
  return all;
}

std::int64_t euler(const Solid& solid) {
  return std::int64_t(solid.points.size()) - std::int64_t(solid.triangle_count()) / 2;
}

dvec3 centroid(const Solid& solid) {
  dvec3 sum(0.0);
  for (const dvec3& p : solid.points) sum += p;
  return sum / double(solid.points.size());
}

/// Whether a flat face of a sphere is deeper than the facets and the noise explain. A cap of a sphere has the depth
/// A / (2 pi r).
bool is_cut(const Faces& faces, double radius, double noise) {
  double facet = 0.0, face = 0.0;
  for (const Face& f : faces.faces) {
    double& deepest = f.boundary <= kMostFacetCorners ? facet : face;
    deepest = std::max(deepest, f.area / (core::kFullTurn * radius));
  }
  return face > 1.5 * facet + noise;
}

/// Whether all triangles but slivers turn the same side to a point, as those of a sphere do to its centre.
bool is_seen_whole(const Solid& solid, const dvec3& from, double noise) {
  int side = 0;
  for (std::uint32_t t = 0; t < solid.triangle_count(); ++t) {
    const dvec3 normal = solid.area_vector(t);
    double longest = 0.0;
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h)
      longest = std::max(longest, glm::distance(solid.points[solid.from(h)], solid.points[solid.to(h)]));
    if (glm::length(normal) <= noise * longest) continue;
    const int own = glm::dot(normal, solid.points[solid.corners[3 * t]] - from) > 0.0 ? 1 : -1;
    if (side == -own) return false;
    side = own;
  }
  return true;
}

std::optional<Found> fit_sphere(const Solid& solid, const Faces& faces, const Allowance& allowance) {
  if (solid.points.size() < 12 || euler(solid) != 2) return {};
  const dvec3 middle = centroid(solid);
  const std::size_t stride = std::max<std::size_t>(1, solid.points.size() / kMostSamples);
  dmat3 a(0.0);
  dvec3 b(0.0), mean(0.0);
  double squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < solid.points.size(); i += stride) mean += solid.points[i] - middle, count += 1.0;
  mean /= count;
  for (std::size_t i = 0; i < solid.points.size(); i += stride) {
    const dvec3 p = solid.points[i] - middle - mean;
    const double squared = glm::dot(p, p);
    a += glm::outerProduct(p, p), b += 0.5 * squared * p, squares += squared;
  }
  const auto offset = solve(a, b);
  if (!offset) return {};
  const double radius = std::sqrt(squares / count + glm::dot(*offset, *offset));
  Found found{core::Sphere{float(2.0 * radius)}, core::translation(middle + mean + *offset), {}, 0.0};
  const double deepest = kDeepestFacet * radius, vertex = allowance.vertex(radius, 0.5 * deepest);
  for (std::size_t i = 0; i < solid.points.size(); i += stride)  // most solids end here
    if (std::fabs(glm::length(solid.points[i] - found.mesh_from_primitive.origin) - radius) > vertex) return {};
  if (is_cut(faces, radius, vertex) || !is_seen_whole(solid, found.mesh_from_primitive.origin, vertex)) return {};
  found.triangles = all_triangles(solid);
  if (!verify(solid, vertex, deepest, 0.0, 0.0, found)) return {};
  // The vertices' own allowance follows from the facets that they belong to.
  if (!verify(solid, allowance.vertex(radius, found.deviation), deepest, 0.0, 0.0, found)) return {};
  return found;
}

/// Eigenvectors of a symmetric matrix by Jacobi's rotations, as columns, and the eigenvalues.
dmat3 eigenvectors(dmat3 a, dvec3& values) {
  dmat3 vectors(1.0);
  for (int sweep = 0; sweep < 24; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (std::fabs(a[p][q]) <= 1e-300) continue;
        const double theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
        const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(1.0 + theta * theta));
        const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
        dmat3 rotation(1.0);
        rotation[p][p] = rotation[q][q] = c, rotation[q][p] = s, rotation[p][q] = -s;
        a = glm::transpose(rotation) * a * rotation;
        vectors = vectors * rotation;
      }
  values = {a[0][0], a[1][1], a[2][2]};
  return vectors;
}

/// The direction in which vertices scatter unlike in the two across: the axis of a closed circular torus.
dvec3 axis_of_scatter(const Solid& solid, const dvec3& middle) {
  dmat3 scatter(0.0);
  for (const dvec3& p : solid.points) scatter += glm::outerProduct(p - middle, p - middle);
  dvec3 values;
  const dmat3 vectors = eigenvectors(scatter, values);
  int axis = 0;
  double apart = -1e300;
  for (int i = 0; i < 3; ++i) {
    const double u = values[(i + 1) % 3], v = values[(i + 2) % 3];
    const double off = std::fabs(values[i] - 0.5 * (u + v)) - std::fabs(u - v);
    if (off > apart) apart = off, axis = i;
  }
  return vectors[axis];
}

/// A solid as seen along an axis: (distance from the axis, height) of each vertex.
struct Outline {
  dmat3 axes{1.0};
  std::vector<dvec2> points;
  double sagitta = 0.0;  ///< of the widest gap between vertices around the axis
  bool closed = false;   ///< no gap is too wide for a tessellation
};

Outline outline_about(const Solid& solid, const dvec3& middle, const dvec3& axis) {
  Outline outline;
  outline.axes = axes_along(axis, solid.points[0] - middle);
  const dmat3 turn = glm::transpose(outline.axes);
  std::vector<double> azimuths;
  double far = 0.0;
  for (const dvec3& p : solid.points) {
    const dvec3 q = turn * (p - middle);
    outline.points.emplace_back(std::hypot(q.x, q.y), q.z);
    azimuths.push_back(std::atan2(q.y, q.x));
    far = std::max(far, outline.points.back().x);
  }
  std::sort(azimuths.begin(), azimuths.end());
  double gap = azimuths.front() + core::kFullTurn - azimuths.back();
  for (std::size_t i = 1; i < azimuths.size(); ++i) gap = std::max(gap, azimuths[i] - azimuths[i - 1]);
  outline.sagitta = far * (1.0 - std::cos(0.5 * gap));
  outline.closed = gap <= core::kFullTurn / 5.0;
  return outline;
}

/// Means of the values below and above the middle of their range.
dvec2 two_means(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto middle = std::upper_bound(values.begin(), values.end(), 0.5 * (values.front() + values.back()));
  const auto mean = [](auto first, auto last) {
    double sum = 0.0;
    for (auto v = first; v != last; ++v) sum += *v;
    return first == last ? 0.0 : sum / double(last - first);
  };
  return {mean(values.begin(), middle), mean(middle, values.end())};
}

std::optional<Found> fit_closed_rectangular_torus(const Solid& solid, const Faces& faces, const dvec3& middle,
                                                  const Allowance& allowance) {
  // Its flat sides are the faces with the most edges.
  const auto side = std::max_element(faces.faces.begin(), faces.faces.end(),
                                     [](const Face& p, const Face& q) { return p.boundary < q.boundary; });
  if (side->boundary < 2 * kLeastSegments) return {};
  const Outline outline = outline_about(solid, middle, side->normal);
  if (!outline.closed) return {};
  std::vector<double> distances, heights;
  for (const dvec2& p : outline.points) distances.push_back(p.x), heights.push_back(p.y);
  const dvec2 radii = two_means(std::move(distances)), levels = two_means(std::move(heights));
  const double width = radii.y - radii.x, height = levels.y - levels.x;
  if (!(width > 0.0 && height > 0.0)) return {};
  Found found{core::RectangularTorus{float(radii.x), float(radii.y), float(height), float(core::kFullTurn)},
              {outline.axes, middle + 0.5 * (levels.x + levels.y) * outline.axes[2]},
              all_triangles(solid),
              0.0};
  const double vertex = allowance.vertex(std::min(width, height), outline.sagitta);
  return verify(solid, vertex, outline.sagitta, 0.0, outline.sagitta, found) ? std::optional(found) : std::nullopt;
}

std::optional<Found> fit_closed_circular_torus(const Solid& solid, const dvec3& middle, const Allowance& allowance) {
  const Outline outline = outline_about(solid, middle, axis_of_scatter(solid, middle));
  const auto circle = fit_circle(outline.points);
  if (!outline.closed || !circle || circle->radius >= circle->centre.x) return {};
  const double tube = circle->radius;
  Found found{core::CircularTorus{float(circle->centre.x), float(tube), float(core::kFullTurn)},
              {outline.axes, middle + circle->centre.y * outline.axes[2]},
              all_triangles(solid),
              0.0};
  const double coarsest = tube * (1.0 - std::cos(0.5 * core::kFullTurn / double(kLeastSegments)));
  if (!verify(solid, allowance.vertex(tube, coarsest), kDeepestFacet * tube + outline.sagitta, 0.0, 0.0, found))
    return {};
  // The vertices' own allowance follows from the facets that they belong to.
  if (!verify(solid, allowance.vertex(tube, found.deviation), found.deviation, 0.0, 0.0, found)) return {};
  return found;
}

/// The rectangular one first: the corners of a rectangle lie on a circle, too.
std::optional<Found> fit_closed_torus(const Solid& solid, const Faces& faces, const Allowance& allowance) {
  if (euler(solid) != 0 || solid.points.size() < 4 * kLeastSegments) return {};
  const dvec3 middle = centroid(solid);
  if (auto found = fit_closed_rectangular_torus(solid, faces, middle, allowance)) return found;
  return fit_closed_circular_torus(solid, middle, allowance);
}

// --- boxes and pyramids ---------------------------------------------------------------------------------------------

/// Vertices where three faces or more meet.
std::vector<std::uint32_t> corners_of(const Solid& solid, const Faces& faces) {
  struct Seen {
    std::array<std::uint32_t, 3> faces;
    int count = 0;
  };
  std::vector<Seen> seen(solid.points.size());
  for (std::uint32_t h = 0; h < solid.corners.size(); ++h) {
    Seen& at = seen[solid.corners[h]];
    const std::uint32_t face = faces.of_triangle[h / 3];
    if (at.count < 3 && std::find(at.faces.begin(), at.faces.begin() + at.count, face) == at.faces.begin() + at.count)
      at.faces[std::size_t(at.count++)] = face;
  }
  std::vector<std::uint32_t> corners;
  for (std::uint32_t v = 0; v < seen.size(); ++v)
    if (seen[v].count == 3) corners.push_back(v);
  return corners;
}

/// One end of a pyramid in the frame of its base: middle and sizes.
struct End {
  dvec2 middle{0.0};
  dvec2 size{0.0};
};

/// A rectangle along x and y, a line along one of them, or a point. Nothing for other sets of points.
std::optional<End> end_of(const std::vector<dvec2>& points, double same) {
  dvec2 low(1e300), high(-1e300);
  for (const dvec2& p : points) low = glm::min(low, p), high = glm::max(high, p);
  const dvec2 size = high - low;
  const std::size_t expected = (size.x > same ? 2u : 1u) * (size.y > same ? 2u : 1u);
  if (points.size() != expected) return {};
  for (const dvec2& p : points)
    for (int k = 0; k < 2; ++k)
      if (std::min(p[k] - low[k], high[k] - p[k]) > same) return {};
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (std::max(std::fabs(points[i].x - points[j].x), std::fabs(points[i].y - points[j].y)) <= same) return {};
  return End{0.5 * (low + high), {size.x > same ? size.x : 0.0, size.y > same ? size.y : 0.0}};
}

/// With the given face as its base.
std::optional<Found> fit_pyramid(const Solid& solid, const Faces& faces, std::uint32_t base,
                                 const std::vector<std::uint32_t>& corners, const Allowance& allowance) {
  // Base corners: those whose distance from the base's plane is nothing.
  const Face& face = faces.faces[base];
  const dvec3 normal = -face.normal, at = solid.points[solid.corners[3 * face.seed]];
  double height = 0.0;
  for (const std::uint32_t v : corners) height = std::max(height, std::fabs(glm::dot(normal, solid.points[v] - at)));
  std::vector<std::uint32_t> low, high;
  double top = 0.0;
  for (const std::uint32_t v : corners) {
    const double z = glm::dot(normal, solid.points[v] - at);
    (std::fabs(z) < 0.5 * height ? low : high).push_back(v);
    if (std::fabs(z) >= 0.5 * height) top += z;
  }
  if (low.size() != 4 || high.empty()) return {};
  top /= double(high.size());
  // x along the base's longest side.
  std::array<dvec3, 3> sides;  // the last is the diagonal
  for (std::size_t i = 0; i < 3; ++i) sides[i] = solid.points[low[i + 1]] - solid.points[low[0]];
  std::sort(sides.begin(), sides.end(), [](const dvec3& p, const dvec3& q) { return glm::dot(p, p) < glm::dot(q, q); });
  const double sign = top < 0.0 ? -1.0 : 1.0;
  const dmat3 axes = axes_along(sign * normal, sides[1]), turn = glm::transpose(axes);
  double least = std::fabs(top);
  std::vector<dvec2> points[2];
  double base_z = 0.0;
  for (const std::uint32_t v : low) base_z += 0.25 * (turn * (solid.points[v] - at)).z;
  for (int end = 0; end < 2; ++end)
    for (const std::uint32_t v : end == 0 ? low : high) {
      const dvec3 q = turn * (solid.points[v] - at);
      points[end].emplace_back(q.x, q.y);
    }
  dvec2 smallest(1e300), largest(-1e300);
  for (const dvec2& p : points[0]) smallest = glm::min(smallest, p), largest = glm::max(largest, p);
  least = std::min({least, largest.x - smallest.x, largest.y - smallest.y});
  const double noise = std::max(2.0 * allowance.noise.rounding, std::min(allowance.noise.grid, kFaceNoise * least));
  const double vertex =
      allowance.chosen > 0.0 ? std::min(allowance.chosen, 0.1 * least) : std::min(4.0 * noise, kFaceNoise * least);
  const auto bottom = end_of(points[0], vertex), above = end_of(points[1], vertex);
  if (!bottom || !above || bottom->size.x == 0.0 || bottom->size.y == 0.0) return {};
  dvec2 offset = above->middle - bottom->middle, sizes[2] = {bottom->size, above->size};
  const double h = std::fabs(top) - base_z;
  Found found;
  const bool straight = std::max({std::fabs(offset.x), std::fabs(offset.y), std::fabs(bottom->size.x - above->size.x),
                                  std::fabs(bottom->size.y - above->size.y)}) <= vertex;
  if (straight) {
    offset = dvec2(0.0), sizes[0] = sizes[1] = 0.5 * (bottom->size + above->size);
    found.primitive = core::Box{float(sizes[0].x), float(sizes[0].y), float(h)};
  } else {
    found.primitive = core::Pyramid{float(sizes[0].x), float(sizes[0].y), float(sizes[1].x), float(sizes[1].y),
                                    float(offset.x),   float(offset.y),   float(h)};
  }
  const dvec2 middle = 0.5 * (bottom->middle + above->middle);
  found.mesh_from_primitive = {axes, at + axes * dvec3(middle, base_z + 0.5 * h)};
  found.triangles = all_triangles(solid);
  if (!verify(solid, vertex, 0.0, 0.0, 0.0, found)) return {};
  // Near a sharp edge, corners that lie close to all faces may be far apart.
  double apart = 0.0;
  for (int end = 0; end < 2; ++end)
    for (const std::uint32_t v : end == 0 ? low : high) {
      const dvec3 q = turn * (solid.points[v] - found.mesh_from_primitive.origin);
      const dvec2 across = glm::abs(dvec2(q) - (end - 0.5) * offset) - 0.5 * sizes[end];
      apart = std::max(apart, glm::length(dvec3(across, std::fabs(q.z) - 0.5 * h)));
    }
  found.along = found.deviation = std::max(found.deviation, apart);
  return found;
}

std::optional<Found> fit_polyhedron(const Solid& solid, const Faces& faces, const Allowance& allowance) {
  if (faces.faces.size() < 5 || faces.faces.size() > 6) return {};
  const std::vector<std::uint32_t> corners = corners_of(solid, faces);
  if (corners.size() < 5 || corners.size() > 8) return {};
  std::optional<Found> best;
  for (std::uint32_t base = 0; base < faces.faces.size(); ++base) {
    auto found = fit_pyramid(solid, faces, base, corners, allowance);
    if (!found) continue;
    if (core::kind_of(found->primitive) == core::Kind::kBox) return found;
    if (!best) best = std::move(found);
  }
  return best;
}

}  // namespace

std::optional<Found> fit_whole(const Solid& solid, const Faces& faces, const Allowance& allowance) {
  if (auto found = fit_polyhedron(solid, faces, allowance)) return found;
  if (auto found = fit_sphere(solid, faces, allowance)) return found;
  return fit_closed_torus(solid, faces, allowance);
}

}  // namespace sightline::importers::recognition
