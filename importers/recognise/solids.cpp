#include "sightline/importers/recognise/internal/solids.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "sightline/core/affine.h"
#include "sightline/core/internal/sort_unique.h"

namespace sightline::importers::recognition {
namespace {

constexpr std::size_t kMostEdgeSamples = 4096;
constexpr double kLeastEvidence = 10.0;  // minus the logarithm of the chance that coordinates seem to lie on a grid
constexpr double kLeastSteps = 256.0;    // of a grid across the mesh: coarser ones are designs, not rounding
constexpr std::size_t kMostProbes = 64;
constexpr double kCellPerDistance = 16.0;

bool is_finite(const core::vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// The largest power of ten that all values are multiples of, counted from the first; 0 for none.
double decimal_step(std::vector<double>& values, double rounding) {
  if (values.empty()) return 0.0;
  const double first = values.front();
  core::sort_unique(values);
  const double extent = values.back() - values.front();
  if (!(extent > 0.0)) return 0.0;
  for (int exponent = int(std::floor(std::log10(extent))); exponent > -40; --exponent) {
    const double step = std::pow(10.0, exponent), slack = 2.0 * rounding / step;
    if (slack > 0.1) return 0.0;
    const bool fits = std::all_of(values.begin(), values.end(), [&](double value) {
      const double steps = (value - first) / step;
      return std::fabs(steps - std::round(steps)) <= slack + 1e-6;
    });
    if (!fits) continue;
    const double evidence = -std::log(2.0 * slack + 2e-6) * double(values.size() - 1);
    return extent >= kLeastSteps * step && evidence >= kLeastEvidence ? step : 0.0;
  }
  return 0.0;
}

std::uint64_t hash(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = 0;
  for (const std::int64_t v : {x, y, z}) {
    h = (h ^ std::uint64_t(v)) * 0x9e3779b97f4a7c15u;
    h ^= h >> 32;
  }
  return h * 0x9e3779b97f4a7c15u;
}

}  // namespace

CoordinateNoise coordinate_noise(const core::Mesh& mesh) {
  double size = 0.0;
  for (const core::vec3& p : mesh.positions)
    if (is_finite(p)) size = std::max({size, double(std::fabs(p.x)), double(std::fabs(p.y)), double(std::fabs(p.z))});
  CoordinateNoise noise;
  noise.rounding = size * 0x1p-22;  // two steps of a float of that size, for files that were in float before
  const std::size_t stride = std::max<std::size_t>(1, mesh.positions.size() / kMostEdgeSamples);
  double squares = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (std::size_t i = 0; i < mesh.positions.size(); i += stride)
      if (is_finite(mesh.positions[i])) values.push_back(double(mesh.positions[i][axis]));
    const double step = decimal_step(values, size * 0x1p-23);
    squares += 0.25 * step * step;
  }
  noise.grid = std::sqrt(squares);
  return noise;
}

Solids::Solids(const core::Mesh& mesh, const CoordinateNoise& noise) : noise_(4.0 * noise.rounding + noise.grid) {
  weld(mesh, noise.rounding);
  find_twins();
  find_components();
}

/// A hash of cells sixteen times as wide as the distance, so that most vertices lie in one cell alone. A vertex that
/// finds no place near its own (crafted files) is not welded.
void Solids::weld(const core::Mesh& mesh, double distance) {
  const std::size_t count = mesh.positions.size(), size = std::bit_ceil(std::max<std::size_t>(64, 2 * count));
  const int shift = 64 - std::countr_zero(size);
  std::vector<std::uint32_t> table(size, kNone), vertex_of(count, kNone);
  points_.reserve(std::min(count, mesh.indices.size()));
  const double cell = std::max(kCellPerDistance * distance, 1e-300);
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_finite(mesh.positions[i])) continue;
    const dvec3 p(mesh.positions[i]), scaled = p / cell;
    const dvec3 base = glm::floor(scaled), inside = scaled - base;
    int low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = inside[k] < 1.0 / kCellPerDistance ? -1 : 0;
      high[k] = inside[k] > 1.0 - 1.0 / kCellPerDistance ? 1 : 0;
    }
    std::uint32_t found = kNone;
    std::size_t free_place = size;
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z) {
          std::size_t place =
              hash(std::int64_t(base.x) + x, std::int64_t(base.y) + y, std::int64_t(base.z) + z) >> shift;
          for (std::size_t probe = 0; probe < kMostProbes; ++probe, place = (place + 1) & (size - 1)) {
            const std::uint32_t v = table[place];
            if (v == kNone) {
              if (x == 0 && y == 0 && z == 0) free_place = place;
              break;
            }
            const dvec3 apart = glm::abs(points_[v] - p);
            if (std::max({apart.x, apart.y, apart.z}) <= distance) found = std::min(found, v);
          }
        }
    if (found == kNone) {
      found = std::uint32_t(points_.size());
      points_.push_back(p);
      if (free_place < size) table[free_place] = found;
    }
    vertex_of[i] = found;
  }
  corners_.resize(mesh.indices.size());
  for (std::size_t i = 0; i < corners_.size(); i += 3) {
    for (std::size_t k = i; k < i + 3; ++k) corners_[k] = vertex_of[mesh.indices[k]];
    const std::uint32_t a = corners_[i], b = corners_[i + 1], c = corners_[i + 2];
    if (a == kNone || b == kNone || c == kNone || a == b || b == c || c == a) {
      corners_[i] = kNone;  // set aside
      ++set_aside_;
    }
  }
}

