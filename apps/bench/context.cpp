// sightline-bench context: what a context without a window offers on this machine, and how long it takes to make one.
#include "sightline/gl/context.h"

#include <chrono>
#include <string>

#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/gl_page.h"
#include "sightline/apps/common/model.h"

namespace sightline::bench::context_bench {
namespace {

struct Options {
  gl::ContextPlatform platform = {};
  std::string json;
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench context\n"
      "  sightline-bench context --context-platform egl-device --json -");
}

core::Expected<int> run(const Options& o) {
  const auto begin = std::chrono::steady_clock::now();
  auto context = gl::Context::create_offscreen({.platform = o.platform});
  if (!context) return tl::unexpected(context.error());
  const double milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  context->test_driver();
  return finish(o.json, apps::gl_page(*context, milliseconds), apps::print_gl_page);
}

}  // namespace
}  // namespace sightline::bench::context_bench

sightline::bench::Run sightline::bench::add_context(apps::CommandLine& line) {
  using namespace context_bench;
  return add_subcommand<Options>(line, add_options, run);
}
