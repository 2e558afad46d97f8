// What functions of box cullers share: boxes where they lie, and lists of the visible ones.
#pragma once

#include <span>
#include <vector>

#include "sightline/bindings/c/internal/objects.h"
#include "sightline/bindings/c/internal/values.h"
#include "sightline/core/internal/scratch.h"

namespace sightline::capi {

static_assert(sizeof(sl_box) == sizeof(core::AabbD) && offsetof(sl_box, max) == offsetof(core::AabbD, max));

/// The boxes where they lie: six doubles in both languages.
inline std::span<const core::AabbD> boxes_of(const sl_box* boxes, std::size_t count) {
  check_array(boxes, count, core::kNone / 2 - 1);
  return {reinterpret_cast<const core::AabbD*>(boxes), count};
}

struct ListBuffers {
  std::vector<std::uint32_t> indices;
  std::size_t memory_bytes() const { return core::bytes_of(indices); }
};

/// Runs `cull` with the culler and a list of indices, and writes that.
template <class Cull>
sl_status list_visible(const char* function, sl_box_culler handle, std::uint32_t* indices, std::size_t capacity,
                       std::size_t* count, const Cull& cull) {
  return call(function, [&] {
    check_buffer(indices, capacity);
    check_result(count);
    const std::shared_ptr<BoxCullerObject> object = find(handle);
    const core::Scratch<ListBuffers> scratch;
    cull(object->culler, scratch->indices);
    write_list(scratch->indices, indices, capacity, count);
  });
}

}  // namespace sightline::capi
