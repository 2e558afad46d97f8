// An item's box from its record (gpuprims/packing.h): C++ twin of shaders/record_box.glsl.
#pragma once

#include <span>

#include "sightline/core/aabb.h"
#include "sightline/gpuprims/packing.h"
#include "sightline/gpuscene/gpu_scene.h"

namespace sightline::culling {

/// True when the box that the shader computes from the record surely contains `box`. `chunk`: origin of the record's
/// chunk, relative to that of the boxes. False for what has no extent, whose record says nothing but where it is, for
/// numbers beyond float's range, and for kinds without a shape in their record.
///
/// The shader adds to every coordinate a margin of 2^-20 of the absolute terms of the position and 2^-17 of those of
/// the shape, with 2^-43 added to each entry of the placement. Half of that is for its own rounding and flushed
/// denormals (at most 16 operations of 2^-23 each on every term, of square roots 2^-63 below which squares vanish);
/// that the other half suffices for what packing has rounded is looked at here, item by item.
bool record_box_contains(gpuscene::BatchKind kind, std::span<const gpuprims::Texel> record, const core::vec3& chunk,
                         const core::Aabb& box);

}  // namespace sightline::culling
