#include "sightline/culling/occlusion/internal/triangle_stream.h"

#include <algorithm>

#include "sightline/core/thread_pool.h"

namespace sightline::culling {
namespace {

constexpr std::size_t kIndicesOfJob = 3 * 8192;

}  // namespace

void TriangleStream::clear() {
  parts_.clear();
  job_count_ = 0;
}

/// In pieces that are not more than a job.
void TriangleStream::add(std::span<const Part> parts) {
  for (Part part : parts)
    for (std::span rest = part.indices; !rest.empty(); rest = rest.subspan(part.indices.size())) {
      part.indices = rest.first(std::min(rest.size(), kIndicesOfJob));
      parts_.push_back(part);
    }
}

void TriangleStream::divide() {
  std::size_t indices = kIndicesOfJob;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (indices + parts_[i].indices.size() > kIndicesOfJob) {
      if (job_count_ == jobs_.size()) jobs_.emplace_back();
      jobs_[job_count_++].first_part = i;
      indices = 0;
    }
    indices += parts_[i].indices.size();
    jobs_[job_count_ - 1].end_part = i + 1;
  }
}

void TriangleStream::test(const core::Snapshot& snapshot, const TriangleTest& test, core::ThreadPool* threads) {
  divide();
  core::ThreadPool::run_on(threads, std::uint32_t(job_count_), [&](std::uint32_t i) { run(jobs_[i], snapshot, test); });
}

void TriangleStream::run(Job& job, const core::Snapshot& snapshot, const TriangleTest& test) {
  job.shown.resize(std::max(job.shown.size(), kIndicesOfJob));
  job.count = 0;
  TriangleView view{};
  for (std::size_t i = job.first_part; i < job.end_part; ++i) {
    Part& part = parts_[i];
    if (i == job.first_part || !part.continues(parts_[i - 1]))
      view = test.of(snapshot.world_from_item(part.slot), part.fronts_alone);
    const std::size_t shown =
        TriangleTest::filter(view, snapshot.mesh(part.slot).positions, part.indices, job.shown.data() + job.count);
    part.shown = std::uint32_t(shown);
    job.count += shown;
  }
}

}  // namespace sightline::culling
