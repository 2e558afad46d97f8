#include "sightline/culling/frustum/internal/kernels.h"

#include <bit>

namespace sightline::culling {
namespace {

unsigned resolve(const ItemTest& test, std::size_t first, unsigned open, PlaneMask mask) {
  unsigned kept = 0;
  for (; open != 0; open &= open - 1) {
    const std::size_t i = first + std::size_t(std::countr_zero(open));
    const auto& c = test.coordinates;
    const core::Aabb box{{c[0][i], c[1][i], c[2][i]}, {c[3][i], c[4][i], c[5][i]}};
    if (test.exact->visible(box, mask)) kept |= 1u << (i - first);
  }
  return kept;
}

}  // namespace

ItemTest make_item_test(const core::ItemBounds& bounds, const CullPlanes& planes, std::uint32_t view_layers) {
  ItemTest test{};
  for (int axis = 0; axis < 6; ++axis) test.coordinates[axis] = bounds.coordinate(axis);
  test.item_count = bounds.size();
  test.layers = bounds.uses_layers() ? bounds.layers().data() : nullptr;
  test.view_layers = view_layers;
  test.planes = planes.planes();
  test.union_first = planes.union_first();
  test.plane_count = planes.plane_count();
  test.exact = &planes;
  test.resolve = resolve;
  return test;
}

const FrustumKernels& frustum_kernels() {
#ifdef SIGHTLINE_X86_KERNELS
  return core::form_in_use(scalar_frustum_kernels, avx2_frustum_kernels, avx512_frustum_kernels)();
#elif defined(SIGHTLINE_NEON_KERNELS)
  return core::form_in_use(scalar_frustum_kernels, simd128_frustum_kernels)();
#elif defined(SIGHTLINE_WASM_KERNELS)
  return simd128_frustum_kernels();
#else
  return scalar_frustum_kernels();
#endif
}

}  // namespace sightline::culling
