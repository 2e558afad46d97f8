#include "sightline/culling/gpu/internal/gpu_culler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/core/internal/radix_sort.h"
#include "sightline/core/internal/snapshot_prefetch.h"
#include "sightline/core/internal/store.h"
#include "sightline/culling/gpu/internal/gpu_band.h"
#include "sightline/culling/gpu/internal/gpu_pass.h"
#include "sightline/culling/gpu/internal/gpu_screen.h"
#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::culling {
namespace {

using core::dvec3;
using core::Slot;
using core::Snapshot;
using gpuscene::Batch;
using gpuscene::BatchKind;

constexpr GLuint kPlaneBinding = 1, kScreenBinding = 2, kOcclusionBinding = 3;

/// CullBlock of cull_test.glsl (std140).
struct PlaneBlock {
  struct Row {
    float normal[3];
    float offset;
    float band;
    float unused[3];
  };
  Row planes[kMaxCullPlanes];
  std::int32_t union_first, plane_count;
  std::uint32_t layers, use_layers;
  float w[4];
  float error_per_w, nearest_w;
  std::int32_t frustum_planes, section_count;
  float sections[kMaxSections][4];
};
static_assert(sizeof(PlaneBlock) == 32 * kMaxCullPlanes + 48 + 16 * kMaxSections);

constexpr double kInwards = 1.0 - 1e-6;  // for the rounding of the few products with it

/// Tells parts of meshes how large an error the image may show. Planes may have any length, which floats have not.
void set_error(PlaneBlock& block, const lod::ImageError& error, const dvec3& origin) {
  const lod::MeshError of_world(error, core::translation(origin));
  for (int i = 0; i < 4; ++i) block.w[i] = float(of_world.w()[i]);
  block.error_per_w = core::round_down(kInwards * of_world.error_per_w());
  block.nearest_w = core::round_down(of_world.nearest_w());
  for (const core::dvec4& section : of_world.sections()) {
    const double length = glm::length(dvec3(section));
    float* const to = block.sections[block.section_count++];
    for (int i = 0; i < 4; ++i) to[i] = float(length > 0.0 ? section[i] / length : section[i]);
  }
}

float rounded_up(double band) {
  return std::min(core::round_up(band), std::numeric_limits<float>::max());
}

}  // namespace

// --- data on the GPU -------------------------------------------------------------------------------------------------

GpuCuller::GpuCuller() = default;
GpuCuller::GpuCuller(GpuCuller&&) noexcept = default;
GpuCuller& GpuCuller::operator=(GpuCuller&&) noexcept = default;
GpuCuller::~GpuCuller() = default;

core::Expected<GpuCuller> GpuCuller::create(const gl::Context& context, const Snapshot& snapshot,
                                            const gpuscene::GpuScene& scene, const GpuCullerConfig& config) {
  const gl::Functions& gl = context.functions();
  GpuCuller culler;
  culler.gl_ = &gl;
  culler.writer_ = gpuscene::ElementWriter(context);
  auto block = gl::Buffer::create(gl, sizeof(PlaneBlock), nullptr, GL_DYNAMIC_STORAGE_BIT, "cull planes");
  if (!block) return tl::unexpected(block.error());
  culler.plane_block_ = std::move(*block);
  culler.probes_.resize(kProbes);
  const gl::Capabilities& has = context.capabilities();
  culler.vertex_storage_ = has.max_vertex_storage_blocks > 0;
  culler.most_mesh_commands_ =
      std::size_t(std::min(has.max_storage_block_bytes, has.max_texture_buffer_texels * std::int64_t(sizeof(GLuint)))) /
      sizeof(gpuscene::ElementsCommand) * 31 / 32;  // the rest is for other batches
  if (auto done = culler.make_batches(snapshot, scene); !done) return tl::unexpected(done.error());
  if (config.variant) {
    if (auto done = core::store(make_pass(*config.variant, context, culler.batches_), culler.pass_); !done)
      return tl::unexpected(done.error());
  } else if (auto done = culler.choose_variant(context, snapshot, scene); !done) {
    return tl::unexpected(done.error());
  }
  if (!context.capabilities().software) culler.timer_.emplace(gl);
  return culler;
}

