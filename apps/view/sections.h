// Section planes as the user moves them: each keeps one side of the model.
#pragma once

#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::apps {

class Sections {
 public:
  struct Section {
    core::dvec3 point, normal;  ///< normal: unit, out of what is kept
    double offset = 0.0;        ///< metres along the normal by which it was moved
    bool on = true;
  };
  static constexpr std::size_t kMost = core::kMaxSectionPlanes;

  /// Cuts away what lies in front of a face. False where there are as many as there may be.
  bool add(const core::dvec3& point, const core::dvec3& outwards);
  /// The six sides of a box, in place of all others. Must not be empty.
  void box(const core::AabbD& bounds);
  /// These planes, at most kMost, in place of all others. Those with a zero normal cut nothing, and are left out.
  void set(std::span<const core::Plane> planes);
  void clear() { sections_.clear(); }
  void remove(std::size_t index) { sections_.erase(sections_.begin() + std::ptrdiff_t(index)); }
  static void flip(Section& section);

  std::vector<Section>& all() { return sections_; }
  const std::vector<Section>& all() const { return sections_; }
  /// As View::sections has them.
  std::vector<core::Plane> planes() const;

 private:
  std::vector<Section> sections_;
};

}  // namespace sightline::apps
