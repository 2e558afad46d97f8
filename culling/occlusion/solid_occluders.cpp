#include "sightline/culling/occlusion/solid_occluders.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "sightline/core/internal/scratch.h"
#include "sightline/core/internal/snapshot_prefetch.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/occlusion/internal/inner_occluders.h"
#include "sightline/culling/occlusion/internal/object_pool.h"

namespace sightline::culling {
namespace {

constexpr std::uint32_t kItemsOfPart = 512;  // for a thread
constexpr std::size_t kSolidsAtOnce = 64;

/// Replaces `slots` by those of the set.
void list(const core::VisibleSet& set, std::vector<core::Slot>& slots) {
  slots.clear();
  set.for_each_slot([&](core::Slot slot) { slots.push_back(slot); });
}

struct AddedParts {
  SetParts parts;
  std::size_t memory_bytes() const { return core::bytes_of(parts); }
};

struct SlotBuffers {
  std::vector<core::Slot> slots;
  std::size_t memory_bytes() const { return core::bytes_of(slots); }
};

}  // namespace

/// What a snapshot knows of an item.
struct SolidOccluders::Solid {
  std::size_t place;  // among the slots
  core::Kind kind;
  core::Aabb box;
  const core::Placement* placement;
  const float* parameters;
};

struct SolidOccluders::AddBuffers {
  std::vector<Solid> solids;
  std::vector<WholeSolid> wholes;
  std::vector<OccluderPolygon> polygons;

  std::size_t memory_bytes() const { return core::bytes_of(solids, wholes, polygons); }
};

struct SolidOccluders::HiddenBuffers {
  std::vector<core::Slot> slots;
  std::vector<Solid> solids;
  std::vector<OccluderPolygon> fronts;
  std::vector<std::size_t> ends;  // of each solid's fronts; some have none
  std::vector<std::uint8_t> seen, hidden;

  std::size_t memory_bytes() const { return core::bytes_of(slots, solids, fronts, ends, seen, hidden); }
};

SolidOccluders::SolidOccluders() : of_threads_(std::make_unique<ObjectPool<OccluderRaster>>()) {}
SolidOccluders::~SolidOccluders() = default;

void SolidOccluders::begin(const core::Snapshot& snapshot, const core::View& view, int width, int height, float snap) {
  snapshot_ = &snapshot;
  width_ = width, height_ = height;
  eye_ = view.eye();
  perspective_ = !view.orthographic();
  const core::dmat4 world_from_eye = glm::transpose(view.eye_from_world());
  forward_ = -core::dvec3(world_from_eye[2]);
  empty_.begin(view, width, height, float(kLostPixels + std::max(0.0, double(snap) - kProxyMargin)));
  of_threads_->begin();
}

void SolidOccluders::add(const core::VisibleSet& items, core::ThreadPool* threads) {
  const core::Scratch<AddedParts> scratch;
  SetParts& parts = scratch->parts;
  parts.split(items, kItemsOfPart);
  parts.for_each(threads, [&](const core::VisibleSet& part, std::uint32_t) {
    const core::Scratch<SlotBuffers> of_thread;
    list(part, of_thread->slots);
    OccluderRaster& raster = of_threads_->take([&](OccluderRaster& fresh) { fresh = empty_; });
    add(of_thread->slots, raster);
    of_threads_->give_back(raster);
  });
}

/// Items lie all over arrays of hundreds of megabytes, so they are prefetched.
void SolidOccluders::add(std::span<const core::Slot> slots, OccluderRaster& raster) const {
  const core::Scratch<AddBuffers> scratch;
  auto& [solids, wholes, polygons] = *scratch;
  while (!slots.empty()) {
    const auto some = slots.first(std::min(kSolidsAtOnce, slots.size()));
    slots = slots.subspan(some.size());
    look_up(some, solids);
    wholes.clear();
    polygons.clear();
    for (const Solid& solid : solids) wholes.push_back(find_inner_occluders(solid, polygons));
    raster.add_within(wholes, polygons);
  }
}

/// Replaces `solids` by those of the slots that hold opaque ones.
void SolidOccluders::look_up(std::span<const core::Slot> slots, std::vector<Solid>& solids) const {
  solids.clear();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (i + core::kPrefetchAhead < slots.size()) {
      core::prefetch_slot(*snapshot_, slots[i + core::kPrefetchAhead]);
      core::prefetch_box(*snapshot_, slots[i + core::kPrefetchAhead]);
    }
    const core::Slot slot = slots[i];
    const core::Kind kind = snapshot_->kind(slot);
    if (int(kind) >= core::kPrimitiveKindCount || snapshot_->bounds().vacant(slot) || !snapshot_->opaque(slot))
      continue;
    core::prefetch_record(*snapshot_, slot);
    const core::KindItems& items = snapshot_->of_kind(kind);
    const std::uint32_t index = snapshot_->index_in_kind(slot);
    solids.push_back({i, kind, snapshot_->bounds().box(slot), &items.placements[index],
                      items.parameters.data() + index * std::size_t(core::parameter_count(kind))});
  }
}

