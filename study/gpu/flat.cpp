#include "sightline/study/gpu/flat.h"

#include <algorithm>
#include <cassert>

#include "sightline/core/block_order.h"
#include "sightline/study/gpu/feedback_pass.h"
#include "sightline/study/gpu/planes.h"

namespace sightline::study {
namespace {

constexpr std::uint32_t kClusterSize = 64, kWhole = 0x80000000u;
constexpr GLuint kOrderBinding = 0;

core::Expected<TexelArray> upload(const gl::Functions& gl, std::span<const core::Aabb> boxes) {
  return TexelArray::create(gl, boxes, GL_RGB32F, 0, "study boxes");
}

gl::ProgramDescription describe_flat(const FlatForm& form) {
  gl::ProgramDescription description = describe_feedback(name(form));
  description.stages = {{GL_VERTEX_SHADER, {"flat.vert"}}};
  if (!form.signed_answers) description.stages.push_back({GL_GEOMETRY_SHADER, {"keep.geom"}});
  description.feedback_varyings = {form.signed_answers ? "answer" : "found"};
  const auto define = [&](bool wanted, const char* what) {
    if (wanted) description.shaders.defines.emplace_back(what);
  };
  define(form.signed_answers, "SIGNED");
  define(form.split, "SPLIT");
  define(form.plane_order, "PLANE_ORDER");
  define(form.masking, "MASKING");
  return description;
}

gl::ProgramDescription describe_flat_clusters(const FlatForm& form) {
  gl::ProgramDescription description = describe_feedback(name(form) + ", clusters");
  description.stages = {{GL_VERTEX_SHADER, {"flat_clusters.vert"}}};
  description.feedback_varyings = {"planes_left"};
  return description;
}

class Flat : public Method {
 public:
  static core::Expected<std::unique_ptr<Method>> make(const gl::Context& context, const FlatForm& form,
                                                      std::span<const core::Aabb> boxes) {
    std::unique_ptr<Flat> flat(new Flat(context, form, boxes));
    if (flat->count_ == 0) return flat;
    if (auto done = flat->make_boxes(boxes); !done) return tl::unexpected(done.error());
    if (auto done = flat->make_passes(context); !done) return tl::unexpected(done.error());
    return flat;
  }

  void cull(const core::View& view) override {
    found_ = 0;
    const culling::CullPlanes planes(view, extent_);
    if (count_ == 0 || planes.nothing_visible()) return;
    planes_.upload(planes, extent_);
    if (form_.masking) {
      gl_->BindTextureUnit(kBoxUnit, clusters_.texels.id());
      cluster_pass_.run(cluster_count());
      gl_->BindTextureUnit(kMaskUnit, masks_.id());
    }
    gl_->BindTextureUnit(kBoxUnit, boxes_.texels.id());
    if (form_.plane_order) gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, kOrderBinding, plane_order_.id());
    pass_.run(count_);
    form_.signed_answers ? read_signed() : read_names();
  }
  std::uint64_t count() const override { return found_; }
  std::vector<std::uint32_t> ids() const override {
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < found_; ++i) ids.push_back(order_[names_[i] & ~kWhole]);
    std::sort(ids.begin(), ids.end());
    return ids;
  }
  core::CullCounters counters() const override { return {form_.masking ? cluster_count() : 0, count_}; }
  std::size_t memory_bytes() const override {
    return boxes_.buffer.size() + clusters_.buffer.size() + plane_order_.size() + pass_.output().size() +
           cluster_pass_.output().size();
  }

 private:
  Flat(const gl::Context& context, const FlatForm& form, std::span<const core::Aabb> boxes)
      : gl_(&context.functions()), form_(form), count_(std::uint32_t(boxes.size())), extent_(extent_of(boxes)) {}

  std::uint32_t cluster_count() const { return (count_ + kClusterSize - 1) / kClusterSize; }

