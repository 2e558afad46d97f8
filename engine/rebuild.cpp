#include "sightline/engine/internal/rebuild.h"

#include <algorithm>
#include <utility>

#include "sightline/core/internal/sort_unique.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/engine/internal/picking.h"

namespace sightline::engine {
namespace {

constexpr std::size_t kCopiedPiece = 2048;  // slots copied at a time, while edits wait

/// Items whose slots lie outside a part. Parts are made of whole blocks, so that cullers find the same ranges of slots
/// in a part as in the whole.
std::vector<core::ItemId> items_outside(const core::Snapshot& snapshot, const ScenePart& part) {
  const std::size_t blocks = (snapshot.size() + core::kBlockSlots - 1) / core::kBlockSlots;
  const auto begin_of = [&](int index) {
    return std::min(snapshot.size(), blocks * std::size_t(index) / std::size_t(part.count) * core::kBlockSlots);
  };
  const std::size_t first = begin_of(part.index), end = begin_of(part.index + 1);
  std::vector<core::ItemId> items;
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot)
    if ((slot < first || slot >= end) && snapshot.item(slot) != core::kNoItem) items.push_back(snapshot.item(slot));
  return items;
}

}  // namespace

std::vector<std::uint64_t> slots_of_lines(const core::Snapshot& snapshot) {
  std::vector<std::uint64_t> bits;
  const core::KindItems& lines = snapshot.of_kind(core::Kind::kLine);
  if (lines.size() > 0) bits.resize(culling::bit_words(snapshot.size()));
  for (const core::Slot slot : lines.members)
    if (!snapshot.vacant(slot)) bits[slot / 64] |= std::uint64_t(1) << slot % 64;
  return bits;
}

void SceneVersion::follow(std::initializer_list<std::span<const core::ItemId>> edited, bool materials,
                          std::size_t former_size, std::vector<core::Slot>& touched) {
  joints.dissolve(*snapshot, edited, former_size, touched);
  if (materials) joints.dissolve_transparent(*snapshot, former_size, touched);
  follow_boxes(former_size, touched);
}

void SceneVersion::follow_overrides(std::span<const core::ItemId> uncovered, bool boxes,
                                    std::vector<core::Slot>& touched) {
  joints.dissolve(*snapshot, {uncovered}, snapshot->size(), touched);
  if (boxes) follow_boxes(snapshot->size(), touched);
}

void SceneVersion::follow_boxes(std::size_t former_size, std::span<const core::Slot> touched) {
  const auto is_line = [&](core::Slot slot) { return snapshot->kind(slot) == core::Kind::kLine; };
  bool lines_edited = std::any_of(touched.begin(), touched.end(), is_line);
  for (core::Slot slot = core::Slot(former_size); slot < snapshot->size(); ++slot) lines_edited |= is_line(slot);
  if (lines_edited) lines = slots_of_lines(*snapshot);
  if (auto* cpu = std::get_if<culling::CpuCuller>(culler.get())) cpu->update(touched);
  follow_tracer(*this, touched);
}

void SceneVersion::follow_plan(const PlanRequest& request) {
  plan = make_plan(*snapshot, joints, request);
  const bool has_tree = culler && std::holds_alternative<culling::CpuCuller>(*culler);
  if (plan.has_tree() && !has_tree)
    culler = std::make_unique<Culler>(std::in_place_type<culling::CpuCuller>, snapshot->bounds());
  else if (!culler || (has_tree && plan.culler == CullerChoice::kLinear))  // costs nothing beside a GPU culler
    culler = std::make_unique<Culler>(std::in_place_type<culling::LinearCuller>, snapshot->bounds());
}

SceneVersion make_version(std::unique_ptr<core::Snapshot> snapshot, const PlanRequest& request,
                          const std::stop_token& stop) {
  SceneVersion version;
  version.snapshot = std::move(snapshot);
  if (request.draws_by_gl()) version.joints = gpuprims::Joints(*version.snapshot);
  if (request.part.count > 1) {  // ends that another part covers stay as they are in the whole
    core::ItemCopies others;
    others.removed = items_outside(*version.snapshot, request.part);
    core::apply_copies(*version.snapshot, others);
  }
  version.lines = slots_of_lines(*version.snapshot);
  version.follow_plan(request);
  if (request.pick) (void)make_tracer(version, stop);  // where that fails, the next pick says why
  return version;
}

