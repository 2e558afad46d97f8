#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/analysis/measure/internal/closest.h"

namespace sightline::measure {
namespace {

/// The point of a simplex that is nearest to the origin, and the weights of the simplex's points there.
template <int N>
struct Nearest {
  dvec3 at{0.0};
  std::array<double, N> weights{};
  double squared() const { return glm::dot(at, at); }
};

Nearest<2> nearest(const std::array<dvec3, 2>& p) {
  const dvec3 edge = p[1] - p[0];
  const double squared = glm::dot(edge, edge);
  const double share = squared > 0.0 ? -glm::dot(p[0], edge) / squared : 0.0;
  if (!(share > 0.0)) return {p[0], {1.0, 0.0}};
  if (share >= 1.0) return {p[1], {0.0, 1.0}};
  return {p[0] + share * edge, {1.0 - share, share}};
}

/// The best of the faces that lack one of the points that `tried` names.
template <std::size_t N>
Nearest<int(N)> nearest_of_faces(const std::array<dvec3, N>& p, const std::array<bool, N>& tried);

Nearest<3> nearest(const std::array<dvec3, 3>& p) {
  const dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
  const double squared = glm::dot(normal, normal);
  if (!(squared > 0.0)) return nearest_of_faces(p, {true, true, true});
  const dvec3 foot =
      normal * ((glm::dot(p[0], normal) + glm::dot(p[1], normal) + glm::dot(p[2], normal)) / 3.0 / squared);
  // Areas in the coordinate plane where the triangle is largest.
  const dvec3 size = glm::abs(normal);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  Nearest<3> found;
  std::array<bool, 3> outside{};
  for (int i = 0; i < 3; ++i) {
    const dvec3 a = p[(i + 1) % 3] - foot, b = p[(i + 2) % 3] - foot;
    found.weights[i] = (a[x] * b[y] - a[y] * b[x]) / normal[axis];
    outside[i] = !(found.weights[i] > 0.0);
  }
  if (outside[0] || outside[1] || outside[2]) return nearest_of_faces(p, outside);
  found.at = foot;
  return found;
}

Nearest<4> nearest(const std::array<dvec3, 4>& p) {
  Nearest<4> found;
  double volume = 0.0;
  for (int i = 0; i < 4; ++i) {
    const dvec3 &a = p[(i + 1) % 4], &b = p[(i + 2) % 4], &c = p[(i + 3) % 4];
    found.weights[i] = (i % 2 == 0 ? 1.0 : -1.0) * glm::dot(a, glm::cross(b, c));
    volume += found.weights[i];
  }
  std::array<bool, 4> outside{};
  bool any = false;
  for (int i = 0; i < 4; ++i) {
    found.weights[i] /= volume;  // not finite for a flat simplex: then all faces are tried
    outside[i] = !(found.weights[i] > 0.0) || !std::isfinite(found.weights[i]);
    any = any || outside[i];
  }
  return any ? nearest_of_faces(p, outside) : found;
}

template <std::size_t N>
Nearest<int(N)> nearest_of_faces(const std::array<dvec3, N>& p, const std::array<bool, N>& tried) {
  Nearest<int(N)> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t left_out = 0; left_out < N; ++left_out) {
    if (!tried[left_out]) continue;
    std::array<dvec3, N - 1> face;
    for (std::size_t i = 0, k = 0; i < N; ++i)
      if (i != left_out) face[k++] = p[i];
    const Nearest<int(N) - 1> found = nearest(face);
    if (!(found.squared() < least)) continue;
    least = found.squared();
    best.at = found.at;
    for (std::size_t i = 0, k = 0; i < N; ++i) best.weights[i] = i == left_out ? 0.0 : found.weights[k++];
  }
  return best;
}

/// A point of the difference of the pieces, and where it comes from.
struct Vertex {
  dvec3 difference;
  Support a, b;
};

struct Simplex {
  explicit Simplex(const Vertex& vertex) : vertices{vertex}, nearest_point(vertex.difference) {}

