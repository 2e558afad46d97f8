// The variant in vertex and geometry stages, with the rasteriser off: two passes over each batch. The first has a
// vertex for each cluster of 64 consecutive records, the second one for each record of the clusters that were kept, 64
// instances of each; vertex stages test boxes, geometry stages write what is kept through transform feedback. Parts of
// meshes, where there are any, go through both passes after their records, and are written behind these: by the same
// program, since feedback may go on only with that.
#include "sightline/core/internal/store.h"
#include "sightline/culling/gpu/internal/gpu_pass.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/query.h"
#include "sightline/gl/internal/transform_feedback.h"
#include "sightline/gl/internal/vertex_array.h"

namespace sightline::culling {
namespace {

using gpuscene::BatchKind;
using gpuscene::DrawLists;

constexpr GLuint kClusterAttribute = 0, kClusterBufferBinding = 0;
constexpr GLuint kCountedStream = 1, kApartStream = 2;  // of count_in_view.glsl and keep_commands.geom

/// `unoccluded`: the selection is kUnoccludedNow. All others keep the same clusters.
gl::ProgramDescription describe_clusters(bool parts, bool unoccluded) {
  auto pass = describe_pass(
      "cull clusters", {{GL_VERTEX_SHADER, {"clusters.vert"}}, {GL_GEOMETRY_SHADER, {"keep.geom"}}},
      parts ? ProgramKind::kParts : ProgramKind::kRecords, unoccluded ? Selection::kUnoccludedNow : Selection::kAll);
  pass.feedback_varyings = {"found"};
  return pass;
}

gl::ProgramDescription describe_items(ProgramKind kind, Selection selection) {
  const bool meshes = kind != ProgramKind::kRecords;
  const char* keep = meshes ? "keep_commands.geom" : "keep.geom";
  auto pass =
      describe_pass("cull items", {{GL_VERTEX_SHADER, {"items.vert"}}, {GL_GEOMETRY_SHADER, {keep}}}, kind, selection);
  if (meshes) {
    pass.feedback_varyings = {"command", "base_instance"};
  } else {
    pass.feedback_varyings = {"found"};
  }
  return pass;
}

class GeometryPass : public GpuPass {
 public:
  explicit GeometryPass(const gl::Functions& gl)
      : gl_(&gl), cluster_array_(gl), item_array_(gl), item_feedback_(gl), probes_(kProbes) {}

  core::Expected<void> prepare(std::span<const CullBatch> batches, Selection selection) override {
    auto done = fit(batches);
    for (const CullBatch& batch : batches)
      if (done && cluster_pass(batch, selection).id() == 0) done = make_cluster_pass(batch, selection);
    if (!done) return done;
    return item_pass_[std::size_t(selection)].make(*gl_, batches,
                                                   [&](ProgramKind kind) { return describe_items(kind, selection); });
  }

  core::Expected<void> describe_item_array() const {
    const GLuint array = item_array_.id();
    auto made = gl::check_names(*gl_, {cluster_array_.id(), array, item_feedback_.id()}, "objects of the culler");
    if (!made) return made;
    gl_->EnableVertexArrayAttrib(array, kClusterAttribute);
    gl_->VertexArrayAttribIFormat(array, kClusterAttribute, 1, GL_UNSIGNED_INT, 0);
    gl_->VertexArrayAttribBinding(array, kClusterAttribute, kClusterBufferBinding);
    return {};
  }

  core::Expected<void> make_framebuffer() {
    return core::store(gl::Framebuffer::create_attachmentless(*gl_, 1, 1, "cull"), framebuffer_);
  }

  core::Expected<void> make_cluster_pass(const CullBatch& batch, Selection selection) {
    const auto description = describe_clusters(batch.parts != nullptr, selection == Selection::kUnoccludedNow);
    return core::store(gl::Program::create(*gl_, description), cluster_pass(batch, selection));
  }

