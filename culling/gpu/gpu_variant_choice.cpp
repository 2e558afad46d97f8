#include "sightline/culling/gpu/internal/gpu_variant_choice.h"

#include <cstdio>

#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/store.h"
#include "sightline/culling/gpu/internal/gpu_culler.h"
#include "sightline/culling/gpu/internal/gpu_pass.h"
#include "sightline/gl/internal/framebuffer.h"

namespace sightline::culling {
namespace {

constexpr int kRepetitions = 5;  // after one that is not counted: drivers compile late

double now_ms() {
  return 1e3 * core::now_seconds();
}

/// Work for the rasteriser: some milliseconds in software, a fraction of one on hardware.
class EarlierDrawing {
 public:
  static core::Expected<EarlierDrawing> create(const gl::Functions& gl) {
    EarlierDrawing made;
    made.gl_ = &gl;
    constexpr const char* kWhat = "drawing before a cull";
    const gl::Attachment attachment{GL_COLOR_ATTACHMENT0, &made.texture_};
    auto done = core::store(gl::Texture2D::create(gl, kSide, kSide, GL_RGBA8, kWhat), made.texture_);
    if (done) done = core::store(gl::Framebuffer::create(gl, std::span(&attachment, 1), kWhat), made.framebuffer_);
    if (!done) return tl::unexpected(done.error());
    return made;
  }

  /// Clears again and again. Each clear is flushed, since the next one makes it superfluous.
  void submit() const {
    for (int i = 0; i < kClears; ++i) {
      const GLfloat colour[4] = {float(i) / kClears, 0.0f, 0.0f, 1.0f};
      gl_->ClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, colour);
      gl_->Flush();
    }
  }

 private:
  static constexpr int kSide = 1024, kClears = 8;
  const gl::Functions* gl_ = nullptr;
  gl::Texture2D texture_;
  gl::Framebuffer framebuffer_;
};

/// A view from the middle of the scene, 90 degrees wide.
core::Expected<core::View> view_from_within(const core::ItemBounds& bounds) {
  const core::Aabb& extent = bounds.extent();
  if (extent.empty()) return core::fail("no items to measure with");
  const core::dvec3 low(extent.min), high(extent.max);
  const core::dvec3 eye = bounds.origin + 0.5 * (low + high);
  const double size = std::max(1e-3, glm::length(high - low));
  return core::View::perspective({eye, eye + core::dvec3(size, 0.3 * size, 0.0), {0, 0, 1}}, 1.57, 1.5, 1e-3 * size);
}

template <class T>
std::string message_of(const core::Expected<T>& result) {
  return result ? std::string() : result.error().message;
}

}  // namespace

/// `why`: the geometry variant cannot be made.
core::Expected<void> GpuCuller::use_compute_alone(const gl::Context& context, const core::Error& why) {
  auto compute = make_compute_pass(context, batches_);
  if (!compute) return core::fail(why.message + "; " + compute.error().message);
  if (auto done = (*compute)->prepare(batches_, Selection::kAll); !done) return done;
  pass_ = std::move(*compute);
  why_this_variant_ = "geometry cannot be had: " + why.message;
  return {};
}

core::Expected<void> GpuCuller::choose_variant(const gl::Context& context, const core::Snapshot& snapshot,
                                               const gpuscene::GpuScene& scene) {
  auto geometry = make_geometry_pass(context, batches_);
  if (!geometry) return use_compute_alone(context, geometry.error());
  if (auto done = (*geometry)->prepare(batches_, Selection::kAll); !done) return done;
  pass_ = std::move(*geometry);
  const auto view = view_from_within(snapshot.bounds());
  auto compute = make_compute_pass(context, batches_);
  const auto prepared = compute ? (*compute)->prepare(batches_, Selection::kAll) : core::Expected<void>();
  auto lists = gpuscene::DrawLists::create(context, scene);
  auto earlier = EarlierDrawing::create(*gl_);
  std::string missing;
  for (const auto& message :
       {message_of(view), message_of(compute), message_of(prepared), message_of(lists), message_of(earlier)})
    if (missing.empty()) missing = message;
  if (!missing.empty()) {
    variant_settled_ = false;
    why_this_variant_ = "not measured: " + missing;
    return {};
  }

  std::array<FormTimes, 2> times;
  std::array<std::unique_ptr<GpuPass>, 2> passes{std::move(pass_), std::move(*compute)};
  core::Expected<void> done;
  for (int repetition = 0; done && repetition <= kRepetitions; ++repetition) {
    for (std::size_t i = 0; done && i < passes.size(); ++i) {
      const auto submit = [&] {
        const double begin = now_ms();
        done = cull(*view, snapshot, scene, *lists);
        return now_ms() - begin;
      };
      pass_.swap(passes[i]);
      gl_->Finish();
      const double begin = now_ms(), submitted = submit();
      gl_->Finish();
      const double alone = now_ms() - begin;
      earlier->submit();
      const double blocked = submit();
      gl_->Finish();
      pass_.swap(passes[i]);
      if (repetition > 0) times[i].take_least({alone, submitted, blocked});
    }
  }
  if (!done) return done;
  pending_ = first_probe_ = 0;  // results of the measurement are discarded
  pass_ = std::move(passes[cheaper_variant(times)]);
  std::array<char, 96> text;
  std::snprintf(text.data(), text.size(), "measured: geometry %.2f ms, compute %.2f ms", times[0].cost(),
                times[1].cost());
  why_this_variant_ = text.data();
  return {};
}

}  // namespace sightline::culling
