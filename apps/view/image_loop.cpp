#include "sightline/apps/view/image_loop.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace sightline::apps {
namespace {

constexpr core::vec3 kCulledColour{0.85f, 0.1f, 0.55f};
constexpr engine::Hatching kHatching{0.6f, 6.0f};
constexpr double kMotionError = 0.5;      // pixels
constexpr std::size_t kMostImages = 240;  // in plots

}  // namespace

ImageLoop::ImageLoop(const ViewerOptions& options, Window& window, double scale)
    : motion_error(options.shown.lod_error > 0.0 ? options.shown.lod_error : kMotionError),
      options_(options),
      window_(window),
      looks_(options.shown.all_looks()) {
  if (!looks_.depth_shading.any()) looks_.depth_shading = engine::Looks::standard().depth_shading;
  if (!looks_.hatching.any()) looks_.hatching = kHatching;
  if (!looks_.edges.any()) looks_.edges.which = engine::EdgeChoice::kFeature;
  looks_.edges.width *= float(std::max(1.0, scale));
  looks_.hatching.spacing = float(kHatching.spacing * std::max(1.0, scale));
}

engine::Looks ImageLoop::looks(const Shown& shown) const {
  engine::Looks looks = looks_;
  if (!shown.depth_shading) looks.depth_shading = {};
  if (!shown.hatching) looks.hatching = {};
  if (!shown.edges) looks.edges.which = engine::EdgeChoice::kOff;
  return looks;
}

engine::EngineConfig ImageLoop::config(const Shown& shown) const {
  engine::EngineConfig config;
  config.draw = true;
  config.culling.culler = options_.culler;
  config.culling.gpu_variant = options_.gpu_variant;
  config.drawing.samples = options_.samples;
  options_.shown.apply(config);
  config.losses.lod_error = error_in_motion(shown);
  config.drawing.looks = looks(shown);
  config.drawing.culled_colour = kCulledColour;
  config.context.later = true;
  config.drawing.renderer = engine::Renderer::kAutomatic;  // rays need no program, so that the model shows at once
  return config;
}

Done ImageLoop::apply_styles(Session& session, const Shown& shown) const {
  return session.image.configure([&](engine::EngineConfig& config) { config.drawing.looks = looks(shown); });
}

Done ImageLoop::begin(Session& session, const Shown& shown) {
  keeps_moving_image_ = false;
  shown_view_.reset();
  if (const engine::EngineConfig& config = session.engine.config();
      shown.depth_shading != config.drawing.looks.depth_shading.any() ||
      shown.edges != config.drawing.looks.edges.any() ||
      shown.hatching != config.drawing.looks.hatching.any())  // switched meanwhile
    if (auto done = apply_styles(session, shown); !done) return done;
  const double error = error_in_motion(shown);
  return error == session.image.motion_error() ? Done() : session.image.set_motion_error(error);
}

core::dvec2 ImageLoop::in_image(const core::dvec2& cursor) const {
  return {cursor.x - part_.x, cursor.y - (window_.size()[1] - part_.y - part_.height)};
}

bool ImageLoop::contains(const core::dvec2& cursor) const {
  const core::dvec2 at = in_image(cursor);
  return at.x >= 0.0 && at.y >= 0.0 && at.x < part_.width && at.y < part_.height;
}

Done ImageLoop::draw(Session& session, const Shown& shown, double frame_seconds) {
  SessionImage& image = session.image;
  if (auto done = image.resize({part_.width, part_.height}); !done) return done;
  if (auto done = adapt_to_motion(session, shown, frame_seconds); !done) return done;
  const bool shifted = image.partly_refined() || (image.smooth() && !shown.smooth);
  if (options_.frames > 0 || shifted) image.changed();
  const auto drawn = image.draw();
  if (!drawn) return tl::unexpected(drawn.error());
  if (*drawn) note_image(session);
  return show(session, shown);
}

Done ImageLoop::show(Session& session, const Shown& shown) {
  keeps_moving_image_ = keeps_moving_image_ && !motion_.moving() && session.image.report().pending > 0;
  if (keeps_moving_image_) return window_.copy_kept(part_), Done();
  const image::Image* smooth = shown.smooth ? session.image.smooth() : nullptr;
  Done copied;
  if (!smooth || !window_.keeps_image()) copied = window_.keep(smooth);
  if (smooth && copied) {
    window_.copy_kept(part_);
    return copied;
  }
  const std::array<int, 2> size = session.image.drawn_size();
  for (const ImagePart& columns : session.slider.parts(size[0]))
    window_.copy(session.slider.framebuffer(columns).value_or(0), size, part_, columns.begin, columns.end);
  return copied;
}

/// Coarser meshes while the view moves, and fewer pixels where frames then come late, unless a budget sees to that.
/// With one the image at rest takes several frames, and that of the motion stays until then.
Done ImageLoop::adapt_to_motion(Session& session, const Shown& shown, double frame_seconds) {
  const auto view = session.image.view();
  const bool moves = view && shown_view_ && !core::same_image(*view, *shown_view_);
  if (view) shown_view_ = *view;
  const bool moved = motion_.moving();
  const bool late = motion_.next(moves, glfwGetTime(), frame_seconds);
  const bool paced = session.engine.config().losses.budget_ms > 0.0;
  const bool coarse = late && !paced && shown.lower && options_.frames == 0;
  if (moved && !motion_.moving() && session.image.report().pending > 0) {
    const auto image = session.engine.read_colour();
    if (!image) return tl::unexpected(image.error());
    if (auto kept = window_.keep(&*image); !kept) return kept;
    keeps_moving_image_ = true;
  }
  if (auto done = session.image.set_coarse(coarse); !done) return done;
  return session.image.set_moving(motion_.moving());
}

void ImageLoop::note_image(const Session& session) {
  const engine::FrameReport& report = session.image.report();
  ++frames_;
  if (!options_.json_file.empty()) {
    cull_ms_.push_back(report.cull_ms);
    if (report.frame_ms > 0.0) frame_ms_.push_back(report.frame_ms);
  }
  history_.push_back({report.cull_ms, report.cull_ms + report.draw_ms, report.culler == engine::CullerChoice::kGpu,
                      session.image.visible(), report.items_drawn});
  if (history_.size() > kMostImages) history_.erase(history_.begin());
}

}  // namespace sightline::apps
