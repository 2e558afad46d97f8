#include "sightline/apps/view/export.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "sightline/apps/common/view_options.h"

namespace sightline::apps {
namespace {

constexpr int kLargestWhole = 2048;  // pixels: a step should be short

}  // namespace

Export::Export(Session& session, const Options& options, std::string target)
    : session_(&session),
      options_(options),
      target_(std::move(target)),
      background_(session.engine.config().drawing.looks.background),
      budget_ms_(session.engine.config().losses.budget_ms) {
  if (options.smooth && session.engine.config().drawing.samples == 1)
    shifts_ = SessionImage::shifts();
  else
    shifts_ = {core::dvec2(0.0)};
}

/// The engine still is as it was.
core::Expected<std::unique_ptr<Export>> Export::create(Session& session, const Options& options, std::string target) {
  const auto seen = session.image.view();
  if (!seen) return tl::unexpected(seen.error());
  if (auto kept = check_sections(*seen, session.engine.snapshot().bounds(), session.offset()); !kept)
    return tl::unexpected(kept.error());
  std::unique_ptr<Export> made(new Export(session, options, std::move(target)));
  const int side = std::max(options.size[0], options.size[1]) > kLargestWhole ? kTileSide : kLargestWhole;
  auto tiles = tiles_for(options.size, side, session.engine.config());
  if (!tiles) return tl::unexpected(tiles.error());
  made->tiles_ = std::move(*tiles);
  if (auto drawn = session.image.draw(); !drawn) return tl::unexpected(drawn.error());
  auto before = session.image.read(options.smooth);
  if (!before) return tl::unexpected(before.error());
  made->before_ = std::move(*before);
  return made;
}

core::Expected<std::unique_ptr<Export>> Export::image(Session& session, const Options& options,
                                                      const std::string& file) {
  auto made = create(session, options, file);
  if (!made) return made;
  if (auto done = (*made)->begin_frame(); !done) return tl::unexpected(done.error());
  return made;
}

core::Expected<std::unique_ptr<Export>> Export::frames(Session& session, const Options& options,
                                                       const core::CameraPath& path, double per_second,
                                                       const std::string& folder) {
  const auto frames = PathFrames::create(path, per_second);
  if (!frames) return tl::unexpected(frames.error());
  if (auto empty = take_empty_folder(folder); !empty) return tl::unexpected(empty.error());
  auto made = create(session, options, folder);
  if (!made) return made;
  (*made)->path_ = path;
  (*made)->frames_ = *frames;
  (*made)->count_ = frames->count();
  if (auto done = (*made)->begin_frame(); !done) return tl::unexpected(done.error());
  return made;
}

Export::~Export() {
  file_.reset();
  (void)session_->image.configure([this](engine::EngineConfig& config) {
    config.losses.budget_ms = budget_ms_;
    config.drawing.looks.background = background_;
  });
  (void)session_->engine.resize(session_->image.drawn_size()[0], session_->image.drawn_size()[1]);
}

core::Expected<void> Export::begin_frame() {
  Camera camera = session_->camera;
  std::filesystem::path file = target_;
  if (path_) {
    const core::CameraSample sample = path_->sample(frames_.time(frame_));
    camera.set_pose(sample.pose);
    camera.set_fovy(sample.fovy);
    camera.set_planes(path_->near, path_->far);
    camera.set_orthographic(false);
    file /= PathFrames::file_name(frame_);
  }
  const auto view = session_->image.view_of(camera, double(options_.size[0]) / options_.size[1]);
  if (!view) return tl::unexpected(view.error());
  auto opened = ColourFile::create(file.string(), options_.size[0], options_.size[1], transparent());
  if (!opened) return tl::unexpected(opened.error());
  engine::Engine& engine = session_->engine;
  if (engine.config().width != tiles_.width || engine.config().height != tiles_.height)
    if (auto done = engine.resize(tiles_.width, tiles_.height); !done) return done;
  const auto own = [this](engine::EngineConfig& config) {
    config.losses.budget_ms = 0.0;
    if (options_.background && !transparent()) config.drawing.looks.background = options_.background->colours;
  };
  if (engine.config().losses.budget_ms > 0.0 || options_.background)
    if (auto done = session_->image.configure(own); !done) return done;
  file_ = std::move(*opened);
  if (options_.marks) marks_ = options_.marks(*view, options_.size);
  image_.emplace(*view, tiles_, TiledImage::Wanted{.transparent = transparent(), .shifts = shifts_});
  return {};
}

core::Expected<void> Export::write(const ImageRows& rows) {
  if (marks_.empty()) return file_->write_rows(rows.colours);
  if (transparent()) return file_->write_rows(marked(rows));
  std::vector<std::uint8_t> painted = rows.colours;
  marks_.paint(painted, rows.width, rows.first);
  return file_->write_rows(painted);
}

/// Marks on a transparent image, as on black and on white.
std::vector<std::uint8_t> Export::marked(const ImageRows& rows) const {
  std::array<std::vector<std::uint8_t>, 2> on;
  for (std::size_t i = 0; i < rows.colours.size(); ++i) {
    if (i % 4 == 3) continue;
    const int alpha = rows.colours[i / 4 * 4 + 3], over_black = (rows.colours[i] * alpha + 127) / 255;
    on[0].push_back(std::uint8_t(over_black));
    on[1].push_back(std::uint8_t(over_black + 255 - alpha));
  }
  for (auto& pixels : on) marks_.paint(pixels, rows.width, rows.first);
  return with_alpha(on[0], on[1]);
}

core::Expected<void> Export::step() {
  const auto more = image_->step(session_->engine);
  if (!more) return tl::unexpected(more.error());
  if (*more)
    if (auto done = write(image_->rows()); !done) return done;
  if (!image_->complete()) return {};
  if (auto done = file_->finish(); !done) return done;
  blank_ = blank_ && !image_->covered();
  ++frame_;
  return complete() ? core::Expected<void>() : begin_frame();
}

double Export::progress() const {
  if (complete()) return 1.0;
  return (frame_ + double(image_->steps_done()) / double(image_->steps())) / count_;
}

}  // namespace sightline::apps
