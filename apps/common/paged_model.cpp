#include "sightline/apps/common/paged_model.h"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/progress.h"
#include "sightline/core/internal/platform/process.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/slc/paged_scene.h"

namespace sightline::apps {

core::Expected<std::size_t> parse_bytes(const std::string& text) {
  const char* const end = text.data() + text.size();
  double number = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  const std::string unit(stop, end);
  constexpr std::string_view kUnits = "KMGT";
  const auto power = unit.empty() ? std::size_t(0) : kUnits.find(unit[0]) + 1;
  const double bytes = std::ldexp(number, int(10 * power));
  if (error != std::errc() || unit.size() > 1 || power > kUnits.size() || !(bytes >= 1.0) || bytes > 0x1p60)
    return core::fail("expected bytes such as 800M or 2G, found \"" + text + "\"");
  return std::size_t(bytes);
}

void add_memory_option(CommandLine& line, std::string& text) {
  const Option memory =
      line.add("--memory", text,
               "Draw a scene cache (.slc, or a folder of them) page by page, within so much memory, such as 2G")
          .metavar("LIMIT")
          .accepted_by(parse_bytes);
  line.mode(memory, {OptionGroup::kGeneral, OptionGroup::kPaged});
}

namespace {

bool is_cache_or_folder(const std::string& file) {
  std::error_code unknown;
  if (std::filesystem::is_directory(file, unknown)) return true;
  return importers::lower_case_extension(file) == ".slc";
}

}  // namespace

core::Expected<engine::PagedEngine> open_paged(const ModelOptions& model, const std::string& memory,
                                               const engine::PagedConfig& config) {
  const auto limit = parse_bytes(memory);
  if (!limit) return tl::unexpected(limit.error());
  const std::string& file = model.files.front();
  if (model.files.size() != 1 || !is_cache_or_folder(file))
    return core::fail("--memory: expected one scene cache or a folder of them, found " +
                      (model.files.size() != 1 ? std::to_string(model.files.size()) + " files" : file) +
                      "; sightline-convert writes .slc");
  core::platform::allow_many_files();  // the many parts of a folder are open at once
  Progress progress("opening", 100);
  auto scene = importers::open_paged_scene(file, [&](double share) {
    progress.advance(std::size_t(100.0 * share));
    return true;
  });
  if (!scene) return tl::unexpected(scene.error());
  engine::PagedConfig limited = config;
  limited.memory_limit = *limit;
  return engine::PagedEngine::create(std::move(*scene), limited);
}

core::Expected<void> page_errors(engine::PagedEngine& engine) {
  const auto errors = engine.take_errors();
  if (errors.empty()) return {};
  return core::fail(errors.front() +
                    (errors.size() > 1 ? "; and " + std::to_string(errors.size() - 1) + " more pages" : std::string()));
}

}  // namespace sightline::apps
