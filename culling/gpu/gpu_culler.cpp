#include "sightline/culling/gpu/gpu_culler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/culling/gpu/shaders.h"

namespace sightline::culling {
namespace {

using core::Slot;
using core::Snapshot;
using gpuscene::Batch;
using gpuscene::BatchKind;

enum TextureUnit : GLuint { kBoxUnit, kLayerUnit, kCommandUnit };
constexpr GLuint kPlaneBinding = 1;
constexpr GLint kUseLayersUniform = 0;
constexpr GLuint kClusterAttribute = 0, kClusterBufferBinding = 0;

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
  std::uint32_t layers, unused;
};
static_assert(sizeof(PlaneBlock) == 32 * kMaxCullPlanes + 16);

/// GLSL says that operations are correctly rounded, but not which way: an error of up to 2^-23 each where the CPU has
/// 2^-24, and may flush every denormal to zero: of the plane (times a coordinate), of a coordinate (times less than 1),
/// of three products and three sums, at most 2^-126 each.
float gpu_band(float band, const core::ItemBounds& bounds) {
  double sizes = 8.0;
  if (!bounds.extent().empty())
    for (int i = 0; i < 3; ++i)
      sizes += std::max(std::abs(double(bounds.extent().min[i])), std::abs(double(bounds.extent().max[i])));
  return std::min(core::round_up(2.0 * double(band) + 0x1p-126 * sizes), std::numeric_limits<float>::max());
}

core::Expected<gl::Program> make_pass(const gl::Functions& gl, const char* name, const char* vertex,
                                      const char* geometry, std::vector<std::string> varyings) {
  gl::ProgramDescription description;
  description.name = name;
  description.stages = {{GL_VERTEX_SHADER, {vertex}}, {GL_GEOMETRY_SHADER, {geometry}}};
  description.shaders.tables = {shaders()};
  description.feedback_varyings = std::move(varyings);
  return gl::Program::create(gl, description);
}

/// Slots of each batch's records.
std::array<std::vector<Slot>, gpuscene::kBatchKindCount> slots_by_batch(const Snapshot& snapshot) {
  std::array<std::vector<Slot>, gpuscene::kBatchKindCount> slots;
  for (Slot slot = 0; slot < snapshot.size(); ++slot)
    slots[std::size_t(gpuscene::batch_of(snapshot.kind(slot)))].push_back(slot);
  return slots;
}

}  // namespace

namespace detail {
void delete_query(const gl::Functions& gl, GLuint name) {
  gl.DeleteQueries(1, &name);
}
}  // namespace detail

// --- what lies on the GPU --------------------------------------------------------------------------------------------

core::Expected<GpuCuller> GpuCuller::create(const gl::Context& context, const Snapshot& snapshot,
                                            const gpuscene::GpuScene& scene) {
  const gl::Functions& gl = context.functions();
  GpuCuller culler;
  culler.gl_ = &gl;
  if (auto done = culler.make_programs(scene); !done) return tl::unexpected(done.error());
  auto block = gl::Buffer::create(gl, sizeof(PlaneBlock), nullptr, GL_DYNAMIC_STORAGE_BIT, "cull planes");
  if (!block) return tl::unexpected(block.error());
  culler.plane_block_ = std::move(*block);
  auto framebuffer = gl::Framebuffer::create_attachmentless(gl, 1, 1, "cull");
  if (!framebuffer) return tl::unexpected(framebuffer.error());
  culler.framebuffer_ = std::move(*framebuffer);
  culler.cluster_array_ = gl::VertexArray(gl);
  culler.item_array_ = gl::VertexArray(gl);
  const GLuint array = culler.item_array_.id();
  gl.EnableVertexArrayAttrib(array, kClusterAttribute);
  gl.VertexArrayAttribIFormat(array, kClusterAttribute, 1, GL_UNSIGNED_INT, 0);
  gl.VertexArrayAttribBinding(array, kClusterAttribute, kClusterBufferBinding);
  culler.item_feedback_ = gl::TransformFeedback(gl);
  culler.probes_.resize(kProbes + 1);
  for (Probe& probe : culler.probes_) {
    for (const Batch& batch : scene.batches()) {
      GLuint name = 0;
      gl.CreateQueries(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, 1, &name);
      probe.found[std::size_t(batch.kind)] = Query(gl, name);
    }
  }
  if (!context.capabilities().software) culler.timer_.emplace(gl);
  if (auto done = culler.make_bounds(snapshot, scene); !done) return tl::unexpected(done.error());
  return culler;
}

