#include "sightline/importers/recognise/internal/ring_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sightline::importers::recognition {
namespace {

/// Triangles from the largest to the smallest, by powers of two of their squared areas. Within one power they keep
/// their order.
std::vector<std::uint32_t> by_size(const Solid& solid, std::vector<dvec3>& areas) {
  constexpr int kLowest = -400, kHighest = 400;
  areas.resize(solid.triangle_count());
  std::vector<int> power(areas.size());
  std::array<std::uint32_t, kHighest - kLowest + 2> begin{};
  for (std::uint32_t t = 0; t < areas.size(); ++t) {
    areas[t] = solid.area_vector(t);
    const double squared = glm::dot(areas[t], areas[t]);
    power[t] = kHighest - std::clamp(squared > 0.0 ? std::ilogb(squared) : kLowest, kLowest, kHighest);
    ++begin[std::size_t(power[t]) + 1];
  }
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<std::uint32_t> order(areas.size());
  for (std::uint32_t t = 0; t < areas.size(); ++t) order[begin[std::size_t(power[t])]++] = t;
  return order;
}

/// Puts half-edges into the order of a loop. False when they are not one simple loop.
bool order_loop(const Solid& solid, std::vector<std::uint32_t>& half_edges) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> starts;  // vertex, half-edge
  for (const std::uint32_t h : half_edges) starts.emplace_back(solid.from(h), h);
  std::sort(starts.begin(), starts.end());
  for (std::size_t i = 1; i < starts.size(); ++i)
    if (starts[i].first == starts[i - 1].first) return false;
  const std::uint32_t first = half_edges.front();
  std::size_t count = 0;
  std::uint32_t h = first;
  do {
    if (count == starts.size()) return false;
    half_edges[count++] = h;
    const auto at = std::lower_bound(starts.begin(), starts.end(), std::pair(solid.to(h), 0u));
    if (at == starts.end() || at->first != solid.to(h)) return false;
    h = at->second;
  } while (h != first);
  return count == starts.size();
}

/// Whether a triangle that is entered by a half-edge may lie in a plane of this normal, for all that its own says. A
/// sliver thinner than the noise has none: it belongs to the face beyond its longest edges.
bool joins(const Solid& solid, std::uint32_t entry, const dvec3& area, const dvec3& normal, double noise) {
  const auto length = [&](std::uint32_t h) {
    return glm::length(solid.points[solid.to(h)] - solid.points[solid.from(h)]);
  };
  const double own = length(entry);
  const double longest = std::max({own, length(Solid::next(entry)), length(Solid::previous(entry))});
  const double twice = glm::length(area);
  if (twice <= 2.0 * noise * longest) return own > 0.7 * longest;
  return glm::dot(normal, area) > 0.5 * twice;
}

class Walker {
 public:
  Walker(const Solid& solid, const Faces& faces, RingChain& out)
      : solid_(solid), faces_(faces), out_(out), used_(solid.triangle_count(), false), mark_(solid.points.size(), 0) {}

  /// `inner`: half-edges of the first ring, in order, in the triangles of out_.first_cap.
  void run(std::vector<std::uint32_t> inner) {
    for (const std::uint32_t t : out_.first_cap) used_[t] = true;
    std::size_t taken = out_.first_cap.size();
    add_ring(std::move(inner));
    for (;;) {
      Ring next;
      std::vector<std::uint32_t> band;
      if (!walk_band(out_.rings.back(), next, band)) break;
      for (const std::uint32_t t : band) used_[t] = true;
      taken += band.size();
      out_.bands.push_back(std::move(band));
      if (next.is_pole()) {
        out_.rings.push_back(std::move(next));
        break;
      }
      add_ring(std::move(next.inner));
      if (close_with_cap(out_.rings.back())) {
        taken += out_.last_cap.size();
        break;
      }
    }
    out_.whole = taken == solid_.triangle_count();
  }

