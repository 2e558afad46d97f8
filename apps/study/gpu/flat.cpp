#include "sightline/apps/study/gpu/flat.h"

#include <algorithm>
#include <utility>

#include "sightline/apps/study/gpu/planes.h"
#include "sightline/apps/study/gpu/shaders.h"
#include "sightline/core/block_order.h"
#include "sightline/culling/gpu/internal/shaders.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/query.h"
#include "sightline/gl/internal/transform_feedback.h"
#include "sightline/gl/internal/vertex_array.h"

namespace sightline::study {
namespace {

gl::ProgramDescription describe_flat(bool signed_answers) {
  gl::ProgramDescription description;
  description.name = flat_name(signed_answers);
  description.shaders.tables = {shaders(), culling::shaders()};
  description.stages = {{GL_VERTEX_SHADER, {"flat.vert"}}};
  if (!signed_answers) description.stages.push_back({GL_GEOMETRY_SHADER, {"keep.geom"}});
  description.feedback_varyings = {signed_answers ? "answer" : "found"};
  if (signed_answers) description.shaders.defines.emplace_back("SIGNED");
  return description;
}

class Flat : public Method {
 public:
  Flat(const gl::Context& context, bool signed_answers, std::span<const core::Aabb> boxes)
      : gl_(context.functions()),
        signed_answers_(signed_answers),
        count_(std::uint32_t(boxes.size())),
        extent_(extent_of(boxes)) {}

  /// Boxes in the order that production has them, which neighbouring lanes profit from.
  core::Expected<void> prepare(std::span<const core::Aabb> boxes) {
    if (count_ == 0) return {};
    order_ = core::block_order(boxes, {.threads = 1});
    std::vector<core::Aabb> sorted;
    for (const std::uint32_t i : order_) sorted.push_back(boxes[i]);
    auto uploaded = TexelArray::create(gl_, std::span(std::as_const(sorted)), GL_RGB32F, 0, "study boxes");
    if (!uploaded) return tl::unexpected(uploaded.error());
    auto planes = GpuPlanes::create(gl_);
    if (!planes) return tl::unexpected(planes.error());
    const gl::ProgramDescription description = describe_flat(signed_answers_);
    auto program = gl::Program::create(gl_, description);
    if (!program) return tl::unexpected(program.error());
    auto output = gl::Buffer::create(gl_, sizeof(std::uint32_t) * count_, nullptr, 0, description.name);
    if (!output) return tl::unexpected(output.error());
    auto framebuffer = gl::Framebuffer::create_attachmentless(gl_, 1, 1, description.name);
    if (!framebuffer) return tl::unexpected(framebuffer.error());
    boxes_ = std::move(*uploaded);
    planes_ = std::move(*planes);
    program_ = std::move(*program);
    output_ = std::move(*output);
    framebuffer_ = std::move(*framebuffer);
    array_ = gl::VertexArray(gl_);
    feedback_ = gl::TransformFeedback(gl_);
    feedback_.set_buffer(output_.id(), 0, output_.size());
    written_ = gl::Query(gl_, GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    names_.resize(count_);
    if (signed_answers_) answers_.resize(count_);
    return {};
  }

  void cull(const core::View& view) override {
    found_ = 0;
    const culling::CullPlanes planes(view, extent_);
    if (count_ == 0 || planes.nothing_visible()) return;
    planes_.upload(planes, extent_);
    gl_.BindTextureUnit(kBoxUnit, boxes_.texels.id());
    draw_points();
    signed_answers_ ? read_signed() : read_names();
  }
  std::uint64_t count() const override { return found_; }
  std::vector<std::uint32_t> ids() const override {
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < found_; ++i) ids.push_back(order_[names_[i]]);
    std::sort(ids.begin(), ids.end());
    return ids;
  }
  core::CullCounters counters() const override { return {0, count_}; }
  std::size_t memory_bytes() const override { return boxes_.buffer.size() + output_.size(); }

 private:
  /// A vertex for each box through the program with the rasteriser off: how one computed on a GPU before compute
  /// shaders.
  void draw_points() const {
    framebuffer_.bind();
    program_.use();
    array_.bind();
    gl_.Enable(GL_RASTERIZER_DISCARD);
    written_.begin();
    feedback_.begin_points();
    gl_.DrawArrays(GL_POINTS, 0, GLsizei(count_));
    feedback_.end();
    written_.end();
    gl_.Disable(GL_RASTERIZER_DISCARD);
  }
  void read_names() {
    found_ = written_.result();
    if (found_ > 0) output_.read(0, found_ * sizeof(std::uint32_t), names_.data());
  }
  void read_signed() {
    output_.read(0, count_ * sizeof(std::int32_t), answers_.data());
    for (const std::int32_t answer : answers_)
      if (answer > 0) names_[found_++] = std::uint32_t(answer - 1);
  }

  const gl::Functions& gl_;
  bool signed_answers_;
  std::uint32_t count_;
  core::ItemBounds extent_;
  std::vector<std::uint32_t> order_;
  TexelArray boxes_;
  GpuPlanes planes_;
  gl::Program program_;
  gl::Buffer output_;
  gl::VertexArray array_;
  gl::Framebuffer framebuffer_;  // draws need one in a context without a surface
  gl::TransformFeedback feedback_;
  gl::Query written_;
  std::vector<std::uint32_t> names_;   // visible places of the order; the first found_ hold
  std::vector<std::int32_t> answers_;  // of all, with signed answers
  std::uint32_t found_ = 0;
};

}  // namespace

std::string flat_name(bool signed_answers) {
  return signed_answers ? "GPU signed answers" : "GPU points";
}

std::vector<gl::PipelineDescription> flat_programs() {
  return {{{describe_flat(false)}}, {{describe_flat(true)}}};
}

core::Expected<std::unique_ptr<Method>> make_flat(const gl::Context& context, bool signed_answers,
                                                  std::span<const core::Aabb> boxes) {
  auto flat = std::make_unique<Flat>(context, signed_answers, boxes);
  if (auto done = flat->prepare(boxes); !done) return tl::unexpected(done.error());
  return flat;
}

}  // namespace sightline::study
