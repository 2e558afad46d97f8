#include "sightline/apps/regress/task_drawer.h"

#include "sightline/apps/common/need.h"
#include "sightline/apps/common/style_options.h"
#include "sightline/apps/common/tiled_image.h"
#include "sightline/apps/common/view_options.h"
#include "sightline/core/internal/clock.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestWhole = 4096;  // pixels
constexpr int kLeastForMetrics = 11;

/// Colours or ids of a reference. What is wrong with it goes to `unlike`.
std::optional<image::Image> read_reference(const fs::path& file, const image::Image& image, std::string& unlike) {
  std::error_code none;
  if (!fs::exists(file, none)) {
    unlike = "no reference: " + file.string();
    return std::nullopt;
  }
  auto reference = image::read_png(file);
  if (!reference) {
    unlike = reference.error().message;
    return std::nullopt;
  }
  if (reference->width == image.width && reference->height == image.height) return std::move(*reference);
  const auto size = [](const image::Image& of) { return std::to_string(of.width) + "x" + std::to_string(of.height); };
  unlike = file.string() + ": has " + size(*reference) + " pixels, the image " + size(image);
  return std::nullopt;
}

void compare(const Suite& suite, const Task& task, const image::Image& image, const image::Image& ids,
             TaskResult& result) {
  const auto reference = read_reference(suite.reference(task), image, result.unlike);
  if (!reference) return;
  result.difference = image::compare(image, *reference).value();
  if (result.difference.max > 0 && std::min(image.width, image.height) >= kLeastForMetrics)
    if (const auto metrics = image::image_metrics(*reference, image)) result.flip = metrics->flip_mean;
  if (!task.limits.ids) return;
  const auto other = read_reference(suite.id_reference(task), ids, result.unlike);
  if (other) result.wrong_ids = image::wrong_ids(image::ids_of_colours(*other), image::ids_of_colours(ids)).value();
}

}  // namespace

engine::ImageTiles TaskDrawer::prepare(const Task& task) {
  if (model_ != task.model) {
    engine_.reset();
    read_.reset();
    model_.reset();
    read_ = need(load_model(suite_.models[task.model].options));
    model_ = task.model;
  }
  engine::EngineConfig config;
  config.draw = true;
  if (task.standard_looks) config.drawing.looks = engine::Looks::standard();
  config.drawing.samples = task.standard_looks ? 1 : task.samples;
  config.drawing.ids = task.limits.ids.has_value();
  config.drawing.renderer = renderer_;
  config.context.platform = platform_;
  config.context.gl_state = engine::GlState::kLeave;  // no other context is current here
  config.culling.culler = engine::CullerChoice::kCpu;
  config.culling.occlusion = engine::OcclusionChoice::kOff;  // what it draws first depends on the frame before
  const bool whole = std::max(task.size[0], task.size[1]) <= kLargestWhole;
  auto tiles = need(tiles_for(task.size, whole ? kLargestWhole : kTileSide, config));
  if (engine_ && coloured_by_ == task.colour_by && engine_->config().drawing.samples == config.drawing.samples &&
      engine_->config().drawing.ids == config.drawing.ids) {
    need(engine_->resize(tiles.width, tiles.height));
    engine::EngineConfig changed = engine_->config();
    changed.drawing.looks = config.drawing.looks;
    need(engine_->configure(changed));
    return tiles;
  }
  config.width = tiles.width;
  config.height = tiles.height;
  engine_.reset();
  engine_ = need(engine::Engine::create(*read_->scene, config));
  need(apply_colours(task.colour_by, *read_->scene, *engine_));
  coloured_by_ = task.colour_by;
  return tiles;
}

TaskDrawer::Drawn TaskDrawer::draw(const Task& task) {
  auto tiles = prepare(task);
  const double aspect = double(task.size[0]) / task.size[1];
  const core::View view = task.view ? *task.view
                                    : need(core::View::fit(engine_->snapshot().bounds().fitted_bounds().bounds,
                                                           core::kOverviewDirection, kFovy, aspect));
  if (!task.allow_empty) need(check_sections(view, engine_->snapshot().bounds(), read_->offset));
  TiledImage image(
      view, std::move(tiles),
      {.ids = engine_->config().drawing.ids, .shifts = sample_shifts(task.standard_looks ? task.samples : 1)});
  Drawn drawn{{task.size[0], task.size[1], {}}, {task.size[0], task.size[1], {}}};
  while (!image.complete()) {
    if (!need(image.step(*engine_))) continue;
    const ImageRows& more = image.rows();
    drawn.image.pixels.insert(drawn.image.pixels.end(), more.colours.begin(), more.colours.end());
    drawn.ids.ids.insert(drawn.ids.ids.end(), more.ids.begin(), more.ids.end());
  }
  return drawn;
}

core::Expected<void> TaskDrawer::run(const Task& task) {
  const double begin = core::now_seconds();
  if (auto done = results_.make_place(task); !done) return done;
  TaskResult result;
  result.key = task.key;
  result.files_key = suite_.files_key(task);
  const auto drawn = attempt([&] { return draw(task); });
  if (!drawn) {
    model_.reset();  // the next task begins anew
    result.error = drawn.error().message;
    return results_.write(task, result);
  }
  result.renderer = engine_->renderer();
  if (auto done = image::write_png(drawn->image, results_.image(task)); !done) return done;
  image::Image id_colours;
  if (task.limits.ids) {
    auto colours = image::id_colours(drawn->ids);
    if (!colours) {
      result.error = colours.error().message;
      return results_.write(task, result);
    }
    id_colours = std::move(*colours);
    if (auto done = image::write_png(id_colours, results_.ids(task)); !done) return done;
  }
  compare(suite_, task, drawn->image, id_colours, result);
  result.seconds = core::now_seconds() - begin;
  return results_.write(task, result);
}

}  // namespace sightline::apps
