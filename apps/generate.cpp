// sightline-generate: a synthetic process plant as an RVM file.

#include <charconv>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "sightline/apps/common/cli.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/rvm_writer.h"

namespace {

using namespace sightline;

/// CLI11 alone would wrap negative numbers and clamp large ones, which makes another plant than requested.
core::Expected<std::uint64_t> parse_seed(const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, seed);
  if (error != std::errc() || stop != end)
    return core::fail("expected a whole number from 0 to 18446744073709551615, found \"" + text + "\"");
  return seed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Generates a process plant (pipe racks, vessels, steel, handrails), the same for the same seed",
               "sightline-generate");
  apps::describe(
      app, "  sightline-generate --items 100000 plant.rvm\n  sightline-generate --items 1000000 --seed 7 big.rvm");
  importers::PlantConfig config;
  std::string output, json_file;
  app.add_option("OUTPUT", output, "RVM file to write")->required();
  app.add_option("--items", config.items, "Number of items, 1000 to 10000000")
      ->capture_default_str()
      ->check(CLI::Range(1000, 10000000));
  app.add_option("--seed", config.seed, "Another seed gives another plant")
      ->capture_default_str()
      ->check(apps::accepted_by(parse_seed));
  app.add_option("--json", json_file, "Write what was generated as JSON to FILE, or - for stdout");
  return apps::run(app, argc, argv, [&]() -> core::Expected<int> {
    core::Scene scene;
    if (auto done = importers::generate_plant(config, scene); !done) return tl::unexpected(done.error());
    if (auto done = importers::write_rvm(scene, scene.root(), output); !done) return tl::unexpected(done.error());
    if (json_file != "-") std::printf("%s: %zu items\n", output.c_str(), scene.item_count());
    const nlohmann::json facts = {{"file", output}, {"items", scene.item_count()}, {"seed", config.seed}};
    if (auto done = apps::write_json(json_file, facts); !done) return tl::unexpected(done.error());
    return apps::kExitOk;
  });
}
