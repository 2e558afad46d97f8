// sightline-bench context: what a context without a window offers on this machine, and how long it takes to make one.
#include "sightline/gl/context.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/gl/functions.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench::context_bench {
namespace {

using Json = json::Value;

struct Options {
  gl::ContextPlatform platform = {};
  std::string json;
};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_context_option(line, o.platform);
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-bench context\n"
      "  sightline-bench context --context egl-device --json -");
}

/// Sizes are in the units that gl::Capabilities names.
Json limits_json(const gl::Capabilities& caps) {
  return {{"software", caps.software},
          {"indirect_count", caps.indirect_count},
          {"shader_draw_parameters", caps.shader_draw_parameters},
          {"robust_access", caps.robust_access},
          {"reset_notification", caps.reset_notification},
          {"max_texture_buffer_texels", caps.max_texture_buffer_texels},
          {"max_storage_block_bytes", caps.max_storage_block_bytes},
          {"max_uniform_block_bytes", caps.max_uniform_block_bytes},
          {"max_vertex_storage_blocks", caps.max_vertex_storage_blocks},
          {"max_geometry_output_vertices", caps.max_geometry_output_vertices},
          {"max_geometry_output_components", caps.max_geometry_output_components},
          {"max_clip_distances", caps.max_clip_distances},
          {"max_texture_size", caps.max_texture_size},
          {"max_viewport", {caps.max_viewport_width, caps.max_viewport_height}},
          {"max_samples", caps.max_samples},
          {"max_integer_samples", caps.max_integer_samples},
          {"subpixel_bits", caps.subpixel_bits},
          {"uniform_offset_alignment", caps.uniform_offset_alignment},
          {"storage_offset_alignment", caps.storage_offset_alignment}};
}

Json to_json(const gl::Context& context, double milliseconds) {
  std::vector<std::string> extensions = gl::list_extensions(context.functions());
  std::sort(extensions.begin(), extensions.end());
  return {{"platform", context.platform()}, {"vendor", context.vendor()},
          {"renderer", context.renderer()}, {"version", context.version()},
          {"milliseconds", milliseconds},   {"limits", limits_json(context.capabilities())},
          {"extensions", extensions}};
}

/// A line for the context and for each limit, and one for all extensions.
void print(const Json& json, std::FILE* out) {
  for (const char* name : {"platform", "vendor", "renderer", "version"})
    std::fprintf(out, "%s: %s\n", name, json[name].get<std::string>().c_str());
  std::fprintf(out, "made in: %.1f ms\n", json["milliseconds"].get<double>());
  for (const auto& [name, value] : json["limits"].items())
    std::fprintf(out, "%s: %s\n", name.c_str(), value.dump().c_str());
  std::string names;
  for (const Json& name : json["extensions"]) names += " " + name.get<std::string>();
  std::fprintf(out, "%zu extensions:%s\n", json["extensions"].size(), names.c_str());
}

core::Expected<int> run(const Options& o) {
  const auto begin = std::chrono::steady_clock::now();
  const auto context = gl::Context::create_offscreen({.platform = o.platform});
  if (!context) return tl::unexpected(context.error());
  const double milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return finish(o.json, to_json(*context, milliseconds), print);
}

}  // namespace
}  // namespace sightline::bench::context_bench

sightline::bench::Run sightline::bench::add_context(apps::CommandLine& line) {
  using namespace context_bench;
  return add_subcommand<Options>(line, add_options, run);
}