GpuVariant GpuCuller::variant() const {
  return pass_->variant();
}

CullBatch* GpuCuller::mesh_batch() {
  const auto place = std::ranges::find_if(batches_, &CullBatch::meshes);
  return place == batches_.end() ? nullptr : &*place;
}

/// Null where there are none.
MeshParts* GpuCuller::parts() {
  const CullBatch* meshes = mesh_batch();
  return meshes ? meshes->parts.get() : nullptr;
}

core::Expected<void> GpuCuller::make_batches(const Snapshot& snapshot, const gpuscene::GpuScene& scene) {
  batches_.clear();
  pool_version_ = 0;
  for (const Batch& batch : scene.batches())
    if (auto done = add_batch(snapshot, scene, batch, gpuscene::GpuScene::slots_of(snapshot, batch.kind)); !done)
      return done;
  slot_count_ = Slot(snapshot.size());
  uses_layers_ = snapshot.bounds().uses_layers();
  return {};
}

core::Expected<void> GpuCuller::add_batch(const Snapshot& snapshot, const gpuscene::GpuScene& scene, const Batch& batch,
                                          std::vector<Slot> slots) {
  auto made = GpuBounds::create(*gl_, snapshot, batch, std::move(slots));
  if (!made) return tl::unexpected(made.error());
  CullBatch added{batch.kind, std::move(*made), {}, {}, {}, nullptr};
  if (added.meshes()) {
    std::vector<gpuscene::ElementsCommand>& commands = added.written;
    for (std::uint32_t record = 0; record < scene.meshes().records(); ++record)
      commands.push_back(scene.meshes().command(record));
    commands.resize(batch.capacity);
    const std::size_t bytes = commands.size() * sizeof(commands[0]);
    auto array = gl::TexelArray::create(*gl_, bytes, commands.data(), GL_R32UI, "commands of all meshes");
    if (auto done = core::store(std::move(array), added.commands); !done) return done;
  }
  batches_.push_back(std::move(added));
  return {};
}

core::Expected<void> GpuCuller::follow(const Snapshot& snapshot, const gpuscene::GpuScene& scene,
                                       std::span<const Slot> touched, SlotBits left_out, UpdateBounds update_bounds) {
  assert(scene.has_all(snapshot) && "GpuScene::append() comes first");
  if (snapshot.bounds().uses_layers() != uses_layers_) {
    if (auto done = make_batches(snapshot, scene); !done) return done;
    const std::vector<Slot> not_to_find = slots_of(left_out);
    return not_to_find.empty() ? core::Expected<void>() : update(snapshot, scene, not_to_find, left_out);
  }
  std::array<std::vector<std::uint32_t>, gpuscene::kBatchKindCount> changed;
  const auto batch_of = [&](Slot slot) { return std::size_t(gpuscene::batch_of(snapshot.kind(slot))); };
  for (std::size_t i = 0; i < touched.size(); ++i) {
    if (i + core::kPrefetchAhead < touched.size()) core::prefetch_slot(snapshot, touched[i + core::kPrefetchAhead]);
    changed[batch_of(touched[i])].push_back(gpuscene::GpuScene::record_of(snapshot, touched[i]));
  }
  std::array<CullBatch*, gpuscene::kBatchKindCount> by_kind{};
  for (CullBatch& batch : batches_) by_kind[std::size_t(batch.kind)] = &batch;
  for (; slot_count_ < snapshot.size(); ++slot_count_)
    changed[batch_of(slot_count_)].push_back(by_kind[batch_of(slot_count_)]->bounds.append(slot_count_));
  for (CullBatch& batch : batches_) {
    std::vector<std::uint32_t>& records = changed[std::size_t(batch.kind)];
    core::radix_sort(records);
    (batch.bounds.*update_bounds)(snapshot, records, writer_, left_out);
    if (!batch.meshes()) continue;
    if (batch.parts && update_bounds == &GpuBounds::update)
      if (auto done = batch.parts->update(*gl_, snapshot, scene.meshes(), records, batch.bounds.slots(), writer_);
          !done)
        return done;
    write_commands(batch, scene.meshes(), records);
  }
  return {};
}

