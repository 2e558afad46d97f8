#include "sightline/gpuprims/pyramid.h"

#include <cmath>

#include "sightline/gpuprims/mesh_builder.h"

namespace sightline::gpuprims {

core::Mesh tessellate(const core::Pyramid& p, const Tessellation& /*config*/, Caps caps) {
  const float values[] = {p.bottom_x, p.bottom_y, p.top_x, p.top_y, p.offset_x, p.offset_y, p.height};
  if (!all_finite(values)) return {};
  const dvec3 end = 0.5 * dvec3(p.offset_x, p.offset_y, std::fabs(p.height));
  const auto rectangle = [](const dvec3& centre, double size_x, double size_y, dvec3 corners[4]) {
    const double x = 0.5 * std::fabs(size_x), y = 0.5 * std::fabs(size_y);
    const dvec2 signs[] = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
    for (int i = 0; i < 4; ++i) corners[i] = centre + dvec3(signs[i], 0.0);
  };
  dvec3 bottom[4], top[4];
  rectangle(-end, p.bottom_x, p.bottom_y, bottom);
  rectangle(end, p.top_x, p.top_y, top);

  MeshBuilder builder;
  for (int i = 0; i < 4; ++i) {
    const int next = (i + 1) % 4;
    builder.add_flat_quad(bottom[i], bottom[next], top[next], top[i]);
  }
  if (caps.top) builder.add_flat_polygon(top, {0.0, 0.0, 1.0});
  if (caps.bottom) {
    const dvec3 from_below[] = {bottom[3], bottom[2], bottom[1], bottom[0]};
    builder.add_flat_polygon(from_below, {0.0, 0.0, -1.0});
  }
  return builder.finish();
}

}  // namespace sightline::gpuprims