  std::array<Vertex, 4> vertices;
  std::array<double, 4> weights{1.0};
  int count = 1;
  dvec3 nearest_point;

  double distance() const { return glm::length(nearest_point); }

  template <int N>
  void solve() {
    std::array<dvec3, N> points;
    for (int i = 0; i < N; ++i) points[i] = vertices[i].difference;
    const Nearest<N> found = nearest(points);
    count = 0;
    for (int i = 0; i < N; ++i) {
      if (!(found.weights[i] > 0.0)) continue;
      vertices[count] = vertices[i];
      weights[count++] = found.weights[i];
    }
    nearest_point = found.at;
  }
  void add(const Vertex& vertex) {
    vertices[count++] = vertex;
    if (count == 2) solve<2>();
    if (count == 3) solve<3>();
    if (count == 4) solve<4>();
  }
  bool has(const dvec3& point) const {
    for (int i = 0; i < count; ++i)
      if (vertices[i].difference == point) return true;
    return false;
  }
};

Vertex farthest_vertex(const Piece& a, const Piece& b, const dvec3& direction) {
  Vertex vertex{{}, support(a, direction), support(b, -direction)};
  vertex.difference = vertex.a.point - vertex.b.point;
  return vertex;
}

}  // namespace

Gap convex_gap(const Piece& a, const Piece& b, const dvec3& start) {
  constexpr int kMostSteps = 200, kMostFreshStarts = 3;
  constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  Gap gap;
  Simplex simplex(farthest_vertex(a, b, -start)), best = simplex;
  double reach = simplex.distance();
  int fresh_starts = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const double distance = simplex.distance();
    if (distance <= kRounding * reach) {  // the origin is in the hull as far as rounding tells
      gap.lower = 0.0;
      break;
    }
    // Unit vectors do not overflow when squared, however large the difference is.
    const dvec3 towards = simplex.nearest_point / -distance;
    const Vertex vertex = farthest_vertex(a, b, towards);
    reach = std::max({reach, glm::length(vertex.a.point - simplex.vertices[0].a.point),
                      glm::length(vertex.b.point - simplex.vertices[0].b.point)});
    gap.lower = std::max(gap.lower, -glm::dot(vertex.difference, towards));
    if (distance - gap.lower <= kRounding * (distance + reach) || simplex.has(vertex.difference)) break;
    // Beyond rounding a step makes progress, and the simplex does not hold the origin if a plane separates them. If not
    // so, the simplex has become too thin to compute with: once more from the last point alone.
    Simplex next = simplex;
    next.add(vertex);
    if (next.distance() < distance && next.distance() >= gap.lower - kRounding * reach) {
      simplex = next;
    } else {
      if (distance < best.distance()) best = simplex;
      if (fresh_starts++ == kMostFreshStarts) break;
      simplex = Simplex(vertex);
    }
  }
  if (best.distance() < simplex.distance()) simplex = best;
  dvec2 slice_a(0.0), slice_b(0.0);
  double sum = 0.0;
  gap.a = gap.b = dvec3(0.0);
  for (int i = 0; i < simplex.count; ++i) {
    const Vertex& vertex = simplex.vertices[i];
    const double weight = simplex.weights[i];
    gap.a += weight * vertex.a.point, gap.b += weight * vertex.b.point;
    slice_a += weight * vertex.a.slice, slice_b += weight * vertex.b.slice;
    sum += weight;
  }
  gap.a /= sum, gap.b /= sum;
  gap.slice_a = glm::normalize(slice_a), gap.slice_b = glm::normalize(slice_b);
  gap.upper = simplex.distance();
  gap.lower = std::min(gap.lower, gap.upper);
  if (gap.upper > 0.0) gap.from_b = simplex.nearest_point;
  return gap;
}

}  // namespace sightline::measure
