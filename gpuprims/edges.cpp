#include "sightline/gpuprims/internal/edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sightline/gpuprims/internal/joints.h"

namespace sightline::gpuprims {
namespace {

using core::dvec3;
using core::length_of;

class EdgeList {
 public:
  explicit EdgeList(const core::Affine& placement) : placement_(placement) {}
  PrimitiveEdges take() const { return edges_; }

  void operator()(const core::Pyramid& p) { hexahedron(p); }
  void operator()(const core::Box& b) { hexahedron({b.size_x, b.size_y, b.size_x, b.size_y, 0.0f, 0.0f, b.size_z}); }
  void operator()(const core::RectangularTorus& t) {
    const auto [inner, outer] = std::minmax({length_of(t.inner_radius), length_of(t.outer_radius)});
    const double half = 0.5 * length_of(t.height), sweep = core::sweep_angle(t.angle);
    for (const double z : {-half, half})
      for (const double r : {inner, outer}) add({{0, 0, z}, {r, 0, 0}, {0, r, 0}, sweep});
    if (sweep == core::kFullTurn) return;
    for (const double angle : {0.0, sweep}) {
      const dvec3 out(std::cos(angle), std::sin(angle), 0.0), up(0.0, 0.0, half);
      ring({inner * out - up, outer * out - up, outer * out + up, inner * out + up});
    }
  }
  template <class Round>
  void operator()(const Round& round) {
    for (const Ends end : {kBottomEnd, kTopEnd})
      if (const auto face = end_face(round, placement_, end)) edges_.push_back({face->centre, face->u, face->v});
  }

 private:
  void add(const PrimitiveEdge& local) {
    const PrimitiveEdge edge{core::transform_point(placement_, local.centre), placement_.linear * local.u,
                             placement_.linear * local.v, local.sweep};
    if (edge.u != dvec3(0.0) || edge.v != dvec3(0.0)) edges_.push_back(edge);
  }
  void segment(const dvec3& from, const dvec3& to) {
    add({0.5 * (from + to), 0.5 * (from - to), dvec3(0.0), std::numbers::pi});
  }
  void ring(const std::array<dvec3, 4>& corners) {
    for (std::size_t i = 0; i < 4; ++i) segment(corners[i], corners[(i + 1) % 4]);
  }
  void hexahedron(const core::Pyramid& p) {
    const auto level = [&](double x, double y, double side) {
      const double half_x = 0.5 * std::abs(x), half_y = 0.5 * std::abs(y);
      const dvec3 centre(side * p.offset_x, side * p.offset_y, side * length_of(p.height));
      return std::array{centre + dvec3(-half_x, -half_y, 0), centre + dvec3(half_x, -half_y, 0),
                        centre + dvec3(half_x, half_y, 0), centre + dvec3(-half_x, half_y, 0)};
    };
    const auto bottom = level(p.bottom_x, p.bottom_y, -0.5), top = level(p.top_x, p.top_y, 0.5);
    ring(bottom), ring(top);
    for (std::size_t i = 0; i < 4; ++i) segment(bottom[i], top[i]);
  }

  const core::Affine& placement_;
  PrimitiveEdges edges_;
};

}  // namespace

PrimitiveEdges edges_of(const core::Primitive& primitive, const core::Affine& world_from_item) {
  EdgeList list(world_from_item);
  std::visit(list, primitive);
  return list.take();
}

}  // namespace sightline::gpuprims
