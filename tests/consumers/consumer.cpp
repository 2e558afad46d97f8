// An application outside the tree: everything it includes and links comes from the library's package.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/culling/box_culler.h"
#ifdef CONSUMER_DRAWS
#include "sightline/engine/engine.h"
#include "sightline/importers/import.h"
#include "sightline/render/image/image.h"
#endif

using namespace sightline;

namespace {

int fail(const char* what) {
  return std::fprintf(stderr, "consumer: %s\n", what), 1;
}

int cull_boxes() {
  std::vector<core::AabbD> boxes;
  for (int i = 0; i < 100; ++i) boxes.push_back({core::dvec3(i, 0, 0), core::dvec3(i + 0.5, 1, 1)});
  const auto culler = culling::BoxCuller::create(boxes);
  const auto view = core::View::perspective({{10, -10, 0.5}, {10, 0, 0.5}, {0, 0, 1}}, 0.5, 1.0, 0.1);
  if (!culler || !view) return fail("no culler or no view");
  std::vector<std::uint32_t> visible;
  culler->visible(*view, visible);
  return visible.size() >= 5 && visible.size() <= 7 ? 0 : fail("wrong boxes are visible");
}

#ifdef CONSUMER_DRAWS
int draw_model(const char* model, const char* image) {
  core::Scene scene;
  if (auto imported = importers::import_file(model, scene, scene.root()); !imported)
    return fail(imported.error().message.c_str());
  engine::EngineConfig config;
  config.draw = true;
  config.width = 160, config.height = 120;
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return fail(engine.error().message.c_str());
  const auto view = core::View::fit(scene.bounds(scene.root()), {1, 1, -0.5}, 0.8, 160.0 / 120.0);
  if (!view) return fail(view.error().message.c_str());
  if (auto report = engine->frame(*view); !report) return fail(report.error().message.c_str());
  if (!engine->covered().value_or(false)) return fail("the image shows nothing");
  const auto saved = image::write_png(*engine->read_colour(), image);
  return saved ? 0 : fail(saved.error().message.c_str());
}
#endif

}  // namespace

int main(int argc, char** argv) {
  if (const int status = cull_boxes(); status != 0) return status;
#ifdef CONSUMER_DRAWS
  if (argc == 3) return draw_model(argv[1], argv[2]);
#endif
  return argc == 1 ? 0 : fail("usage: consumer [MODEL IMAGE]");
}