/// Commands of records that are drawn by parts have no indices.
void GpuCuller::write_commands(CullBatch& batch, const gpuscene::MeshPool& pool,
                               std::span<const std::uint32_t> records) {
  std::vector<gpuscene::ElementsCommand> commands;
  for (const std::uint32_t record : records) {
    commands.push_back(pool.command(record));
    batch.written[record] = commands.back();
    if (batch.parts && batch.parts->has(record)) commands.back().count = 0;
  }
  writer_.write(batch.commands.buffer, sizeof(commands[0]), records, commands.data());
}

/// Takes in the levels and places that meshes have got since the last call.
core::Expected<void> GpuCuller::follow_levels(const Snapshot& snapshot, const gpuscene::GpuScene& scene) {
  const gpuscene::MeshPool& pool = scene.meshes();
  if (pool.version() == pool_version_) return {};
  CullBatch& batch = *mesh_batch();
  const std::size_t whole = std::min<std::size_t>(most_mesh_commands_, scene.batch(BatchKind::kMesh)->capacity);
  if (!batch.parts) batch.parts = std::make_unique<MeshParts>(most_mesh_commands_ - whole);
  std::vector<std::uint32_t> records;
  for (std::uint32_t record = 0; record < pool.records(); ++record)
    if (batch.written[record] != pool.command(record) || batch.parts->differs(pool, record)) records.push_back(record);
  auto done = batch.parts->update(*gl_, snapshot, pool, records, batch.bounds.slots(), writer_);
  if (!done) return done;
  write_commands(batch, pool, records);
  if (batch.parts->capacity() == 0) batch.parts = nullptr;
  pool_version_ = pool.version();
  return {};
}

std::size_t GpuCuller::memory_bytes() const {
  std::size_t bytes = plane_block_.size() + screen_block_.size() + occlusion_block_.size() + pass_->memory_bytes();
  if (pyramid_) bytes += pyramid_->memory_bytes();
  for (const CullBatch& batch : batches_) bytes += batch.memory_bytes();
  return bytes;
}

// --- culling ---------------------------------------------------------------------------------------------------------

core::Expected<void> GpuCuller::prepare(bool for_image, bool occlusion) {
  if (!for_image) return pass_->prepare(batches_, Selection::kAll);
  if (!occlusion) return pass_->prepare(batches_, Selection::kSampled);
  return prepare_occlusion();
}

/// Makes what the test of occlusion lacks: after batches_ were made anew or got parts, only some of it.
core::Expected<void> GpuCuller::prepare_occlusion() {
  for (const Selection selection : {Selection::kUnoccludedBefore, Selection::kUnoccludedNow})
    if (auto done = pass_->prepare(batches_, selection); !done) return done;
  if (!pyramid_) {
    if (auto done = core::store(GpuDepthPyramid::create(*gl_), pyramid_); !done) return done;
    if (timer_) others_timer_.emplace(*gl_);
  }
  const auto make_room = [&](gl::Buffer& frames, std::size_t clusters) -> core::Expected<void> {
    const std::size_t bytes = clusters * kItemsPerCluster * sizeof(std::uint32_t);
    if (frames.size() >= bytes) return {};
    auto made = core::store(gl::Buffer::create(*gl_, bytes, nullptr, 0, "last frames of open items"), frames);
    if (made) frames.fill(0, frames.size(), 0);
    return made;
  };
  core::Expected<void> done;
  for (CullBatch& batch : batches_) {
    if (done) done = make_room(batch.unoccluded_frames, batch.bounds.cluster_capacity());
    if (done && batch.parts) done = make_room(batch.parts->unoccluded_frames, batch.parts->cluster_capacity());
  }
  return done;
}

bool GpuCuller::can_test_occlusion() const {
  return vertex_storage_ || variant() == GpuVariant::kCompute;
}

