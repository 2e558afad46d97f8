// The triangles of meshes that may colour an image, picked on the CPU for one image. A software rasteriser takes some
// hundred nanoseconds for a triangle whether it shows or not, and the test some ten.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/thread_pool.h"
#include "sightline/culling/occlusion/internal/triangle_test.h"
#include "sightline/gpuscene/internal/mesh_pool.h"

namespace sightline::gpuscene {

/// Keeps its memory from image to image.
class TriangleStream {
 public:
  void clear();
  /// Some triangles of an item's mesh; `indices` are borrowed until test(). `command` draws the whole mesh.
  void add(core::Slot slot, std::span<const std::uint32_t> indices, const ElementsCommand& command, bool fronts_alone);
  /// Tests what was added, on any of the threads; null: on this one.
  void test(const core::Snapshot& snapshot, const culling::TriangleTest& test, core::ThreadPool* threads);

  /// Number of indices that are left. A multiple of three.
  std::size_t size() const { return size_; }
  /// Calls append(command, whether only front faces are drawn) for what draws them, in the order of add(): indices
  /// lie from `first` on.
  template <class Append>
  void for_each_command(std::uint32_t first, const Append& append) const {
    for (std::size_t i = 0, next; i < parts_.size(); i = next) {
      ElementsCommand command = parts_[i].command;
      command.first_index = first;
      command.count = 0;
      for (next = i; next < parts_.size() && parts_[next].continues(parts_[i]); ++next)
        command.count += parts_[next].shown;
      first += command.count;
      if (command.count > 0) append(command, parts_[i].fronts_alone);
    }
  }
  /// Calls write(indices, first place) for runs of indices.
  template <class Write>
  void for_each_run(const Write& write) const {
    std::size_t first = 0;
    for (std::size_t i = 0; i < job_count_; ++i) {
      write(std::span(jobs_[i].shown).first(jobs_[i].count), first);
      first += jobs_[i].count;
    }
  }

 private:
  struct Part {
    core::Slot slot;
    std::uint32_t shown;  // indices
    std::span<const std::uint32_t> indices;
    ElementsCommand command;
    bool fronts_alone;

    bool continues(const Part& other) const { return slot == other.slot && fronts_alone == other.fronts_alone; }
  };
  struct Job {
    std::size_t first_part, end_part;
    std::vector<std::uint32_t> shown;  // the first `count`
    std::size_t count;
  };
  void divide();
  void run(Job& job, const core::Snapshot& snapshot, const culling::TriangleTest& test);

  std::vector<Part> parts_;
  std::vector<Job> jobs_;  // the first job_count_ of them; the others keep memory
  std::size_t job_count_ = 0, size_ = 0;
};

}  // namespace sightline::gpuscene
