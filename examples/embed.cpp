// The smallest program that embeds Sightline: read a model, cull and draw one view of it, save the image.
//   embed MODEL.rvm OUT.png
#include <cstdio>

#include "sightline/engine/engine.h"
#include "sightline/importers/import.h"
#include "sightline/render/image/image.h"

using namespace sightline;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: embed MODEL OUT.png\n"), 2;
  core::Scene scene;
  auto imported = importers::import_file(argv[1], scene, scene.root());
  if (!imported) return std::fprintf(stderr, "%s\n", imported.error().message.c_str()), 1;

  engine::EngineConfig config;
  config.draw = true;
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return std::fprintf(stderr, "%s\n", engine.error().message.c_str()), 1;

  auto view = core::View::fit(scene.bounds(scene.root()), core::kOverviewDirection, 0.9, 1280.0 / 720.0);
  auto report = engine->frame(*view);
  if (!report) return std::fprintf(stderr, "%s\n", report.error().message.c_str()), 1;
  std::printf("%llu items visible, culled in %.3f ms\n", (unsigned long long)report->visible, report->cull_ms);
  auto image = engine->read_colour();
  auto saved = image ? image::write_png(*image, argv[2]) : tl::unexpected(image.error());
  return saved ? 0 : 1;
}
