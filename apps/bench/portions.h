// Part of sightline-bench edit: what single portions of commits take.
#pragma once

#include <cstddef>

#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

/// In a scene of so many cylinders, drawn: new meshes and items that come by commit(seconds) with a frame after each,
/// and levels that frames upload. Times are those of the calling thread alone, so that other programs do not count.
json::Value measure_portions(std::size_t items);

}  // namespace sightline::bench
