// The culling camera held still, while the image is taken from elsewhere.
#pragma once

#include <optional>
#include <vector>

#include "sightline/engine/engine.h"

namespace sightline::apps {

class FrozenCamera {
 public:
  explicit FrozenCamera(const core::View& view) : view_(view) {}

  const core::View& view() const { return view_; }
  /// What culling makes of the items in that view; null before follow().
  const culling::CullStates* states() const { return states_ ? &*states_ : nullptr; }
  /// Another one with each change of states(), and for each camera; 0 before the first.
  std::uint64_t version() const { return version_; }

  /// The next follow() finds out anew, for example after a change of settings.
  void forget() { states_.reset(); }
  /// Cuts with these sections, and finds out what culling makes of the items unless that is known: for these sections,
  /// and as of `shown`, which rises whenever other items are hidden or faint. The engine's image may be gone then.
  core::Expected<void> follow(engine::Engine& engine, const std::vector<core::Plane>& sections, std::uint64_t shown);

 private:
  core::View view_;
  std::optional<culling::CullStates> states_;
  std::uint64_t shown_ = 0, version_ = 0;
};

/// A line of an outline, world coordinates.
struct WorldLine {
  core::dvec3 from, to;
  enum class Part : std::uint8_t { kKept, kCut, kSection } part;
};
/// Outlines of a view's volume: its edges, of which sections cut parts away, and where sections cut it. Ends at
/// `bounds` where the far plane lies behind them. Sections must be combined by kIntersection.
std::vector<WorldLine> outline(const core::View& view, const core::AabbD& bounds);

}  // namespace sightline::apps