std::vector<core::Slot> catch_up(SceneVersion& version, std::span<const core::ItemId> edited,
                                 const core::ItemCopies& copies) {
  const std::size_t former_size = version.snapshot->size();
  std::vector<core::Slot> touched = core::apply_copies(*version.snapshot, copies);
  version.follow({edited}, true, former_size, touched);
  return touched;
}

BackgroundRebuild::BackgroundRebuild(const core::Snapshot& live, const PlanRequest& request)
    : live_(&live), thread_([this, request](const std::stop_token& stop) { run(stop, request); }) {}

void BackgroundRebuild::edit(const core::SceneDelta& delta, const std::function<void()>& apply) {
  editing_ = true;  // makes the other thread wait before its next piece
  {
    const std::lock_guard held(mutex_);
    apply();
    if (state_ != State::kTaken && state_ != State::kRetired) {
      behind_ = true;
      for (const auto* list : {&delta.removed, &delta.changed, &delta.inserted})
        missed_.insert(missed_.end(), list->begin(), list->end());
      removed_.insert(removed_.end(), delta.removed.begin(), delta.removed.end());
    }
    editing_ = false;
  }
  changed_.notify_one();
}

bool BackgroundRebuild::take(SceneVersion& out) {
  const std::unique_lock<std::mutex> held(mutex_, std::try_to_lock);
  if (!held.owns_lock() || state_ != State::kReady || behind_) return false;
  out = std::exchange(version_, {});
  state_ = State::kTaken;
  return true;
}

void BackgroundRebuild::retire(SceneVersion&& old) {
  {
    const std::lock_guard held(mutex_);
    version_ = std::move(old);
    state_ = State::kRetired;
  }
  changed_.notify_one();
}

bool BackgroundRebuild::lock(std::unique_lock<std::mutex>& held, const std::stop_token& stop) {
  held.lock();
  return core::wait_until(changed_, held, stop, [&] { return !editing_; }) && !stop.stop_requested();
}

/// Meets every item at least once, since items only move to later slots. Growing the memory takes long, so it happens
/// while nobody waits.
bool BackgroundRebuild::copy_all(const std::stop_token& stop, core::ItemCopies& items) {
  core::ItemCopies piece;
  for (std::size_t next = 0, end = 1; next < end;) {
    piece.records.clear();
    piece.parameters.clear();
    {
      std::unique_lock<std::mutex> held(mutex_, std::defer_lock);
      if (!lock(held, stop)) return false;
      end = live_->size();
      const std::size_t count = std::min(kCopiedPiece, end - next);
      core::copy_items(*live_, core::Slot(next), core::Slot(next + count), piece);
      next += count;
    }
    items.append(piece);
  }
  return true;
}

bool BackgroundRebuild::copy_missed(const std::stop_token& stop, std::span<const core::ItemId> missed,
                                    core::ItemCopies& items) {
  std::size_t next = 0;
  do {  // once even without items: it also copies the materials
    std::unique_lock<std::mutex> held(mutex_, std::defer_lock);
    if (!lock(held, stop)) return false;
    const std::size_t count = std::min(kCopiedPiece, missed.size() - next);
    core::copy_items(*live_, missed.subspan(next, count), items);
    next += count;
  } while (next < missed.size());
  return true;
}

void BackgroundRebuild::run(const std::stop_token& stop, const PlanRequest& request) {
  core::ItemCopies items;
  if (!copy_all(stop, items)) return;
  constexpr int kThreads = 1;  // the others are the application's
  SceneVersion version = make_version(
      std::make_unique<core::Snapshot>(core::reordered(*live_, std::move(items), kThreads)), request, stop);
  for (;;) {
    std::vector<core::ItemId> missed;
    core::ItemCopies late;
    {
      std::unique_lock<std::mutex> held(mutex_, std::defer_lock);
      if (!lock(held, stop)) return;
      if (!behind_) {
        std::swap(version, version_);
        state_ = State::kReady;
        const bool go_on = core::wait_until(changed_, held, stop, [&] {
          return state_ == State::kRetired || (state_ == State::kReady && behind_ && !editing_);
        });
        std::swap(version, version_);
        if (!go_on || state_ == State::kRetired) break;
        state_ = State::kWorking;
      }
      std::swap(missed, missed_);
      std::swap(late.removed, removed_);
      behind_ = false;
    }
    core::sort_unique(missed);
    if (!copy_missed(stop, missed, late)) return;
    catch_up(version, missed, late);
  }
  version = {};
  finished_ = true;
}

}  // namespace sightline::engine
