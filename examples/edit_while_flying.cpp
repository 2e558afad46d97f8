// Edits between frames: a crane drives along a hall of columns and lifts a pipe while the camera flies past. Only what
// changed is uploaded; culler and ray tracer follow.
//   edit_while_flying OUT.png      the last of 60 frames
#include <cstdio>
#include <string>
#include <vector>

#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

using namespace sightline;

namespace {

int complain(const std::string& message) {
  std::fprintf(stderr, "edit_while_flying: %s\n", message.c_str());
  return 1;
}

struct Hall {
  core::NodeId crane, hook;
};

Hall build(core::Scene& scene) {
  const auto steel = scene.add_material({"steel", {0.55f, 0.6f, 0.65f}, 1.0f});
  const auto yellow = scene.add_material({"yellow", {0.95f, 0.75f, 0.1f}, 1.0f});
  const auto red = scene.add_material({"red", {0.8f, 0.2f, 0.15f}, 1.0f});
  const core::NodeId hall = scene.add_node(scene.root(), "hall");
  scene.add_primitive(hall, core::Box{120.0f, 24.0f, 0.5f}, core::translation({60.0, 0.0, -0.25}));
  for (int i = 0; i < 25; ++i)
    for (const double side : {-10.0, 10.0})
      scene.add_primitive(hall, core::Cylinder{0.4f, 9.0f}, core::translation({5.0 * i, side, 4.5}), steel);
  for (const double side : {-10.0, 10.0})
    scene.add_primitive(hall, core::Box{120.0f, 0.8f, 0.8f}, core::translation({60.0, side, 9.4}), steel);

  const core::NodeId crane = scene.add_node(scene.root(), "crane");
  scene.add_primitive(crane, core::Box{2.0f, 21.0f, 1.2f}, core::translation({0.0, 0.0, 10.4}), yellow);
  const core::NodeId hook = scene.add_node(crane, "hook");
  scene.add_primitive(hook, core::Cylinder{0.05f, 6.0f}, core::translation({0.0, 0.0, 3.0}));
  scene.add_primitive(hook, core::Sphere{1.6f}, core::translation({0.0, 0.0, 0.0}), red);
  return {crane, hook};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: edit_while_flying OUT.png\n"), 2;
  core::Scene scene;
  const Hall hall = build(scene);
  engine::EngineConfig config;
  config.draw = true;
  config.width = 480;
  config.height = 320;
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return complain(engine.error().message);

  for (int frame = 0; frame < 60; ++frame) {
    const double t = frame / 59.0;
    scene.set_transform(hall.crane, core::translation({20.0 + 50.0 * t, 0.0, 0.0}));
    scene.set_transform(hall.hook, core::translation({0.0, -6.0 + 9.0 * t, 5.0 - 2.0 * t}));
    if (const auto committed = engine->commit(); !committed) return complain(committed.error().message);
    const auto view =
        core::View::perspective({{-6.0 + 40.0 * t, -4.0, 5.5}, {70.0, 1.0, 5.0}, {0, 0, 1}}, 0.9, 1.5, 0.2);
    if (!view) return complain(view.error().message);
    if (const auto report = engine->frame(*view); !report) return complain(report.error().message);
  }
  const auto image = engine->read_colour();
  if (!image) return complain(image.error().message);
  const auto saved = image::write_png(*image, argv[1]);
  return saved ? 0 : complain(saved.error().message);
}
