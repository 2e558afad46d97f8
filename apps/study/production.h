// The library's own culler and brute force, as methods of the study. Both use one thread.
#pragma once

#include <memory>
#include <span>

#include "sightline/apps/study/method.h"
#include "sightline/core/aabb.h"

namespace sightline::study {

/// `list_ids`: also write every visible box's index while the clock runs; otherwise ranges.
std::unique_ptr<Method> make_production(std::span<const core::Aabb> boxes, bool list_ids = false);

/// The baseline of sightline-bench cull.
std::unique_ptr<Method> make_brute_force(std::span<const core::Aabb> boxes);

}  // namespace sightline::study
