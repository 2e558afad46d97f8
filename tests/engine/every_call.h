// Every function of an engine that may need its context.
#pragma once

#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

namespace sightline::tests {

/// Calls them on an engine with a context of its own, and `check` after each, with its name. The culler should be one
/// of the CPU's.
inline void make_every_call(core::Scene& scene, engine::EngineConfig config, const core::View& view,
                            const std::function<void(const std::string&)>& check) {
  config.draw = config.drawing.ids = true;
  config.losses.min_projected_area = 1.0f;  // so that loss() has something to tell
  const auto works = [&](const char* name, const auto& result) {
    EXPECT_TRUE(result) << name << ": " << result.error().message;
    check(name);
  };
  {
    auto engine = engine::Engine::create(scene, config);
    works("create", engine);
    if (!engine) return;
    works("frame", engine->frame(view));
    works("frame", engine->frame(view));
    works("read_colour", engine->read_colour());
    works("read_ids", engine->read_ids());
    works("read_depth", engine->read_depth(view));
    works("covered", engine->covered());
    works("framebuffer", engine->framebuffer());
    works("loss", engine->loss(view));
    works("cull_states", engine->cull_states(view));
    works("frame_tile", engine->frame_tile(view, {config.width, config.height, 0, 0}));
    const core::ItemId item[] = {scene.add_primitive(scene.root(), core::Sphere{0.5f}, {})};
    works("commit", engine->commit());
    works("set_override", engine->set_override(item, {.colour = core::vec3(1.0f, 0.0f, 0.0f)}));
    works("clear_override", engine->clear_override(item));
    works("hide", engine->hide(item));
    works("show", engine->show(item));
    works("rebuild", engine->rebuild());
    works("resize", engine->resize(config.width + 3, config.height));
    engine::EngineConfig changed = engine->config();
    changed.losses.min_projected_area = 0.0f;
    works("configure", engine->configure(changed));
    works("set_culler", engine->set_culler(engine::CullerChoice::kGpu));
    works("frame culled by the GPU", engine->frame(view));
    engine->finish();
    check("finish");
    works("finish_levels", engine->finish_levels());
    (void)engine->take_late_report();
    check("take_late_report");
    EXPECT_FALSE(engine->renderer().empty());
    check("renderer");
    for (const std::string& error : engine->take_gl_errors()) ADD_FAILURE() << error;
    check("take_gl_errors");
    (void)engine->memory();
    check("memory");
    engine::Engine moved = std::move(*engine);
    check("move");
  }
  check("the engine's end");
  auto dropped = engine::Engine::create(scene, config);
  works("create", dropped);
  if (!dropped) return;
  dropped->drop_context();
  check("drop_context");
  works("frame that makes a context anew", dropped->frame(view));
}

}  // namespace sightline::tests
