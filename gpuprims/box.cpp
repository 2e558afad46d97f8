#include "sightline/gpuprims/box.h"

#include "sightline/gpuprims/mesh_builder.h"

namespace sightline::gpuprims {

core::Mesh tessellate(const core::Box& box, const Tessellation& /*config*/, Caps /*caps*/) {
  const float sizes[] = {box.size_x, box.size_y, box.size_z};
  if (!all_finite(sizes)) return {};
  const dvec3 half = 0.5 * glm::abs(dvec3(box.size_x, box.size_y, box.size_z));
  MeshBuilder builder;
  for (int axis = 0; axis < 3; ++axis) {
    const int right = (axis + 1) % 3, up = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      const auto corner = [&](double x, double y) {
        dvec3 p;
        p[axis] = side * half[axis];
        p[right] = side * x * half[right];  // mirrored for the negative side, which turns the winding
        p[up] = y * half[up];
        return p;
      };
      dvec3 normal(0.0);
      normal[axis] = side;
      const dvec3 face[] = {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
      builder.add_flat_polygon(face, normal);
    }
  }
  return builder.finish();
}

}  // namespace sightline::gpuprims