core::Expected<void> GpuCuller::make_programs(const gpuscene::GpuScene& scene) {
  const auto make = [&](gl::Program& out, auto&&... description) -> core::Expected<void> {
    auto program = make_pass(*gl_, description...);
    if (!program) return tl::unexpected(program.error());
    out = std::move(*program);
    return {};
  };
  const bool meshes = scene.batch(BatchKind::kMesh) != nullptr;
  const std::vector<std::string> names = {"found"}, commands = {"command", "base_instance"};
  core::Expected<void> done;
  if (!scene.batches().empty()) done = make(cluster_pass_, "cull clusters", "clusters.vert", "keep.geom", names);
  if (done && scene.batches().size() > (meshes ? 1u : 0u))
    done = make(item_pass_, "cull items", "items.vert", "keep.geom", names);
  if (done && meshes) done = make(mesh_pass_, "cull meshes", "items.vert", "keep_commands.geom", commands);
  return done;
}

core::Expected<void> GpuCuller::make_bounds(const Snapshot& snapshot, const gpuscene::GpuScene& scene) {
  batches_.clear();
  auto slots = slots_by_batch(snapshot);
  for (const Batch& batch : scene.batches())
    if (auto done = add_batch(snapshot.bounds(), scene, batch, std::move(slots[std::size_t(batch.kind)])); !done)
      return done;
  slot_count_ = Slot(snapshot.size());
  uses_layers_ = snapshot.bounds().uses_layers();
  return {};
}

core::Expected<void> GpuCuller::add_batch(const core::ItemBounds& bounds, const gpuscene::GpuScene& scene,
                                          const Batch& batch, std::vector<Slot> slots) {
  auto made = GpuBounds::create(*gl_, bounds, batch, std::move(slots));
  if (!made) return tl::unexpected(made.error());
  BatchBounds added{batch.kind, std::move(*made), {}, {}, {}, {}};
  auto clusters =
      gl::Buffer::create(*gl_, added.bounds.cluster_capacity() * sizeof(std::uint32_t), nullptr, 0, "visible clusters");
  if (!clusters) return tl::unexpected(clusters.error());
  added.visible_clusters = std::move(*clusters);
  added.clusters_feedback = gl::TransformFeedback(*gl_);
  added.clusters_feedback.set_buffer(added.visible_clusters.id(), 0, added.visible_clusters.size());
  if (batch.kind == BatchKind::kMesh) {
    std::vector<gpuscene::ElementsCommand> commands = scene.meshes().commands;
    commands.resize(batch.capacity);
    auto buffer = gl::Buffer::create(*gl_, std::span(commands), GL_DYNAMIC_STORAGE_BIT, "commands of all meshes");
    if (!buffer) return tl::unexpected(buffer.error());
    added.commands = std::move(*buffer);
    auto texels = gl::TextureBuffer::create(*gl_, added.commands, GL_R32UI, "commands of all meshes");
    if (!texels) return tl::unexpected(texels.error());
    added.command_texels = std::move(*texels);
  }
  batches_.push_back(std::move(added));
  return {};
}