core::Expected<void> GpuCuller::cull(const core::View& view, const Snapshot& snapshot, const gpuscene::GpuScene& scene,
                                     gpuscene::DrawLists& lists, const For& what) {
  const Image* const image = what.image;
  const bool sampled = image && image->samples.offsets.size() <= std::size_t(kMaxSamples);
  const bool occlusion = sampled && image->occlusion;
  auto done = follow_levels(snapshot, scene);
  if (done) done = prepare(sampled, occlusion);
  if (done && sampled) done = upload_image(*image, snapshot.bounds());
  if (done && occlusion) done = begin_occlusion();
  MeshParts* const of_meshes = parts();
  if (done) done = lists.begin_gpu_update(scene, pass_->counting(), of_meshes ? of_meshes->capacity() : 0);
  if (!done) return done;
  if (of_meshes) of_meshes->exempt = !view.sections.empty() || (image && !image->view.sections.empty());
  last_probe_ = next_probe(what.frame);
  Probe& probe = probes_[last_probe_];
  const CullPlanes planes(view, snapshot.bounds());
  // Without layers every item is on the model layer alone.
  probe.skipped = planes.nothing_visible() || (!uses_layers_ && (view.layers & core::kLayerModel) == 0);
  if (probe.skipped) {
    lists.clear();
    return {};
  }
  probe.timed = timer_ && last_probe_ != kTakenProbes && timer_->begin();
  upload_planes(view, planes, snapshot.bounds(), what.error);
  gl::reset_pipeline_state(*gl_);
  gl_->BindBufferBase(GL_UNIFORM_BUFFER, kPlaneBinding, plane_block_.id());
  pass_->run(batches_, lists,
             occlusion ? Selection::kUnoccludedBefore
             : sampled ? Selection::kSampled
                       : Selection::kAll,
             last_probe_);
  lists.end_gpu_update(scene);
  if (probe.timed) timer_->end();
  return {};
}

core::Expected<void> GpuCuller::cull_others(const Image& image, const gpuscene::GpuScene& scene,
                                            gpuscene::DrawLists& lists, const gl::Texture2D& depth, double error) {
  Probe& probe = probes_[last_probe_];
  if (probe.skipped) return {};  // the lists are still empty
  probe.others_timed = probe.timed && others_timer_->begin();
  const MeshParts* const of_meshes = parts();
  auto done = lists.begin_gpu_update(scene, pass_->counting(), of_meshes ? of_meshes->capacity() : 0);
  if (done) done = upload_pyramid(image, depth, error);
  if (done) {
    gl_->BindBufferBase(GL_UNIFORM_BUFFER, kPlaneBinding, plane_block_.id());
    gl_->BindBufferBase(GL_UNIFORM_BUFFER, kScreenBinding, screen_block_.id());
    gl_->BindTextureUnit(kPyramidUnit, pyramid_->texels().id());
    pass_->run(batches_, lists, Selection::kUnoccludedNow, last_probe_);
    lists.end_gpu_update(scene);
  }
  if (probe.others_timed) others_timer_->end();
  if (!done) lists.clear();
  return done;
}

core::Expected<void> GpuCuller::begin_occlusion() {
  OcclusionBlock block{};
  block.this_frame = ++occlusion_frame_;
  return write_block(occlusion_block_, sizeof block, &block, kOcclusionBinding);
}

core::Expected<void> GpuCuller::upload_pyramid(const Image& image, const gl::Texture2D& depth, double error) {
  assert(depth.width() == image.samples.width && depth.height() == image.samples.height);
  if (auto done = pyramid_->build(depth, image.view); !done) return done;
  OcclusionBlock block{};
  const auto levels = pyramid_->levels();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    block.levels[i][0] = std::uint32_t(levels[i].first);
    block.levels[i][1] = std::uint32_t(levels[i].width);
  }
  block.level_count = std::int32_t(levels.size());
  block.error = core::round_up(error);
  block.this_frame = occlusion_frame_;
  return write_block(occlusion_block_, sizeof block, &block, kOcclusionBinding);
}