  core::Expected<void> fit(std::span<const CullBatch> batches) {
    kept_.resize(batches.size());
    core::Expected<void> done;
    for (std::size_t i = 0; done && i < batches.size(); ++i) {
      done = fit(kept_[i], batches[i].bounds.cluster_capacity());
      if (done && batches[i].parts) done = fit(kept_parts_, batches[i].parts->cluster_capacity());
    }
    return done;
  }

  GpuVariant variant() const override { return GpuVariant::kGeometry; }
  DrawLists::Counting counting() const override { return DrawLists::Counting::kSearch; }

  void run(std::span<const CullBatch> batches, const DrawLists& lists, Selection selection,
           std::size_t probe) override {
    if (selection != Selection::kUnoccludedNow) probes_[probe].counts_in_view = counts_in_view(selection);
    probes_[probe].goes_on = selection == Selection::kUnoccludedNow;
    if (gl_->stale_indirect_draws) gl_->Flush();  // or items are drawn as often as meshes were
    gl_->Enable(GL_RASTERIZER_DISCARD);
    framebuffer_.bind();
    cluster_array_.bind();
    for (std::size_t i = 0; i < batches.size(); ++i) {
      find_clusters({batches[i], false}, kept_[i], selection);
      if (batches[i].parts) find_clusters({batches[i], true}, kept_parts_, selection);
    }
    item_array_.bind();
    for (std::size_t i = 0; i < batches.size(); ++i) find_items(batches[i], kept_[i], lists, selection, probes_[probe]);
    gl_->Disable(GL_RASTERIZER_DISCARD);
    if (selection == Selection::kUnoccludedNow)
      gl_->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);  // of unoccluded_frames
  }

  std::optional<Found> found(std::size_t place) override {
    const Probe& probe = probes_[place];
    const auto written = sum(probe.written);
    const auto in_view = probe.counts_in_view ? sum(probe.in_view) : written;
    const auto more = probe.goes_on ? sum(probe.written_more) : 0;
    return written && more && in_view ? std::optional(Found{*in_view, *written + *more}) : std::nullopt;
  }

  std::size_t memory_bytes() const override {
    std::size_t bytes = kept_parts_.clusters.size();
    for (const Kept& kept : kept_) bytes += kept.clusters.size();
    return bytes;
  }

 private:
  struct Kept {
    gl::Buffer clusters;
    gl::TransformFeedback feedback;
  };
  /// By batch kind, and of meshes that are drawn by parts; each made when first used.
  using Queries = std::array<gl::Query, gpuscene::kBatchKindCount + 1>;
  struct Probe {
    Queries written, written_more, in_view;
    bool counts_in_view = false, goes_on = false;
  };

  core::Expected<void> fit(Kept& kept, std::uint32_t capacity) const {
    const std::size_t bytes = capacity * sizeof(std::uint32_t);
    if (kept.clusters.size() >= bytes) return {};
    auto clusters = gl::Buffer::create(*gl_, bytes, nullptr, 0, "visible clusters");
    if (!clusters) return tl::unexpected(clusters.error());
    gl::TransformFeedback feedback(*gl_);
    if (auto made = gl::check_names(*gl_, {feedback.id()}, "transform feedback of visible clusters"); !made)
      return made;
    kept = {std::move(*clusters), std::move(feedback)};
    kept.feedback.set_buffer(kept.clusters.id(), 0, kept.clusters.size());
    return {};
  }

  gl::Program& cluster_pass(const CullBatch& batch, Selection selection) {
    return cluster_pass_[batch.parts != nullptr][selection == Selection::kUnoccludedNow];
  }

  void find_clusters(const CullList& list, const Kept& kept, Selection selection) {
    const gl::Program& program = cluster_pass(list.batch, selection);
    program.use();
    bind_list(*gl_, program, list);
    if (selection == Selection::kUnoccludedNow) bind_selection(*gl_, program, list, selection);
    kept.feedback.begin_points();
    gl_->DrawArrays(GL_POINTS, 0, GLsizei(list.cluster_count()));
    kept.feedback.end();
  }