core::Expected<void> GpuCuller::update(const Snapshot& snapshot, const gpuscene::GpuScene& scene,
                                       std::span<const Slot> touched) {
  if (snapshot.bounds().uses_layers() != uses_layers_) return make_bounds(snapshot, scene);
  std::array<std::vector<std::uint32_t>, gpuscene::kBatchKindCount> changed;
  const auto batch_of = [&](Slot slot) { return std::size_t(gpuscene::batch_of(snapshot.kind(slot))); };
  for (const Slot slot : touched) changed[batch_of(slot)].push_back(gpuscene::GpuScene::record_of(snapshot, slot));
  std::array<BatchBounds*, gpuscene::kBatchKindCount> by_kind{};
  for (BatchBounds& batch : batches_) by_kind[std::size_t(batch.kind)] = &batch;
  for (; slot_count_ < snapshot.size(); ++slot_count_)
    changed[batch_of(slot_count_)].push_back(by_kind[batch_of(slot_count_)]->bounds.append(slot_count_));
  for (BatchBounds& batch : batches_) {
    std::vector<std::uint32_t>& records = changed[std::size_t(batch.kind)];
    std::sort(records.begin(), records.end());
    batch.bounds.update(snapshot.bounds(), records);
    if (batch.kind != BatchKind::kMesh) continue;
    const auto& commands = scene.meshes().commands;
    for (const std::uint32_t record : records)
      batch.commands.write(record * sizeof(commands[0]), sizeof(commands[0]), &commands[record]);
  }
  return {};
}

std::size_t GpuCuller::memory_bytes() const {
  std::size_t bytes = plane_block_.size();
  for (const BatchBounds& batch : batches_)
    bytes += batch.bounds.memory_bytes() + batch.visible_clusters.size() + batch.commands.size();
  return bytes;
}

// --- culling ---------------------------------------------------------------------------------------------------------

core::Expected<void> GpuCuller::cull(const core::View& view, const Snapshot& snapshot, const gpuscene::GpuScene& scene,
                                     gpuscene::DrawLists& lists, std::uint64_t frame) {
  if (auto done = lists.begin_gpu_update(scene); !done) return done;
  Probe& probe = next_probe(frame);
  const CullPlanes planes(view, snapshot.bounds());
  // Without layers every item is on the model layer alone.
  probe.skipped = planes.nothing_visible() || (!uses_layers_ && (view.layers & core::kLayerModel) == 0);
  if (probe.skipped) {
    lists.clear();
    return {};
  }
  probe.timed = timer_ && &probe != &probes_.back() && timer_->begin();
  upload_planes(planes, snapshot.bounds(), view.layers);
  const gl::Functions& gl = *gl_;
  framebuffer_.bind();
  gl.Enable(GL_RASTERIZER_DISCARD);
  gl.BindBufferBase(GL_UNIFORM_BUFFER, kPlaneBinding, plane_block_.id());
  find_clusters();
  find_items(lists, probe);
  gl.Disable(GL_RASTERIZER_DISCARD);
  lists.end_gpu_update(scene);
  if (probe.timed) timer_->end();
  return {};
}

void GpuCuller::upload_planes(const CullPlanes& planes, const core::ItemBounds& bounds, std::uint32_t layers) const {
  PlaneBlock block{};
  for (int i = 0; i < planes.plane_count(); ++i) {
    const FloatPlane& plane = planes.planes()[i];
    block.planes[i] = {
        {plane.normal[0], plane.normal[1], plane.normal[2]}, plane.offset, gpu_band(plane.band, bounds), {}};
  }
  block.union_first = planes.union_first();
  block.plane_count = planes.plane_count();
  block.layers = layers;
  plane_block_.write(0, sizeof block, &block);
}

void GpuCuller::bind(const gl::Program& program, const GpuBoxes& boxes) const {
  program.use();
  gl_->ProgramUniform1i(program.id(), kUseLayersUniform, uses_layers_ ? 1 : 0);
  gl_->BindTextureUnit(kBoxUnit, boxes.corner_texels.id());
  if (uses_layers_) gl_->BindTextureUnit(kLayerUnit, boxes.layer_texels.id());
}

