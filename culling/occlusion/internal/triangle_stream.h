// The triangles of meshes that may colour an image, picked on the CPU for one image. A software rasteriser takes some
// hundred nanoseconds for a triangle whether it shows or not, and the test some ten. Internal to culling and engine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/thread_pool.h"
#include "sightline/culling/occlusion/internal/triangle_test.h"

namespace sightline::culling {

/// Keeps its memory from image to image.
class TriangleStream {
 public:
  /// Some triangles of an item's mesh.
  struct Part {
    core::Slot slot;
    std::uint32_t tag;                       ///< comes back with what is left of them
    std::span<const std::uint32_t> indices;  ///< borrowed until test()
    bool fronts_alone;
    std::uint32_t shown = 0;  ///< indices, which test() sets

    bool continues(const Part& other) const { return slot == other.slot && fronts_alone == other.fronts_alone; }
  };

  void clear();
  void add(std::span<const Part> parts);
  /// Tests what was added, on any of the threads; null: on this one.
  void test(const core::Snapshot& snapshot, const TriangleTest& test, core::ThreadPool* threads);

  /// Calls visit(tag, first, count, whether only front faces are drawn) for the indices that are left, in the order of
  /// add(). They count in the runs of list_runs().
  template <class Visit>
  void for_each(const Visit& visit) const {
    std::uint32_t first = 0;
    for (std::size_t i = 0, next; i < parts_.size(); i = next) {
      std::uint32_t count = 0;
      for (next = i; next < parts_.size() && parts_[next].continues(parts_[i]); ++next) count += parts_[next].shown;
      if (count > 0) visit(parts_[i].tag, first, count, parts_[i].fronts_alone);
      first += count;
    }
  }
  /// Adds the indices that are left, in runs; valid until clear().
  void list_runs(std::vector<std::span<const std::uint32_t>>& runs) const {
    for (std::size_t i = 0; i < job_count_; ++i)
      if (jobs_[i].count > 0) runs.push_back(std::span(jobs_[i].shown).first(jobs_[i].count));
  }

 private:
  struct Job {
    std::size_t first_part, end_part;
    std::vector<std::uint32_t> shown;  // the first `count`
    std::size_t count;
  };
  void divide();
  void run(Job& job, const core::Snapshot& snapshot, const TriangleTest& test);

  std::vector<Part> parts_;
  std::vector<Job> jobs_;  // the first job_count_ of them; the others keep memory
  std::size_t job_count_ = 0;
};

}  // namespace sightline::culling
