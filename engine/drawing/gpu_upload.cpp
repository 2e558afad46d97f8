#include "sightline/engine/drawing/internal/gpu_upload.h"

#include <algorithm>
#include <utility>

#include "sightline/core/internal/sort_unique.h"
#include "sightline/core/internal/store.h"
#include "sightline/engine/internal/settings.h"

namespace sightline::engine {
namespace {

constexpr core::Slot kAppendedPiece = 64;    // slots at a time
constexpr std::size_t kTouchedPiece = 1024;  // slots at a time

}  // namespace

std::size_t GpuContent::memory_bytes() const {
  std::size_t bytes = 0;
  if (scene) bytes += scene->memory_bytes();
  if (lists) bytes += lists->memory_bytes();
  if (culler) bytes += culler->memory_bytes();
  return bytes;
}

void GpuUpload::abandon() {
  content_.reset();
  edits_ = {};
  came_ = 0;
}

void GpuUpload::follow_later(std::span<const core::Slot> touched, std::span<const std::uint32_t> materials) {
  edits_.touched.insert(edits_.touched.end(), touched.begin(), touched.end());
  came_ += touched.size();
  edits_.materials.insert(edits_.materials.end(), materials.begin(), materials.end());
}

GpuEdits GpuUpload::take_edits() {
  core::sort_unique(edits_.touched);
  core::sort_unique(edits_.materials);
  came_ = 0;
  return std::exchange(edits_, {});
}

GpuContent GpuUpload::take() {
  GpuContent content = std::move(*content_);
  content_.reset();
  return content;
}

/// The scene comes first, and then everything that was edited meanwhile.
core::Expected<bool> GpuUpload::advance(const DrawContext& context, GpuCulling& culling, const core::Snapshot& snapshot,
                                        const gpuprims::Joints& joints, bool gpu_culls, core::Deadline deadline) {
  if (!content_->scene) content_->scene = gpuscene::GpuScene::begin(context.context, snapshot);
  if (!uploaded_) {
    const auto done = content_->scene->advance(snapshot, joints, deadline);
    if (!done || !*done) return done;
    uploaded_ = true;
    slots_ = core::Slot(snapshot.size());
  }
  if (!content_->lists) {
    if (const auto done = follow_edits(snapshot, joints, deadline); !done || !*done) return done;
    if (auto done = complete(context, culling, snapshot, gpu_culls); !done) return tl::unexpected(done.error());
    if (core::over(deadline)) return false;
  }
  if (!context.config.draw || context.renderer) return true;
  if (!content_->renderer) {
    if (auto done = core::store(render::Renderer::begin(context.context), content_->renderer); !done)
      return tl::unexpected(done.error());
    give_looks(context.config.drawing.looks, *content_->renderer);
  }
  return content_->renderer->advance(*content_->scene, context.target().format(), deadline);
}

/// True once the scene has followed all edits since it was begun. Each call follows more edits than have come since the
/// last one, so that edits cannot keep the upload from ending.
core::Expected<bool> GpuUpload::follow_edits(const core::Snapshot& snapshot, const gpuprims::Joints& joints,
                                             core::Deadline deadline) {
  gpuscene::GpuScene& scene = *content_->scene;
  const auto slots = core::Slot(snapshot.size());
  core::Slot appended = 0, least = slots - std::exchange(slots_, slots) + kAppendedPiece;
  for (; !scene.has_all(snapshot); appended += kAppendedPiece) {
    if (appended >= least && core::over(deadline)) return false;
    if (auto done = scene.append(snapshot, joints, kAppendedPiece); !done) return done;
  }
  std::vector<core::Slot>& touched = edits_.touched;
  std::size_t followed = 0, least_touched = std::exchange(came_, 0) + kTouchedPiece;
  for (; !touched.empty(); followed += kTouchedPiece) {
    if (followed >= least_touched && core::over(deadline)) return false;
    const std::size_t count = std::min(touched.size(), kTouchedPiece);
    std::vector<core::Slot> piece(touched.end() - std::ptrdiff_t(count), touched.end());
    touched.resize(touched.size() - count);
    core::sort_unique(piece);
    scene.update(snapshot, piece, joints);
  }
  return scene.upload_meshes(deadline);
}

/// Creates what depends on a complete scene.
core::Expected<void> GpuUpload::complete(const DrawContext& context, GpuCulling& culling,
                                         const core::Snapshot& snapshot, bool gpu_culls) {
  const GpuEdits edits = take_edits();
  if (auto kept = content_->scene->update_materials(snapshot, edits.materials); !kept) return kept;
  if (auto done = core::store(gpuscene::DrawLists::create(context.context, *content_->scene), content_->lists); !done)
    return done;
  if (!gpu_culls) return {};
  return core::store(culling.make(context, snapshot, *content_->scene), content_->culler);
}

}  // namespace sightline::engine