void Solids::find_twins() {
  twins_.assign(corners_.size(), kNone);
  // Half-edges by their lower vertex, each with the higher one.
  std::vector<std::uint32_t> begin(points_.size() + 1, 0);
  const auto for_each_edge = [&](auto&& visit) {
    for (std::uint32_t h = 0; h < corners_.size(); ++h) {
      if (corners_[h - h % 3] == kNone) continue;
      const std::uint32_t a = corners_[h], b = corners_[Solid::next(h)];
      visit(std::min(a, b), std::max(a, b), h);
    }
  };
  for_each_edge([&](std::uint32_t low, std::uint32_t, std::uint32_t) { ++begin[low + 1]; });
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<std::uint64_t> edges(begin.back());
  std::vector<std::uint32_t> fill(begin.begin(), begin.end() - 1);
  for_each_edge([&](std::uint32_t low, std::uint32_t high, std::uint32_t h) {
    edges[fill[low]++] = std::uint64_t(high) << 32 | h;
  });
  for (std::uint32_t v = 0; v + 1 < begin.size(); ++v) {
    std::uint64_t* const last = edges.data() + begin[v + 1];
    std::sort(edges.data() + begin[v], last);
    for (std::uint64_t* first = edges.data() + begin[v]; first != last;) {
      std::uint64_t* end = first;
      while (end != last && *end >> 32 == *first >> 32) ++end;
      if (end - first == 2) {
        const auto a = std::uint32_t(first[0]), b = std::uint32_t(first[1]);
        if (corners_[a] != corners_[b]) twins_[a] = b, twins_[b] = a;
      } else if (end - first > 2) {
        pair_around_edge(v, std::uint32_t(*first >> 32), first, end);
      }
      first = end;
    }
  }
}

