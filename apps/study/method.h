// A culler, whatever it is: a variant, production, brute force. Same boxes, same views, same questions.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"

namespace sightline::study {

class Method {
 public:
  Method() = default;
  virtual ~Method() = default;
  Method(const Method&) = delete;
  Method& operator=(const Method&) = delete;

  /// Culls; the clock runs during this call alone. The answer stands until the next call.
  virtual void cull(const core::View& view) = 0;
  virtual std::uint64_t count() const = 0;
  /// Indices of the visible boxes, sorted.
  virtual std::vector<std::uint32_t> ids() const = 0;
  virtual core::CullCounters counters() const { return {}; }
  /// Hierarchy and boxes; 0: not known.
  virtual std::size_t memory_bytes() const { return 0; }
};

}  // namespace sightline::study
