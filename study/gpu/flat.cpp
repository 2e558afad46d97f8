#include "sightline/study/gpu/flat.h"

#include <algorithm>
#include <utility>

#include "sightline/core/block_order.h"
#include "sightline/study/gpu/feedback_pass.h"
#include "sightline/study/gpu/planes.h"

namespace sightline::study {
namespace {

gl::ProgramDescription describe_flat(bool signed_answers) {
  gl::ProgramDescription description = describe_feedback(flat_name(signed_answers));
  description.stages = {{GL_VERTEX_SHADER, {"flat.vert"}}};
  if (!signed_answers) description.stages.push_back({GL_GEOMETRY_SHADER, {"keep.geom"}});
  description.feedback_varyings = {signed_answers ? "answer" : "found"};
  if (signed_answers) description.shaders.defines.emplace_back("SIGNED");
  return description;
}

class Flat : public Method {
 public:
  static core::Expected<std::unique_ptr<Method>> make(const gl::Context& context, bool signed_answers,
                                                      std::span<const core::Aabb> boxes) {
    std::unique_ptr<Flat> flat(new Flat(context, signed_answers, boxes));
    if (flat->count_ == 0) return flat;
    if (auto done = flat->prepare(boxes); !done) return tl::unexpected(done.error());
    return flat;
  }

  void cull(const core::View& view) override {
    found_ = 0;
    const culling::CullPlanes planes(view, extent_);
    if (count_ == 0 || planes.nothing_visible()) return;
    planes_.upload(planes, extent_);
    gl_->BindTextureUnit(kBoxUnit, boxes_.texels.id());
    pass_.run(count_);
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
  std::size_t memory_bytes() const override { return boxes_.buffer.size() + pass_.output().size(); }

 private:
  Flat(const gl::Context& context, bool signed_answers, std::span<const core::Aabb> boxes)
      : gl_(&context.functions()),
        signed_answers_(signed_answers),
        count_(std::uint32_t(boxes.size())),
        extent_(extent_of(boxes)) {}

  /// Boxes in the order that production has them, which neighbouring lanes profit from.
  core::Expected<void> prepare(std::span<const core::Aabb> boxes) {
    order_ = core::block_order(boxes, {.threads = 1});
    std::vector<core::Aabb> sorted;
    for (const std::uint32_t i : order_) sorted.push_back(boxes[i]);
    auto uploaded = TexelArray::create(*gl_, std::span(std::as_const(sorted)), GL_RGB32F, 0, "study boxes");
    if (!uploaded) return tl::unexpected(uploaded.error());
    boxes_ = std::move(*uploaded);
    names_.resize(count_);
    if (signed_answers_) answers_.resize(count_);
    auto planes = GpuPlanes::create(*gl_);
    if (!planes) return tl::unexpected(planes.error());
    planes_ = std::move(*planes);
    auto pass = FeedbackPass::create(*gl_, describe_flat(signed_answers_), sizeof(std::uint32_t), count_);
    if (!pass) return tl::unexpected(pass.error());
    pass_ = std::move(*pass);
    return {};
  }

  void read_names() {
    found_ = pass_.written();
    if (found_ > 0) pass_.read(found_, names_.data());
  }
  void read_signed() {
    pass_.read(count_, answers_.data());
    for (const std::int32_t answer : answers_)
      if (answer > 0) names_[found_++] = std::uint32_t(answer - 1);
  }

  const gl::Functions* gl_;
  bool signed_answers_;
  std::uint32_t count_;
  core::ItemBounds extent_;
  std::vector<std::uint32_t> order_;
  TexelArray boxes_;
  GpuPlanes planes_;
  FeedbackPass pass_;
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
  return Flat::make(context, signed_answers, boxes);
}

}  // namespace sightline::study