/// Turning with the right hand about the edge from `low` to `high`, material begins at triangles that have the edge in
/// the other direction, and ends at those that have it in this one. Where noise alone could have swapped an end and a
/// begin, the end comes first: there two solids lie face to face.
void Solids::pair_around_edge(std::uint32_t low, std::uint32_t high, std::uint64_t* begin, std::uint64_t* end) {
  constexpr double kMostUnsure = 0.05;  // radians
  struct EdgeFace {
    double angle, unsure;
    std::uint32_t half_edge;
    bool opens;
  };
  const dvec3 a = points_[low], along = glm::normalize(points_[high] - a);
  dvec3 x(0.0), y(0.0);
  std::vector<EdgeFace> faces;
  for (std::uint64_t* e = begin; e != end; ++e) {
    const auto h = std::uint32_t(*e);
    const dvec3 w = points_[corners_[Solid::previous(h)]] - a, away = w - glm::dot(w, along) * along;
    const double length = glm::length(away);
    if (faces.empty()) {
      x = length > 0.0 ? away / length : dvec3(0.0);
      y = glm::cross(along, x);
    }
    const double unsure = length > 0.0 ? std::min(kMostUnsure, noise_ / length) : kMostUnsure;
    faces.push_back({std::atan2(glm::dot(away, y), glm::dot(away, x)), unsure, h, corners_[h] != low});
  }
  const auto by_angle = [](const EdgeFace& p, const EdgeFace& q) { return p.angle < q.angle; };
  std::stable_sort(faces.begin(), faces.end(), by_angle);
  // The widest gap goes to the ends, so that no two that belong together are parted.
  std::size_t first = 0;
  double widest = 2.0 * std::numbers::pi + faces.front().angle - faces.back().angle;
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].angle - faces[i - 1].angle > widest) widest = faces[i].angle - faces[i - 1].angle, first = i;
  for (std::size_t i = 0; i < first; ++i) faces[i].angle += 2.0 * std::numbers::pi;
  std::rotate(faces.begin(), faces.begin() + std::ptrdiff_t(first), faces.end());
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i - 1].opens && !faces[i].opens &&
        faces[i].angle - faces[i - 1].angle <= faces[i].unsure + faces[i - 1].unsure)
      std::swap(faces[i - 1], faces[i]);

  int depth = 0, least = 0;
  std::size_t start = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    depth += faces[i].opens ? 1 : -1;
    if (depth < least) least = depth, start = i + 1;
  }
  if (depth != 0) return;  // not solids: the edge stays open
  std::vector<std::uint32_t> opened;
  std::size_t closed = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const EdgeFace& face = faces[(start + i) % faces.size()];
    if (face.opens) {
      opened.push_back(face.half_edge);
    } else {
      const std::uint32_t other = opened[closed++];
      twins_[other] = face.half_edge, twins_[face.half_edge] = other;
    }
  }
}

void Solids::find_components() {
  const auto count = std::uint32_t(corners_.size() / 3);
  std::vector<std::uint32_t> solid(count, kNone), open;
  std::uint32_t solids = 0;
  first_.assign(1, 0);
  for (std::uint32_t seed = 0; seed < count; ++seed) {
    if (solid[seed] != kNone || corners_[3 * seed] == kNone) continue;
    solid[seed] = solids;
    open.assign(1, seed);
    std::uint32_t size = 0;
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      ++size;
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        if (twins_[h] == kNone || solid[twins_[h] / 3] != kNone) continue;
        solid[twins_[h] / 3] = solids;
        open.push_back(twins_[h] / 3);
      }
    }
    first_.push_back(first_.back() + size);
    ++solids;
  }
  order_.resize(first_.back());
  place_.resize(count);
  std::vector<std::uint32_t> fill(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < count; ++t) {
    if (solid[t] == kNone) continue;
    place_[t] = fill[solid[t]] - first_[solid[t]];
    order_[fill[solid[t]]++] = t;
  }
  local_.assign(points_.size(), kNone);
}

void Solids::get(std::size_t index, Solid& solid) {
  const std::uint32_t begin = first_[index], end = first_[index + 1];
  solid.points.clear(), solid.corners.clear(), solid.twins.clear();
  solid.origin.assign(order_.begin() + begin, order_.begin() + end);
  solid.open = false;
  for (const std::uint32_t t : solid.origin)
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      std::uint32_t& local = local_[corners_[h]];
      if (local == kNone) {
        local = std::uint32_t(solid.points.size());
        solid.points.push_back(points_[corners_[h]]);
      }
      solid.corners.push_back(local);
      const std::uint32_t twin = twins_[h];
      solid.twins.push_back(twin == kNone ? kNone : 3 * place_[twin / 3] + twin % 3);
      solid.open = solid.open || twin == kNone;
    }
  for (const std::uint32_t t : solid.origin)
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) local_[corners_[h]] = kNone;
}

}  // namespace sightline::importers::recognition
