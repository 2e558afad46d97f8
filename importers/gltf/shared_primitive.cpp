#include "sightline/importers/gltf/internal/shared_primitive.h"

#include <bit>
#include <cmath>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/internal/tessellated.h"

namespace sightline::importers {
namespace {

/// Steps of the scale in an octave.
constexpr double kScaleSteps = 8.0;

/// Number of the step that ends at or above `scale`. Placements of one scale differ in its last digits, so a step ends
/// a little beyond its number.
double step_above(double scale) {
  return std::ceil(kScaleSteps * std::log2(scale) - 1e-4);
}
double scale_of_step(double step) {
  return 1.00001 * std::exp2(step / kScaleSteps);
}

/// A primitive of size 1 with the scale that makes the given one of it, and the part of it that stretches what is bent.
struct Unit {
  core::Primitive primitive;
  core::dvec3 scale{1.0}, bent{1.0};
};

Unit unit_of(const core::Primitive& primitive) {
  if (core::is_degenerate(primitive)) return {primitive};
  const auto size = [](float length) { return std::abs(double(length)); };
  if (const auto* cylinder = std::get_if<core::Cylinder>(&primitive)) {
    const double r = size(cylinder->radius);
    return {core::Cylinder{1, 1}, {r, r, size(cylinder->height)}, {r, r, 0}};
  }
  if (const auto* sphere = std::get_if<core::Sphere>(&primitive))
    return {core::Sphere{1}, core::dvec3(size(sphere->diameter)), core::dvec3(size(sphere->diameter))};
  if (const auto* box = std::get_if<core::Box>(&primitive))
    return {core::Box{1, 1, 1}, {size(box->size_x), size(box->size_y), size(box->size_z)}};
  return {primitive};
}

}  // namespace

core::Mesh SharedPrimitive::triangles(double tolerance, int segments) const {
  return gpuprims::tessellate(
      primitive,
      {.chord_tolerance = tolerance / largest_bend, .min_segments = segments, .max_segments = kMostSegments});
}

SharedPrimitive shared_primitive(const core::Primitive& primitive, const core::dmat3& world_from_item) {
  const Unit unit = unit_of(primitive);
  const core::Kind kind = core::kind_of(primitive);
  SharedPrimitive shared{unit.primitive, unit.scale};
  core::dmat3 bent = world_from_item;
  for (int c = 0; c < 3; ++c) bent[c] *= unit.bent[c];
  shared.bend = largest_scale(bent);
  shared.curved = kind != core::Kind::kLine && kind != core::Kind::kBox;
  const double step = shared.curved && shared.bend > 0.0 ? step_above(shared.bend) : 0.0;
  shared.largest_bend = scale_of_step(step);
  shared.key = {std::uint32_t(kind), std::uint32_t(std::int32_t(step))};
  const auto parameters = core::parameters(shared.primitive);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    shared.key[2 + i] = std::bit_cast<std::uint32_t>(parameters[i] + 0.0f);  // -0 becomes 0
  return shared;
}

}  // namespace sightline::importers
