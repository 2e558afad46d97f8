#include "sightline/analysis/measure/internal/closest.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace sightline::measure {
namespace {

using Form = Shape::Form;

double sweep_size(const Shape& shape);

constexpr int kMostCuts = 1 << 14;  // of sweeps, then the search ends

/// The pieces that a search begins with: a sweep by quarter turns.
std::vector<Piece> roots(const Shape& shape, const dvec3& offset) {
  Piece whole{&shape, offset};
  if (shape.form == Form::kTriangles && shape.nodes.empty()) return {};
  if (shape.form != Form::kSweep) return {whole};
  const double angle = shape.sweep.to - shape.sweep.from;
  const int count = std::max(1, int(std::ceil(angle / (0.25 * core::kFullTurn) - 1e-9)));
  const auto direction = [&](int i) {
    const double t = shape.sweep.from + angle * i / count;
    return dvec2(std::cos(t), std::sin(t));
  };
  std::vector<Piece> pieces(count, whole);
  for (int i = 0; i < count; ++i) pieces[i].from = direction(i), pieces[i].to = direction(i + 1);
  return pieces;
}

/// By about how much the hull of a piece that is not convex may exceed it.
double slack(const Piece& piece) {
  if (piece.shape->form == Form::kTriangles) return glm::length(piece.shape->nodes[piece.node].box.size());
  return sweep_size(*piece.shape) * glm::dot(piece.to - piece.from, piece.to - piece.from) / 8.0;
}

std::array<Piece, 2> halves(const Piece& piece) {
  std::array<Piece, 2> parts{piece, piece};
  if (piece.shape->form == Form::kTriangles) {
    const TriangleNode& node = piece.shape->nodes[piece.node];
    parts[0].node = piece.node + 1, parts[1].node = node.second;
  } else {
    parts[0].to = parts[1].from = glm::normalize(piece.from + piece.to);
  }
  return parts;
}

struct Pair {
  double lower;
  Piece a, b;
  dvec3 from_b;
  bool operator<(const Pair& other) const { return lower > other.lower; }  // the nearest on top of the heap
};

class Search {
 public:
  explicit Search(const SearchLimits& limits) : limits_(limits) {
    best_.upper = std::numeric_limits<double>::infinity();
    best_.lower = best_.upper;
  }

  void consider(const Piece& a, const Piece& b, const dvec3& guess) {
    const Gap hull = convex_gap(a, b, guess);
    const bool convex = a.is_convex() && b.is_convex();
    if (convex) improve(hull);
    if (!convex && has_slices(a) && has_slices(b)) {
      Piece slice_a = a, slice_b = b;
      slice_a.from = slice_a.to = hull.slice_a, slice_b.from = slice_b.to = hull.slice_b;
      improve(convex_gap(slice_a, slice_b, hull.from_b));
    }
    if (convex || is_beyond(hull.lower))
      lowest_ = std::min(lowest_, hull.lower);
    else
      queue_.push({hull.lower, a, b, hull.from_b});
  }

  Gap run() {
    for (int cuts = 0; !queue_.empty() && cuts < kMostCuts;) {
      if (best_.upper == 0.0 || is_beyond(queue_.top().lower)) break;
      const Pair pair = queue_.top();
      queue_.pop();
      const bool cut_a = pair.b.is_convex() || (!pair.a.is_convex() && slack(pair.a) >= slack(pair.b));
      const Piece& cut = cut_a ? pair.a : pair.b;
      if (cut.shape->form == Form::kSweep) ++cuts;
      for (const Piece& half : halves(cut)) consider(cut_a ? half : pair.a, cut_a ? pair.b : half, pair.from_b);
    }
    if (!queue_.empty()) lowest_ = std::min(lowest_, queue_.top().lower);
    best_.lower = std::min(lowest_, best_.upper);
    return best_;
  }

 private:
  static bool has_slices(const Piece& piece) { return piece.is_convex() || piece.shape->form == Form::kSweep; }
  /// Whether a pair of that lower bound cannot matter.
  bool is_beyond(double lower) const {
    constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
    return lower >= std::min(best_.upper * (1.0 - kRounding) - limits_.tolerance, limits_.farthest);
  }
  void improve(const Gap& gap) {
    if (gap.upper < best_.upper) best_ = gap;
  }

  SearchLimits limits_;
  double lowest_ = std::numeric_limits<double>::infinity();  ///< bound of all pairs that are not in the queue
  Gap best_;
  std::priority_queue<Pair> queue_;
};

double sweep_size(const Shape& shape) {
  if (shape.form != Form::kSweep) return 0.0;
  const dmat3& m = shape.linear;
  return (shape.sweep.outer + shape.sweep.tube) * std::max(glm::length(m[0]), glm::length(m[1]));
}

}  // namespace

double sweep_tolerance(const Shape& a, const Shape& b) {
  return 1e-10 * std::max(sweep_size(a), sweep_size(b));
}

Gap closest(const Shape& a, const Shape& b, const SearchLimits& limits) {
  const dvec3 offset = b.origin - a.origin;
  Search search({limits.farthest, std::max(limits.tolerance, sweep_tolerance(a, b))});
  const std::vector<Piece> roots_b = roots(b, offset);
  for (const Piece& piece_a : roots(a, dvec3(0.0)))
    for (const Piece& piece_b : roots_b)
      search.consider(piece_a, piece_b, offset == dvec3(0.0) ? dvec3(1, 0, 0) : -offset);
  return search.run();
}

bool encloses(const Shape& mesh, const dvec3& point) {
  const core::AabbD& box = mesh.nodes[0].box;
  if (glm::any(glm::lessThan(point, box.min)) || glm::any(glm::greaterThan(point, box.max))) return false;
  // The solid angle of each triangle (A. Van Oosterom, J. Strackee, 1983); together a multiple of a full sphere.
  double angle = 0.0;
  for (std::size_t i = 0; i < mesh.points.size(); i += 3) {
    const dvec3 a = mesh.points[i] - point, b = mesh.points[i + 1] - point, c = mesh.points[i + 2] - point;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double volume = glm::dot(a, glm::cross(b, c));
    angle += std::atan2(volume, la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return std::fabs(angle) > std::numbers::pi;  // 0 or 2 pi
}

}  // namespace sightline::measure
