// The variant in vertex and geometry stages, with the rasteriser off: two passes over each batch. The first has a
// vertex for each cluster of 64 consecutive records, the second one for each record of the clusters that were kept, 64
// instances of each; vertex stages test boxes, geometry stages write what is kept through transform feedback.
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

class GeometryPass : public GpuPass {
 public:
  explicit GeometryPass(const gl::Functions& gl)
      : gl_(&gl), cluster_array_(gl), item_array_(gl), item_feedback_(gl), queries_(kProbes) {
    const GLuint array = item_array_.id();
    gl.EnableVertexArrayAttrib(array, kClusterAttribute);
    gl.VertexArrayAttribIFormat(array, kClusterAttribute, 1, GL_UNSIGNED_INT, 0);
    gl.VertexArrayAttribBinding(array, kClusterAttribute, kClusterBufferBinding);
  }

  core::Expected<void> make_programs(std::span<const CullBatch> batches) {
    auto framebuffer = gl::Framebuffer::create_attachmentless(*gl_, 1, 1, "cull");
    if (!framebuffer) return tl::unexpected(framebuffer.error());
    framebuffer_ = std::move(*framebuffer);
    auto clusters =
        describe_pass("cull clusters", {{GL_VERTEX_SHADER, {"clusters.vert"}}, {GL_GEOMETRY_SHADER, {"keep.geom"}}});
    clusters.feedback_varyings = {"found"};
    auto program = gl::Program::create(*gl_, clusters);
    if (!program) return tl::unexpected(program.error());
    cluster_pass_ = std::move(*program);
    return item_pass_.make(*gl_, batches, [](bool meshes) {
      const char* keep = meshes ? "keep_commands.geom" : "keep.geom";
      auto pass = describe_pass("cull items", {{GL_VERTEX_SHADER, {"items.vert"}}, {GL_GEOMETRY_SHADER, {keep}}});
      if (meshes) {
        pass.feedback_varyings = {"command", "base_instance"};
      } else {
        pass.feedback_varyings = {"found"};
      }
      return pass;
    });
  }

  core::Expected<void> fit(std::span<const CullBatch> batches) {
    for (const CullBatch& batch : batches) {
      const std::size_t bytes = batch.bounds.cluster_capacity() * sizeof(std::uint32_t);
      auto clusters = gl::Buffer::create(*gl_, bytes, nullptr, 0, "visible clusters");
      if (!clusters) return tl::unexpected(clusters.error());
      Kept& kept = kept_.emplace_back(Kept{std::move(*clusters), gl::TransformFeedback(*gl_)});
      kept.feedback.set_buffer(kept.clusters.id(), 0, kept.clusters.size());
      for (auto& of_probe : queries_)
        of_probe[std::size_t(batch.kind)] = gl::Query(*gl_, GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    }
    return {};
  }

  GpuVariant variant() const override { return GpuVariant::kGeometry; }
  DrawLists::Counting counting() const override { return DrawLists::Counting::kSearch; }

  void run(std::span<const CullBatch> batches, const DrawLists& lists, std::size_t probe) override {
    gl_->Enable(GL_RASTERIZER_DISCARD);
    framebuffer_.bind();
    cluster_array_.bind();
    for (std::size_t i = 0; i < batches.size(); ++i) find_clusters(batches[i], kept_[i]);
    item_array_.bind();
    for (std::size_t i = 0; i < batches.size(); ++i)
      find_items(batches[i], kept_[i], lists, queries_[probe][std::size_t(batches[i].kind)]);
    gl_->Disable(GL_RASTERIZER_DISCARD);
  }

  std::optional<std::uint64_t> found(std::size_t probe) override {
    std::uint64_t sum = 0;
    for (const gl::Query& query : queries_[probe]) {
      if (query.empty()) continue;
      const auto found = query.result_if_known();
      if (!found) return std::nullopt;
      sum += *found;
    }
    return sum;
  }

  std::size_t memory_bytes() const override {
    std::size_t bytes = 0;
    for (const Kept& kept : kept_) bytes += kept.clusters.size();
    return bytes;
  }

 private:
  struct Kept {
    gl::Buffer clusters;
    gl::TransformFeedback feedback;
  };

  void find_clusters(const CullBatch& batch, const Kept& kept) const {
    cluster_pass_.use();
    bind_batch(*gl_, batch);
    kept.feedback.begin_points();
    gl_->DrawArrays(GL_POINTS, 0, GLsizei(batch.bounds.cluster_count()));
    kept.feedback.end();
  }

  void find_items(const CullBatch& batch, const Kept& kept, const DrawLists& lists, const gl::Query& query) const {
    item_pass_.of(batch).use();
    bind_batch(*gl_, batch);
    gl_->VertexArrayVertexBuffer(item_array_.id(), kClusterBufferBinding, kept.clusters.id(), 0, sizeof(std::uint32_t));
    const DrawLists::Target target = lists.target(batch.kind);
    item_feedback_.set_buffer(target.buffer, target.offset, target.size);
    query.begin();
    item_feedback_.begin_points();
    gl_->DrawTransformFeedbackInstanced(GL_POINTS, kept.feedback.id(), GLsizei(kItemsPerCluster));
    item_feedback_.end();
    query.end();
  }

  const gl::Functions* gl_;
  gl::Program cluster_pass_;
  BatchPrograms item_pass_;
  gl::VertexArray cluster_array_, item_array_;
  gl::Framebuffer framebuffer_;
  gl::TransformFeedback item_feedback_;
  std::vector<Kept> kept_;                                                 // by batch
  std::vector<std::array<gl::Query, gpuscene::kBatchKindCount>> queries_;  // by probe
};

}  // namespace

core::Expected<std::unique_ptr<GpuPass>> make_geometry_pass(const gl::Context& context,
                                                            std::span<const CullBatch> batches) {
  auto pass = std::make_unique<GeometryPass>(context.functions());
  auto done = pass->make_programs(batches);
  if (done) done = pass->fit(batches);
  if (!done) return tl::unexpected(done.error());
  return pass;
}

}  // namespace sightline::culling