void GpuCuller::find_clusters() const {
  const gl::Functions& gl = *gl_;
  cluster_array_.bind();
  for (const BatchBounds& batch : batches_) {
    bind(cluster_pass_, batch.bounds.clusters());
    batch.clusters_feedback.begin_points();
    gl.DrawArrays(GL_POINTS, 0, GLsizei(batch.bounds.cluster_count()));
    batch.clusters_feedback.end();
  }
}

void GpuCuller::find_items(const gpuscene::DrawLists& lists, const Probe& probe) const {
  const gl::Functions& gl = *gl_;
  item_array_.bind();
  for (const BatchBounds& batch : batches_) {
    const bool meshes = batch.kind == BatchKind::kMesh;
    bind(meshes ? mesh_pass_ : item_pass_, batch.bounds.items());
    if (meshes) gl.BindTextureUnit(kCommandUnit, batch.command_texels.id());
    gl.VertexArrayVertexBuffer(item_array_.id(), kClusterBufferBinding, batch.visible_clusters.id(), 0,
                               sizeof(std::uint32_t));
    const gpuscene::DrawLists::Target target = lists.target(batch.kind);
    item_feedback_.set_buffer(target.buffer, target.offset, target.size);
    gl.BeginQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, probe.found[std::size_t(batch.kind)].name());
    item_feedback_.begin_points();
    gl.DrawTransformFeedbackInstanced(GL_POINTS, batch.clusters_feedback.id(), GLsizei(kClusterSize));
    item_feedback_.end();
    gl.EndQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
  }
}

// --- what becomes known ----------------------------------------------------------------------------------------------

GpuCuller::Probe& GpuCuller::next_probe(std::uint64_t frame) {
  Probe& probe = probes_[pending_ < kProbes ? (first_probe_ + pending_) % kProbes : kProbes];
  if (pending_ < kProbes) ++pending_;
  probe.frame = frame;
  probe.timed = false;
  return probe;
}

std::optional<GpuCuller::Feedback> GpuCuller::take_feedback() {
  if (pending_ == 0) return std::nullopt;
  const Probe& probe = probes_[first_probe_];
  Feedback feedback{probe.frame, 0, std::nullopt};
  if (!probe.skipped) {
    for (const BatchBounds& batch : batches_) {
      constexpr GLuint kUnknown = ~0u;
      GLuint found = kUnknown;
      gl_->GetQueryObjectuiv(probe.found[std::size_t(batch.kind)].name(), GL_QUERY_RESULT_NO_WAIT, &found);
      if (found == kUnknown) return std::nullopt;
      feedback.visible += found;
    }
    if (probe.timed && !(feedback.time_ms = timer_->poll())) return std::nullopt;
  }
  first_probe_ = (first_probe_ + 1) % kProbes;
  --pending_;
  return feedback;
}

core::VisibleSet GpuCuller::read_back(const gpuscene::DrawLists& lists) const {
  core::VisibleSet set;
  for (const BatchBounds& batch : batches_) {
    if (lists.section(batch.kind).count == 0) continue;
    const gpuscene::DrawLists::Target target = lists.target(batch.kind);
    std::uint32_t count = 0;
    lists.counts().read(gpuscene::DrawLists::record_count_offset(batch.kind), sizeof count, &count);
    const bool meshes = batch.kind == BatchKind::kMesh;
    const std::size_t words = meshes ? sizeof(gpuscene::ElementsCommand) / sizeof(std::uint32_t) : 1;
    std::vector<std::uint32_t> found(count * words);
    gl_->GetNamedBufferSubData(target.buffer, GLintptr(target.offset), GLsizeiptr(found.size() * sizeof(found[0])),
                               found.data());
    for (std::size_t i = 0; i < count; ++i)
      set.items.push_back(batch.bounds.slots()[found[(i + 1) * words - 1]]);  // a mesh's base instance is its record
  }
  std::sort(set.items.begin(), set.items.end());
  return set;
}

}  // namespace sightline::culling
