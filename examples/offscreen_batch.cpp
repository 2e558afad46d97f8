// Images of a model from many sides, without a window or display: what a regression suite or a catalogue needs.
//   offscreen_batch MODEL FOLDER [COUNT]     writes FOLDER/view-0.png and so on; 4 unless COUNT says otherwise
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

#include "sightline/engine/engine.h"
#include "sightline/importers/import.h"
#include "sightline/render/image/image.h"

using namespace sightline;

namespace {

int complain(const std::string& message) {
  std::fprintf(stderr, "offscreen_batch: %s\n", message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc == 4 ? std::atoi(argv[3]) : 4;
  if ((argc != 3 && argc != 4) || count < 1)
    return std::fprintf(stderr, "usage: offscreen_batch MODEL FOLDER [COUNT]\n"), 2;
  core::Scene scene;
  const auto imported = importers::import_file(argv[1], scene, scene.root());
  if (!imported) return complain(imported.error().message);

  engine::EngineConfig config;
  config.draw = true;
  config.width = 480;
  config.height = 320;
  config.drawing.samples = 4;  // smooth edges
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return complain(engine.error().message);
  std::printf("drawn by %s\n", engine->renderer().c_str());

  const core::AabbD bounds = engine->snapshot().bounds().fitted_bounds().bounds;
  for (int i = 0; i < count; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / count;
    const core::dvec3 direction(std::cos(turn), std::sin(turn), -0.6);
    const auto view = core::View::fit(bounds, direction, 0.7, double(config.width) / config.height);
    if (!view) return complain(view.error().message);
    const auto report = engine->frame(*view);
    if (!report) return complain(report.error().message);
    const auto image = engine->read_colour();
    if (!image) return complain(image.error().message);
    const std::string file = std::string(argv[2]) + "/view-" + std::to_string(i) + ".png";
    if (const auto saved = image::write_png(*image, file); !saved) return complain(saved.error().message);
    std::printf("%s: %lld of %zu items in the view\n", file.c_str(), (long long)report->visible, scene.item_count());
  }
  return 0;
}
