// sightline-study embedding: what a frame costs more in a context of the application's: giving its state back, and
// putting the image into its framebuffer. The same views in turns, the medians of all; each frame is waited for.
#include <array>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/renderer.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/camera_path.h"
#include "sightline/engine/engine.h"
#include "sightline/gl/external_target.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/study/parts/parts.h"

namespace sightline::bench::embedding_bench {
namespace {

using Json = json::Value;
using engine::Engine;
using engine::GlState;

struct Options {
  std::uint64_t items = 1000;
  std::array<int, 2> size{1280, 720};
  int frames = 100, samples = 1;
  std::string json_file;
};

void add_options(apps::CommandLine& line, Options& o) {
  line.add("--items", o.items, "Of the generated plant").shows_default().in_range(1000, 10000000);
  line.add("--width", o.size[0], "Of the image, pixels").shows_default().in_range(1, 16384);
  line.add("--height", o.size[1], "Of the image, pixels").shows_default().in_range(1, 16384);
  line.add("--samples", o.samples, "Per pixel, of the image").shows_default().in_range(1, 32);
  line.add("--frames", o.frames, "Views of the tour").shows_default().in_range(2, 100000);
  apps::add_json_option(line, o.json_file);
  line.examples(
      "  sightline-study embedding\n"
      "  sightline-study embedding --items 100000 --samples 4 --json embedding.json");
}

/// An application's framebuffer.
struct Window {
  gl::Texture2D colour, depth;
  gl::Framebuffer framebuffer;
};
core::Expected<Window> make_window(const gl::Functions& gl, const std::array<int, 2>& size) {
  auto colour = gl::Texture2D::create(gl, size[0], size[1], GL_RGBA8, "window colour");
  if (!colour) return tl::unexpected(colour.error());
  auto depth = gl::Texture2D::create(gl, size[0], size[1], GL_DEPTH_COMPONENT24, "window depth");
  if (!depth) return tl::unexpected(depth.error());
  Window window{std::move(*colour), std::move(*depth), {}};
  const gl::Attachment attachments[] = {{GL_COLOR_ATTACHMENT0, &window.colour}, {GL_DEPTH_ATTACHMENT, &window.depth}};
  auto framebuffer = gl::Framebuffer::create(gl, attachments, "window");
  if (!framebuffer) return tl::unexpected(framebuffer.error());
  window.framebuffer = std::move(*framebuffer);
  return window;
}

struct Mode {
  const char* name;
  GlState state;
  bool target;
  bool empty;  // a view of nothing: what is left is what a frame costs without a scene
  std::vector<double> ms = {};
};

core::Expected<void> fly(Mode& mode, core::Scene& scene, gl::Context& context, const Window& window, const Options& o) {
  engine::EngineConfig config;
  config.draw = true;
  config.context.application = &context;
  config.context.gl_state = mode.state;
  config.width = o.size[0];
  config.height = o.size[1];
  config.drawing.samples = o.samples;
  auto engine = Engine::create(scene, config);
  if (!engine) return tl::unexpected(engine.error());
  const core::ItemBounds& bounds = engine->snapshot().bounds();
  const core::CameraPath path = core::make_tour(bounds, bounds.fitted_bounds());
  const double aspect = double(o.size[0]) / o.size[1];
  const core::View nothing = *core::View::perspective({{0, 0, -1e6}, {0, 0, -2e6}, {0, 1, 0}}, 0.8, aspect, 1.0);
  gl::ExternalTarget target{window.framebuffer.id(), 0, 0, o.size[0], o.size[1]};
  target.clear_colour = target.clear_depth = true;
  for (int i = 0; i < o.frames; ++i) {
    const core::View view = mode.empty ? nothing : *path.view(path.time_of(i, o.frames), aspect);
    const double begin = milliseconds();
    const auto report = mode.target ? engine->frame(view, target) : engine->frame(view);
    if (!report) return tl::unexpected(report.error());
    context.functions().Finish();
    if (i > 0) mode.ms.push_back(milliseconds() - begin);  // the first compiles shaders
  }
  return {};
}

void print(const Json& json, std::FILE* out) {
  std::fprintf(out, "%-44s %9s %9s %9s\n", "ms a frame", "p50", "p90", "least");
  for (const Json& row : json["modes"])
    std::fprintf(out, "%-44s %9.3f %9.3f %9.3f\n", row["mode"].get<std::string>().c_str(), row["p50_ms"].get<double>(),
                 row["p90_ms"].get<double>(), row["least_ms"].get<double>());
}

core::Expected<int> run(const Options& o) {
  core::Scene scene;
  if (auto made = importers::generate_plant({o.items, 1}, scene); !made) return tl::unexpected(made.error());
  auto context = gl::Context::create_offscreen();
  if (!context) return tl::unexpected(context.error());
  auto window = make_window(context->functions(), o.size);
  if (!window) return tl::unexpected(window.error());
  Mode modes[] = {{"nothing in view, state left", GlState::kLeave, false, true},
                  {"nothing in view, state restored", GlState::kRestore, false, true},
                  {"nothing in view, restored, into a framebuffer", GlState::kRestore, true, true},
                  {"tour, state left", GlState::kLeave, false, false},
                  {"tour, state restored", GlState::kRestore, false, false},
                  {"tour, restored, into a framebuffer", GlState::kRestore, true, false}};
  constexpr int kTurns = 5;
  for (int turn = 0; turn < kTurns; ++turn)
    for (Mode& mode : modes)
      if (auto done = fly(mode, scene, *context, *window, o); !done) return tl::unexpected(done.error());
  Json json = renderer_json(*context);
  json.update({{"items", o.items}, {"size", o.size}, {"samples", o.samples}, {"views", o.frames}, {"turns", kTurns}});
  for (Mode& mode : modes) {
    std::sort(mode.ms.begin(), mode.ms.end());
    const auto at = [&](double share) { return mode.ms[std::size_t(share * double(mode.ms.size() - 1))]; };
    json["modes"].push_back({{"mode", mode.name}, {"p50_ms", at(0.5)}, {"p90_ms", at(0.9)}, {"least_ms", at(0.0)}});
  }
  return finish(o.json_file, json, print);
}

}  // namespace
}  // namespace sightline::bench::embedding_bench

sightline::bench::Run sightline::bench::add_embedding(apps::CommandLine& line) {
  using namespace embedding_bench;
  return add_subcommand<Options>(line, add_options, run);
}
