// sightline-generate: a synthetic process plant as an RVM file or scene caches.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/importers/slc/paged_scene.h"
#include "sightline/importers/slc/slc_writer.h"

namespace {

using namespace sightline;
using apps::need, apps::fail;

/// The option alone would wrap negative numbers and clamp large ones, which makes another plant than requested.
core::Expected<std::uint64_t> parse_seed(const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, seed);
  if (error != std::errc() || stop != end)
    return core::fail("expected a whole number from 0 to 18446744073709551615, found \"" + text + "\"");
  return seed;
}

constexpr std::uint64_t kFewestItems = 1000, kMostItems = 10'000'000, kMostParts = 99'999;  // items of each part

struct Options {
  importers::PlantOptions config;
  int parts = 1;
  std::string output, json_file;
};

/// Plants stand side by side on a ground of about equal sides; each is at most 400 x 100 m.
core::dvec3 place_of_part(int part, int parts) {
  constexpr double kPitchX = 420.0, kPitchY = 120.0;
  const int columns = std::max(1, int(std::lround(std::sqrt(parts * kPitchY / kPitchX))));
  return {kPitchX * (part % columns), kPitchY * (part / columns), 0.0};
}

std::size_t write_plant(const importers::PlantOptions& config, const core::dvec3& place,
                        const std::filesystem::path& output) {
  core::Scene scene;
  need(importers::generate_plant(config, scene));
  core::Affine moved;
  moved.origin = place;
  scene.set_transform(scene.root(), moved);
  const bool cache = output.extension() == ".slc";
  need(cache ? importers::write_slc(scene, output) : importers::write_rvm(scene, scene.root(), output));
  return scene.item_count();
}

std::string name_of_part(int part) {
  char name[32];
  std::snprintf(name, sizeof name, "part-%05d.slc", part + 1);
  return name;
}

/// All caches of a folder are one model: those of another one must not stay among them.
void take_folder(const Options& o) {
  need(apps::make_directory(o.output));
  std::set<std::string> own;
  for (int part = 0; part < o.parts; ++part) own.insert(name_of_part(part));
  const auto caches = importers::scene_caches_of(core::platform::path_of(o.output));
  if (!caches) return;  // there is none
  for (const std::filesystem::path& cache : *caches)
    if (!own.contains(cache.filename().string()))
      fail(cache.string() + ": expected a folder without scene caches of another model");
}

/// Plant by plant, so that memory holds one of them alone.
std::size_t write_parts(const Options& o) {
  take_folder(o);
  apps::Progress progress("generating", std::size_t(o.parts));
  std::size_t items = 0;
  for (int part = 0; part < o.parts; ++part) {
    importers::PlantOptions config = o.config;
    config.items = o.config.items / std::uint64_t(o.parts) +
                   (std::uint64_t(part) < o.config.items % std::uint64_t(o.parts) ? 1 : 0);
    config.seed = o.config.seed + std::uint64_t(part);
    items += write_plant(config, place_of_part(part, o.parts), core::platform::path_of(o.output) / name_of_part(part));
    progress.advance(std::size_t(part) + 1);
  }
  return items;
}

core::Expected<int> generate(const Options& o) {
  const std::size_t items =
      o.parts > 1 ? write_parts(o) : write_plant(o.config, core::dvec3(0.0), core::platform::path_of(o.output));
  if (o.json_file != "-") std::printf("%s: %zu items\n", o.output.c_str(), items);
  const json::Value facts = {{"file", o.output}, {"items", items}, {"seed", o.config.seed}, {"parts", o.parts}};
  need(apps::write_json(o.json_file, json::sorted(facts)));
  return apps::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "Generates a process plant (pipe racks, vessels, steel, handrails), the same for the same seed",
      "sightline-generate",
      "  sightline-generate --items 100000 plant.rvm\n"
      "  sightline-generate --items 1000000 --seed 7 big.rvm\n"
      "  sightline-generate --items 100000000 --parts 100 huge    # a folder of .slc, for --memory");
  Options o;
  line.add("OUTPUT", o.output, "RVM file or scene cache (.slc) to write; with --parts a folder of caches").required();
  line.add("--items", o.config.items, "Number of items, 1000 to 10000000 for each part")
      .shows_default()
      .in_range(kFewestItems, kMostItems * kMostParts);
  line.add("--parts", o.parts, "Plants side by side, each a scene cache, which are made one after the other")
      .shows_default()
      .in_range(1, int(kMostParts));
  line.add("--seed", o.config.seed, "Another seed gives another plant").shows_default().accepted_by(parse_seed);
  apps::add_json_option(line, o.json_file);
  line.check([&]() -> core::Expected<void> {
    const auto parts = std::uint64_t(o.parts);
    if (o.config.items < parts * kFewestItems || o.config.items > parts * kMostItems)
      return core::fail("--items: expected " + std::to_string(parts * kFewestItems) + " to " +
                        std::to_string(parts * kMostItems) + " for " + std::to_string(parts) +
                        (parts > 1 ? " parts" : " part"));
    return {};
  });
  return line.run(argc, argv, [&] { return generate(o); });
}