 private:
  void add_ring(std::vector<std::uint32_t> inner) {
    Ring ring;
    for (const std::uint32_t h : inner) ring.vertices.push_back(solid_.from(h));
    ring.inner = std::move(inner);
    out_.rings.push_back(std::move(ring));
  }

  /// Goes once around the ring on the strip outside of it. Each step crosses an edge between this ring and the next.
  bool walk_band(const Ring& ring, Ring& next, std::vector<std::uint32_t>& band) {
    const std::size_t n = ring.vertices.size();
    ++stamp_;
    for (const std::uint32_t v : ring.vertices) mark_[v] = stamp_;
    const std::uint32_t first = solid_.twins[ring.inner[0]];
    if (first == kNone || used_[first / 3]) return false;
    const std::uint32_t w0 = solid_.from(Solid::previous(first));
    if (mark_[w0] == stamp_) return false;
    const std::uint32_t start = Solid::previous(first);  // from the apex to the ring's vertex 1
    std::uint32_t across = start, at = 1;                // at: of the ring's vertex that the strip has come to
    next.vertices.assign(1, w0);
    band.assign(1, first / 3);
    do {
      const std::uint32_t entry = solid_.twins[across];
      if (entry == kNone || used_[entry / 3] || band.size() > solid_.triangle_count()) return false;
      const std::uint32_t apex = solid_.from(Solid::previous(entry));
      if (entry / 3 != first / 3) band.push_back(entry / 3);
      if (mark_[apex] == stamp_) {
        // Onwards along the ring: the triangle has the ring's next edge.
        const std::uint32_t edge = solid_.twins[ring.inner[at % n]];
        if (at > n || edge == kNone || edge / 3 != entry / 3 || apex != ring.vertices[(at + 1) % n]) return false;
        ++at;
        across = Solid::next(entry);
      } else {
        next.vertices.push_back(apex);
        next.inner.push_back(Solid::next(entry));
        across = Solid::previous(entry);
      }
    } while (across != start);
    if (at != n + 1) return false;
    if (next.inner.empty()) return true;
    next.vertices.pop_back();  // the first again
    if (next.vertices.size() < 3) return false;
    ++stamp_;
    for (const std::uint32_t v : next.vertices) {
      if (mark_[v] == stamp_) return false;
      mark_[v] = stamp_;
    }
    return true;
  }

  /// Whether the ring is all of the boundary of a face.
  bool close_with_cap(const Ring& ring) {
    const std::uint32_t outside = solid_.twins[ring.inner[0]];
    if (outside == kNone) return false;
    const std::uint32_t face = faces_.of_triangle[outside / 3];
    if (faces_.faces[face].boundary != ring.inner.size()) return false;
    for (const std::uint32_t h : ring.inner)
      if (solid_.twins[h] == kNone || used_[solid_.twins[h] / 3] || faces_.of_triangle[solid_.twins[h] / 3] != face)
        return false;
    // Flood from the ring inwards: no search over all triangles.
    std::vector<std::uint32_t>& cap = out_.last_cap;
    const auto take = [&](std::uint32_t t) {
      if (used_[t] || faces_.of_triangle[t] != face) return;
      used_[t] = true;
      cap.push_back(t);
    };
    take(outside / 3);
    for (std::size_t i = 0; i < cap.size(); ++i)
      for (std::uint32_t h = 3 * cap[i]; h < 3 * cap[i] + 3; ++h)
        if (solid_.twins[h] != kNone) take(solid_.twins[h] / 3);
    return true;
  }

  const Solid& solid_;
  const Faces& faces_;
  RingChain& out_;
  std::vector<bool> used_;
  std::vector<std::uint32_t> mark_;
  std::uint32_t stamp_ = 0;
};

}  // namespace