  /// The sum of results; nothing while one is not known.
  static std::optional<std::uint64_t> sum(const Queries& queries) {
    std::uint64_t sum = 0;
    for (const gl::Query& query : queries) {
      if (query.empty()) continue;
      const auto found = query.result_if_known();
      if (!found) return std::nullopt;
      sum += *found;
    }
    return sum;
  }

  void find_items(const CullBatch& batch, const Kept& kept, const DrawLists& lists, Selection selection,
                  Probe& probe) const {
    const gl::Program& program = item_pass_[std::size_t(selection)].of(batch);
    program.use();
    const DrawLists::Target target = lists.target(batch.kind);
    item_feedback_.set_buffer(target.buffer, target.offset, target.size);
    const bool counts = counts_in_view(selection);
    Queries& all_written = probe.goes_on ? probe.written_more : probe.written;
    gl::Query& written = all_written[std::size_t(batch.kind)];
    gl::Query& apart = all_written[gpuscene::kBatchKindCount];
    gl::Query& in_view = probe.in_view[std::size_t(batch.kind)];
    if (written.empty()) written = gl::Query(*gl_, GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    if (batch.parts && apart.empty()) apart = gl::Query(*gl_, GL_PRIMITIVES_GENERATED);
    if (counts && in_view.empty()) in_view = gl::Query(*gl_, GL_PRIMITIVES_GENERATED);
    written.begin();
    if (batch.parts) apart.begin(kApartStream);
    if (counts) in_view.begin(kCountedStream);
    item_feedback_.begin_points();
    keep({batch, false}, program, kept, selection);
    if (counts) in_view.end(kCountedStream);
    if (batch.parts) apart.end(kApartStream);
    written.end();
    if (batch.parts) keep({batch, true}, program, kept_parts_, selection);
    item_feedback_.end();
  }

  /// Adds what is selected of the clusters that were kept.
  void keep(const CullList& list, const gl::Program& program, const Kept& kept, Selection selection) const {
    bind_selection(*gl_, program, list, selection);
    bind_list(*gl_, program, list);
    gl_->VertexArrayVertexBuffer(item_array_.id(), kClusterBufferBinding, kept.clusters.id(), 0, sizeof(std::uint32_t));
    gl_->DrawTransformFeedbackInstanced(GL_POINTS, kept.feedback.id(), GLsizei(kItemsPerCluster));
  }

  const gl::Functions* gl_;
  // [kUnoccludedNow or any other selection][whether the batch has parts]
  std::array<std::array<gl::Program, 2>, 2> cluster_pass_;
  std::array<BatchPrograms, kSelectionCount> item_pass_;
  gl::VertexArray cluster_array_, item_array_;
  gl::Framebuffer framebuffer_;
  gl::TransformFeedback item_feedback_;
  std::vector<Kept> kept_;  // by batch
  Kept kept_parts_;
  std::vector<Probe> probes_;
};

}  // namespace

std::vector<gl::PipelineDescription> geometry_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const bool parts : {false, true})
    for (const bool unoccluded : {false, true}) all.push_back({describe_clusters(parts, unoccluded)});
  for (std::size_t kind = 0; kind < kProgramKinds; ++kind)
    for (std::size_t selection = 0; selection < kSelectionCount; ++selection)
      all.push_back({describe_items(ProgramKind(kind), Selection(selection))});
  return all;
}

core::Expected<std::unique_ptr<GpuPass>> make_geometry_pass(const gl::Context& context,
                                                            std::span<const CullBatch> batches) {
  if (context.functions().workarounds[gl::Workaround::kNoFeedback])
    return core::fail("the driver's transform feedback is faulty (workaround no-feedback)");
  auto pass = std::make_unique<GeometryPass>(context.functions());
  auto done = pass->describe_item_array();
  if (done) done = pass->make_framebuffer();
  if (done) done = pass->fit(batches);
  if (!done) return tl::unexpected(done.error());
  return pass;
}

}  // namespace sightline::culling
