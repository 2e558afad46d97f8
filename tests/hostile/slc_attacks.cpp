// Scene caches whose checksums of header, table and end are right, so that damage gets past them.
#include <cstring>

#include "sightline/core/snapshot.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/tests/hostile/attack.h"
#include "sightline/tests/importers/slc_seal.h"

namespace sightline::hostile {
namespace {

std::string sealed_cache(std::string bytes) {
  tests::make_current(std::as_writable_bytes(std::span(bytes)));
  tests::reseal(std::as_writable_bytes(std::span(bytes)));
  return bytes;
}

/// A word of the table of arrays becomes another.
Attack absurd_counts(const std::string& cache) {
  std::uint64_t table = 0, size = 0;
  std::memcpy(&table, cache.data() + cache.size() - 64, 8);
  std::memcpy(&size, cache.data() + cache.size() - 56, 8);
  return {"absurd_counts", 5 * size / 8, [cache, table](std::size_t k) {
            constexpr std::uint64_t kCounts[] = {0, 1, 1ull << 32, 1ull << 61, ~0ull};
            std::string bytes = cache;
            std::memcpy(bytes.data() + table + 8 * (k / 5), &kCounts[k % 5], 8);
            return one_file("model.slc", sealed_cache(bytes));
          }};
}

/// The ways to read a scene cache beside read_slc(), and what applications do with the result.
void use_cache(std::span<const std::byte> bytes) {
  const auto file = importers::SlcFile::of_bytes(bytes);
  if (!file) return;
  const auto use_pages = [](const core::PagedScene& paged) {
    for (std::uint32_t page = 0; page < paged.pages.size(); ++page)
      if (const auto read = paged.load(page))
        for (core::Slot slot = 0; slot < (*read)->snapshot.size(); ++slot)
          (void)(*read)->snapshot.world_from_item(slot);
  };
  if (const auto paged = importers::open_paged_scene(*file, "hostile.slc", false)) {
    use_pages(*paged);
    if (paged->coarse) use_pages(*paged->coarse);
  }
  for (const bool verified : {true, false}) {
    auto loaded = importers::load(*file, verified);
    if (!loaded) continue;
    core::Scene scene;  // as the only scene, with the stored snapshot
    scene.append(scene.root(), std::move(loaded->scene));
    if (!scene.commit() || core::Snapshot(scene).size() != scene.item_count()) std::abort();
    scene.for_each_node(scene.root(), [&](core::NodeId node, auto&&...) {
      (void)scene.path(node);
      (void)scene.attributes(node);
    });
  }
}

}  // namespace

std::vector<Target> slc_targets() {
  Target target;
  target = {.format = "slc",
            .extension = ".slc",
            .read = importers::read_slc,
            // The file is copied, each mapping is a copy, and what is read from it is little more.
            .memory_factor = 16,
            .memory_constant = 1 << 20,
            .mutations = 3000,
            .needs =
                [](std::string_view seed) {
                  return Needs{seed.size(), seed.size()};
                },
            .seal = sealed_cache,
            .use = use_cache};
  target.attacks = {absurd_counts(seeds_of(target).front())};
  return {target};
}

}  // namespace sightline::hostile