  /// In the order that production has them, which clusters and neighbouring lanes profit from.
  core::Expected<void> make_boxes(std::span<const core::Aabb> boxes) {
    order_ = core::block_order(boxes, {.threads = 1});
    std::vector<core::Aabb> sorted(count_), around(form_.masking ? cluster_count() : 0);
    for (std::uint32_t i = 0; i < count_; ++i) {
      sorted[i] = boxes[order_[i]];
      if (form_.masking && !sorted[i].empty()) around[i / kClusterSize].grow(sorted[i]);
    }
    auto uploaded = upload(*gl_, sorted);
    if (!uploaded) return tl::unexpected(uploaded.error());
    boxes_ = std::move(*uploaded);
    names_.resize(count_);
    if (form_.signed_answers) answers_.resize(count_);
    if (!form_.masking) return {};
    auto clusters = upload(*gl_, around);
    if (!clusters) return tl::unexpected(clusters.error());
    clusters_ = std::move(*clusters);
    return {};
  }

  core::Expected<void> make_passes(const gl::Context& context) {
    if (form_.plane_order && context.capabilities().max_vertex_storage_blocks < 1)
      return core::fail("plane order: vertex stages of this context cannot write (no storage blocks)");
    auto planes = GpuPlanes::create(*gl_);
    if (!planes) return tl::unexpected(planes.error());
    planes_ = std::move(*planes);

    auto pass = FeedbackPass::create(*gl_, describe_flat(form_), sizeof(std::uint32_t), count_);
    if (!pass) return tl::unexpected(pass.error());
    pass_ = std::move(*pass);

    if (form_.plane_order) {
      const std::vector<std::uint32_t> zero(count_);
      auto order = gl::Buffer::create(*gl_, std::span(zero), 0, "plane order");
      if (!order) return tl::unexpected(order.error());
      plane_order_ = std::move(*order);
    }
    return form_.masking ? make_cluster_pass() : core::Expected<void>{};
  }

  core::Expected<void> make_cluster_pass() {
    auto pass = FeedbackPass::create(*gl_, describe_flat_clusters(form_), sizeof(std::uint32_t), cluster_count());
    if (!pass) return tl::unexpected(pass.error());
    cluster_pass_ = std::move(*pass);
    auto masks = gl::TextureBuffer::create(*gl_, cluster_pass_.output(), GL_R32UI, "cluster masks");
    if (!masks) return tl::unexpected(masks.error());
    masks_ = std::move(*masks);
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
  FlatForm form_;
  std::uint32_t count_;
  core::ItemBounds extent_;
  std::vector<std::uint32_t> order_;
  TexelArray boxes_, clusters_;
  gl::Buffer plane_order_;
  GpuPlanes planes_;
  FeedbackPass pass_, cluster_pass_;
  gl::TextureBuffer masks_;
  std::vector<std::uint32_t> names_;   // visible places of the order; the first found_ hold
  std::vector<std::int32_t> answers_;  // of all, with signed_answers
  std::uint32_t found_ = 0;
};

}  // namespace

std::string name(const FlatForm& form) {
  std::string text = form.signed_answers ? "GPU signed answers" : "GPU points";
  if (form.split) text += " +split";
  if (form.plane_order) text += " +order";
  if (form.masking) text += " +masking";
  return text;
}

std::vector<FlatForm> flat_forms() {
  return {{},
          {.signed_answers = true},
          {.split = true},
          {.plane_order = true},
          {.masking = true},
          {.split = true, .masking = true},
          {.plane_order = true, .masking = true}};
}

std::vector<gl::PipelineDescription> flat_programs() {
  std::vector<gl::PipelineDescription> all;
  for (const FlatForm& form : flat_forms()) {
    all.push_back({describe_flat(form)});
    if (form.masking) all.push_back({describe_flat_clusters(form)});
  }
  return all;
}

core::Expected<std::unique_ptr<Method>> make_flat(const gl::Context& context, const FlatForm& form,
                                                  std::span<const core::Aabb> boxes) {
  assert(!(form.split && form.plane_order));
  return Flat::make(context, form, boxes);
}

}  // namespace sightline::study
