#include "sightline/apps/bench/losses/subject.h"

#include <algorithm>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/common/need.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/engine/internal/rebuild.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::bench {

namespace {

engine::Engine make_engine(core::Scene& scene, const Subject::Config& c, bool levels) {
  engine::EngineConfig config = drawing_config(c.width, c.height, c.platform);
  config.culling.occlusion = engine::OcclusionChoice::kOn;  // without the trials of kAutomatic
  if (levels) config.losses.lod_error = 1.0;                // so that they are built
  engine::Engine engine = apps::need(engine::Engine::create(scene, config));
  apps::need(engine.finish_levels());
  return engine;
}

}  // namespace

Subject::Subject(core::Scene& scene, const Config& config, const LevelChain* chain)
    : engine_(make_engine(scene, config, !chain)),
      chain_(chain),
      culler_((chain ? chain->model() : engine_.snapshot()).bounds()),
      of_chain_(chain ? std::make_unique<culling::Hierarchy>(engine_.snapshot().bounds()) : nullptr),
      lines_(engine::slots_of_lines(engine_.snapshot())) {}

bool Subject::has_levels() {
  const auto meshes = engine::EngineParts::drawing(engine_)->scene().meshes().meshes();
  return std::ranges::any_of(meshes, [](const auto& mesh) { return lod::needs_levels(*mesh); });
}

core::Expected<Took> Subject::draw(const Rule& rule, const core::View& view) {
  using Measure = Rule::Measure;
  engine::Drawing& drawing = *engine::EngineParts::drawing(engine_);
  const core::Snapshot& snapshot = engine_.snapshot();
  const render::RenderTarget& target = drawing.target();
  drawing.set_losses(rule.losses());
  drawing.finish();
  const Took begin{milliseconds(), processor_milliseconds()};
  culler_.cull(view, visible_);
  visible_.generation = snapshot.generation();
  const core::VisibleSet* shown = &large_;
  switch (rule.measure) {
    case Measure::kBox:
      culling::ContributionTest(view, snapshot.bounds().origin, target.width(), target.height())
          .filter(snapshot.bounds(), visible_, float(rule.threshold), large_, {}, lines_);
      break;
    case Measure::kOpenSceneGraph:
    case Measure::kOpenCascade:
      keep_large(view, least_diagonal(rule, view, target.width(), target.height()), snapshot, visible_, large_);
      break;
    case Measure::kChain:
      chain_->choose({view, target.width(), target.height(), rule.threshold}, visible_, snapshot, large_);
      break;
    default:
      shown = &visible_;
  }
  engine::Frame frame{view, view, snapshot, lines_, of_chain_ ? of_chain_.get() : &culler_.hierarchy()};
  frame.all = false;
  const auto drawn = drawing.draw(frame, *shown);
  if (!drawn) return tl::unexpected(drawn.error());
  counts_ = drawn->counts;
  drawing.finish();
  return Took{milliseconds() - begin.ms, processor_milliseconds() - begin.processor_ms};
}

core::Expected<Took> Subject::draw_again(const Rule& rule, const core::View& view) {
  return draw(rule, view).and_then([&](const Took&) { return draw(rule, view); });
}

apps::DrawnImage Subject::image(const core::View& view, const std::vector<core::ItemId>& original) {
  apps::DrawnImage image = apps::need(apps::read_image(engine_, view));
  for (std::uint32_t& id : image.ids.ids)
    if (id > 0 && id <= original.size()) id = to_index(original[id - 1]) + 1;
  return image;
}

}  // namespace sightline::bench