SolidOccluders::Placed SolidOccluders::place(const Solid& solid) const {
  const core::dvec3 to_eye = snapshot_->bounds().origin - eye_;
  const core::AabbD box{to_eye + core::dvec3(solid.box.min), to_eye + core::dvec3(solid.box.max)};
  const core::Placement& placement = *solid.placement;
  const core::dvec3 origin = (snapshot_->chunk_origins()[placement.chunk] - eye_) + core::dvec3(placement.origin);
  return {{core::dmat3(placement.linear), origin}, box, glm::length(box.size())};
}

WholeSolid SolidOccluders::find_inner_occluders(const Solid& solid, std::vector<OccluderPolygon>& polygons) const {
  const Placed placed = place(solid);
  // A neighbour that covers an end must be there, too: what is cut off in a joint leaves the solid open.
  const core::dvec3 joint(kLostOfRadius * placed.size);
  const std::size_t before = polygons.size();
  add_inner_occluders(solid.kind, solid.parameters, placed.eye_from_item, {perspective_, forward_}, kLostOfRadius,
                      kLostOfBox * placed.size, polygons);
  return {{placed.box.min - joint, placed.box.max + joint}, std::uint32_t(polygons.size() - before)};
}

void SolidOccluders::leave_out_occluded(core::VisibleSet& items, const DepthPyramid& pyramid, double error) const {
  const core::Scratch<HiddenBuffers> scratch;
  auto& [slots, solids, fronts, ends, seen, hidden] = *scratch;
  list(items, slots);
  look_up(slots, solids);
  fronts.clear();
  ends.clear();
  for (const Solid& solid : solids) {
    const Placed placed = place(solid);
    const std::size_t before = fronts.size();
    if (!add_fronts(solid.kind, solid.parameters, placed.eye_from_item, {perspective_, forward_}, kLostOfRadius,
                    kLostOfBox * placed.size, fronts))
      fronts.resize(before);
    ends.push_back(fronts.size());
  }
  empty_.find_seen(fronts, pyramid, error, seen);
  hidden.assign(slots.size(), 0);
  auto front = seen.begin();
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const auto end = seen.begin() + std::ptrdiff_t(ends[i]);
    hidden[solids[i].place] = front != end && std::find(front, end, 1) == end;
    front = end;
  }
  items.ranges.clear();
  items.single_slots.clear();
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (hidden[i] == 0) items.single_slots.push_back(slots[i]);
}

void SolidOccluders::build(DepthPyramid& pyramid, std::span<const float> drawn, core::ThreadPool* threads) {
  rasters_.clear();
  for (const auto& raster : of_threads_->used()) rasters_.push_back(raster.get());
  if (rasters_.empty()) rasters_.push_back(&empty_);
  const std::span<float> distances = pyramid.begin(width_, height_);
  assert(drawn.empty() || drawn.size() == distances.size());
  core::ThreadPool::run_on(threads, std::uint32_t(pyramid.band_count()), [&](std::uint32_t band) {
    const int first = int(band) * DepthPyramid::kBandRows, end = std::min(height_, first + DepthPyramid::kBandRows);
    rasters_[0]->distances_of_rows(first, end, distances, std::span(rasters_).subspan(1));
    if (!drawn.empty())
      for (std::size_t i = std::size_t(first) * std::size_t(width_); i < std::size_t(end) * std::size_t(width_); ++i)
        distances[i] = std::min(distances[i], drawn[i]);
    pyramid.finish_band(int(band));
  });
  pyramid.finish_above();
}

}  // namespace sightline::culling
