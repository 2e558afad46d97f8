#include "sightline/apps/common/gl_page.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "sightline/gl/functions.h"

namespace sightline::apps {
namespace {

using Json = json::Value;

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

Json checks_json(const gl::DriverTest& test) {
  constexpr const char* kWords[] = {"not run", "passed", "failed"};
  Json checks = Json::object();
  for (std::size_t i = 0; i < gl::kDriverCheckCount; ++i)
    checks[std::string(name_of(gl::DriverCheck(i)))] = kWords[std::size_t(test.results[i])];
  return checks;
}

/// All that there are, with why each is on or off.
Json workarounds_json(const gl::Context& context) {
  Json rows = Json::array();
  for (const gl::WorkaroundFacts& facts : gl::workaround_facts()) {
    const bool forced = context.workaround_switches().named[facts.workaround];
    rows.push_back({{"name", facts.name},
                    {"on", context.functions().workarounds[facts.workaround]},
                    {"why", forced ? "by switch" : "by self-test " + std::string(name_of(facts.check))},
                    {"fault", facts.fault},
                    {"way", facts.way},
                    {"report", facts.report}});
  }
  return rows;
}

}  // namespace

Json gl_page(const gl::Context& context, std::optional<double> milliseconds) {
  std::vector<std::string> extensions = gl::list_extensions(context.functions());
  std::sort(extensions.begin(), extensions.end());
  const gl::DriverTest& test = context.driver_test();
  Json page{{"platform", context.platform()},
            {"vendor", context.vendor()},
            {"renderer", context.renderer()},
            {"version", context.version()}};
  if (milliseconds) page["milliseconds"] = *milliseconds;
  page.update(
      {{"limits", limits_json(context.capabilities())},
       {"self_test", {{"checks", checks_json(test)}, {"milliseconds", test.ms}, {"remembered", test.remembered}}},
       {"workarounds", workarounds_json(context)},
       {"extensions", extensions}});
  return page;
}

std::string gl_page_text(const Json& page) {
  std::string text;
  for (const char* name : {"platform", "vendor", "renderer", "version"})
    text += fmt::format("{:<32} {}\n", name, page[name].get<std::string>());
  if (page.contains("milliseconds"))
    text += fmt::format("{:<32} {:.1f} ms\n", "made in", page["milliseconds"].get<double>());
  text += fmt::format("{:<32} {}\n", "extensions", page["extensions"].size());
  text += "\nLimits\n";
  for (const auto& [name, value] : page["limits"].items()) text += fmt::format("  {:<30} {}\n", name, value.dump());
  const Json& test = page["self_test"];
  text += test["remembered"].get<bool>() ? std::string("\nSelf-test (remembered from an earlier run)\n")
                                         : fmt::format("\nSelf-test ({:.1f} ms)\n", test["milliseconds"].get<double>());
  for (const auto& [name, value] : test["checks"].items())
    text += fmt::format("  {:<30} {}\n", name, value.get<std::string>());
  text += "\nWorkarounds\n";
  for (const Json& row : page["workarounds"]) {
    const bool on = row["on"].get<bool>();
    text += fmt::format("  {:<30} {}, {}{}\n", row["name"].get<std::string>(), on ? "on" : "off",
                        row["why"].get<std::string>(), on ? ": " + row["fault"].get<std::string>() : std::string());
  }
  return text;
}

void print_gl_page(const Json& page, std::FILE* out) {
  std::fputs(gl_page_text(page).c_str(), out);
}

}  // namespace sightline::apps