void GpuCuller::upload_planes(const core::View& view, const CullPlanes& planes, const core::ItemBounds& bounds,
                              const lod::ImageError* error) const {
  PlaneBlock block{};
  for (int i = 0; i < planes.plane_count(); ++i) {
    const FloatPlane& plane = planes.planes()[i];
    block.planes[i] = {{plane.normal[0], plane.normal[1], plane.normal[2]},
                       plane.offset,
                       rounded_up(gpu_band(plane.band, bounds)),
                       {}};
  }
  block.union_first = planes.union_first();
  block.plane_count = planes.plane_count();
  block.layers = view.layers;
  block.use_layers = uses_layers_ ? 1 : 0;
  core::View without_sections = view;
  without_sections.sections.clear();
  block.frustum_planes = CullPlanes(without_sections, bounds).plane_count();
  if (error) set_error(block, *error, bounds.origin);
  plane_block_.write(0, sizeof block, &block);
}

core::Expected<void> GpuCuller::upload_image(const Image& image, const core::ItemBounds& bounds) {
  const ScreenBlock block = make_screen_block(image.view, bounds, image.samples);
  return write_block(screen_block_, sizeof block, &block, kScreenBinding);
}

/// Makes the buffer of a uniform block unless it is made, fills and binds it.
core::Expected<void> GpuCuller::write_block(gl::Buffer& block, std::size_t bytes, const void* data,
                                            GLuint binding) const {
  if (block.id() == 0) {
    auto made = gl::Buffer::create(*gl_, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT, "culled image");
    if (auto done = core::store(std::move(made), block); !done) return done;
  }
  block.write(0, bytes, data);
  gl_->BindBufferBase(GL_UNIFORM_BUFFER, binding, block.id());
  return {};
}

// --- feedback --------------------------------------------------------------------------------------------------------

std::size_t GpuCuller::next_probe(std::uint64_t frame) {
  std::size_t place = kTakenProbes;
  if (pending_ < kTakenProbes) place = (first_probe_ + pending_++) % kTakenProbes;
  probes_[place] = {};
  probes_[place].frame = frame;
  return place;
}

std::optional<GpuCuller::Feedback> GpuCuller::take_feedback() {
  if (pending_ == 0) return std::nullopt;
  Probe& probe = probes_[first_probe_];
  Feedback feedback{probe.frame, 0, 0, std::nullopt};
  if (!probe.skipped) {
    const auto found = pass_->found(first_probe_);
    if (!found) return std::nullopt;
    feedback.visible = found->in_view;
    feedback.items_drawn = found->written;
    const auto unknown = [](bool timed, std::optional<double>& time_ms, std::optional<gl::GpuTimer>& timer) {
      return timed && !time_ms && !(time_ms = timer->poll());
    };
    if (unknown(probe.timed, probe.time_ms, timer_)) return std::nullopt;
    if (unknown(probe.others_timed, probe.others_time_ms, others_timer_)) return std::nullopt;
    const double others = probe.others_time_ms.value_or(0.0);
    if (probe.timed && *probe.time_ms >= 0.0 && others >= 0.0) feedback.time_ms = *probe.time_ms + others;
  }
  first_probe_ = (first_probe_ + 1) % kTakenProbes;
  --pending_;
  return feedback;
}

core::VisibleSet GpuCuller::read_back(const gpuscene::DrawLists& lists) const {
  core::VisibleSet set;
  for (const CullBatch& batch : batches_) {
    if (lists.section(batch.kind).count == 0) continue;
    const gpuscene::DrawLists::Target target = lists.target(batch.kind);
    std::uint32_t count = 0;
    lists.counts().read(gpuscene::DrawLists::record_count_offset(batch.kind), sizeof count, &count);
    const std::size_t words = batch.meshes() ? sizeof(gpuscene::ElementsCommand) / sizeof(std::uint32_t) : 1;
    std::vector<std::uint32_t> found(count * words);
    gl_->GetNamedBufferSubData(target.buffer, GLintptr(target.offset), GLsizeiptr(found.size() * sizeof(found[0])),
                               found.data());
    for (std::size_t i = 0; i < count; ++i)
      set.single_slots.push_back(
          batch.bounds.slots()[found[(i + 1) * words - 1]]);  // a mesh's base instance is its record
  }
  std::sort(set.single_slots.begin(), set.single_slots.end());
  return set;
}

}  // namespace sightline::culling