void find_faces(const Solid& solid, double distance, Faces& out) {
  out.faces.clear();
  out.of_triangle.assign(solid.triangle_count(), kNone);
  std::vector<dvec3> areas;
  std::vector<std::uint32_t> open;
  for (const std::uint32_t seed : by_size(solid, areas)) {
    if (out.of_triangle[seed] != kNone) continue;
    const auto number = std::uint32_t(out.faces.size());
    // The plane turns with the sum of the triangles' normals: that of a sliver alone is known badly. Breadth first, so
    // that it is known well before it is asked about points far away.
    dvec3 sum = areas[seed], normal(0.0);
    const bool flat = glm::dot(sum, sum) > 0.0;
    if (flat) normal = glm::normalize(sum);
    dvec3 middle(0.0);
    for (std::uint32_t h = 3 * seed; h < 3 * seed + 3; ++h) middle += solid.points[solid.corners[h]] / 3.0;
    dvec3 centre = middle;
    out.of_triangle[seed] = number;
    open.assign(1, seed);
    const auto grow = [&] {
      for (std::size_t i = 0; i < open.size(); ++i)
        for (std::uint32_t h = 3 * open[i]; h < 3 * open[i] + 3; ++h) {
          const std::uint32_t twin = solid.twins[h];
          if (twin == kNone || out.of_triangle[twin / 3] != kNone) continue;
          const dvec3 apex = solid.points[solid.from(Solid::previous(twin))];
          if (std::fabs(glm::dot(normal, apex - middle)) > distance) continue;
          const dvec3& area = areas[twin / 3];
          if (!joins(solid, twin, area, normal, distance)) continue;
          out.of_triangle[twin / 3] = number;
          open.push_back(twin / 3);
          sum += area;
          centre += solid.points[solid.corners[twin]];
          const double length = glm::length(sum);
          if (length > 0.0) normal = sum / length;
        }
    };
    if (flat) {
      grow();
      // Once more with the plane of all: it takes what the first few triangles' plane missed.
      middle = centre / double(open.size());
      if (open.size() > 1) grow();
    }
    Face face{.normal = normal, .seed = seed};
    for (const std::uint32_t t : open) face.area += 0.5 * glm::length(areas[t]);
    out.faces.push_back(face);
  }
  for (std::uint32_t h = 0; h < solid.twins.size(); ++h) {
    const std::uint32_t twin = solid.twins[h], own = out.of_triangle[h / 3];
    if (twin == kNone || out.of_triangle[twin / 3] != own) ++out.faces[own].boundary;
  }
}

bool chain_from_face(const Solid& solid, const Faces& faces, std::uint32_t face, RingChain& out) {
  out = {};
  std::vector<std::uint32_t> inner;
  for (std::uint32_t t = 0; t < solid.triangle_count(); ++t) {
    if (faces.of_triangle[t] != face) continue;
    out.first_cap.push_back(t);
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h)
      if (solid.twins[h] == kNone || faces.of_triangle[solid.twins[h] / 3] != face) inner.push_back(h);
  }
  if (inner.size() < 3 || !order_loop(solid, inner)) return false;
  Walker(solid, faces, out).run(std::move(inner));
  return out.rings.size() > 1;
}

bool chain_from_pole(const Solid& solid, const Faces& faces, std::uint32_t half_edge, RingChain& out) {
  out = {};
  const std::uint32_t pole = solid.from(half_edge);
  std::vector<std::uint32_t> fan, inner;
  std::uint32_t h = half_edge;
  do {
    if (fan.size() > solid.triangle_count()) return false;
    fan.push_back(h / 3);
    inner.push_back(Solid::next(h));
    h = solid.twins[Solid::previous(h)];
    if (h == kNone) return false;
  } while (h != half_edge);
  if (inner.size() < 3 || !order_loop(solid, inner)) return false;
  out.first_cap = fan;
  Walker(solid, faces, out).run(std::move(inner));
  // The fan is the band between the pole and the first ring.
  out.rings.insert(out.rings.begin(), Ring{{pole}, {}});
  out.bands.insert(out.bands.begin(), std::move(out.first_cap));
  out.first_cap.clear();
  return true;
}

}  // namespace sightline::importers::recognition
