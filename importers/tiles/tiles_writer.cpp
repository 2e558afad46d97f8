#include "sightline/importers/tiles/tiles_writer.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/importers/gltf/internal/gltf_collections_writer.h"
#include "sightline/importers/import.h"
#include "sightline/importers/tiles/internal/new_folder.h"
#include "sightline/importers/tiles/internal/tile_content.h"
#include "sightline/importers/tiles/internal/tile_items.h"
#include "sightline/importers/tiles/internal/tile_shapes.h"
#include "sightline/importers/tiles/internal/tile_tree.h"
#include "sightline/importers/tiles/internal/tileset_json.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;

/// Triangles that an item counts as, however few it has: names and placements take bytes, too.
constexpr std::uint64_t kItemCost = 32;
constexpr const char* kTilesetName = "tileset.json";
constexpr const char* kContentFolder = "tiles";

/// Whether a folder holds what this writer wrote, and nothing else.
bool is_own_tileset(const fs::path& folder) {
  std::error_code reason;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, reason))
    if (entry.path().filename() != kTilesetName && entry.path().filename() != kContentFolder) return false;
  std::string begin(kTilesetBegin.size(), ' ');
  std::ifstream(folder / kTilesetName, std::ios::binary).read(begin.data(), std::streamsize(begin.size()));
  return !reason && begin == kTilesetBegin;
}

class TilesWriter {
 public:
  TilesWriter(const core::Scene& scene, core::NodeId top, const TilesWriteOptions& options)
      : scene_(scene), top_(top), options_(options), shapes_(scene, options.tolerance) {}

  core::Expected<TilesWriteReport> run(const fs::path& folder) {
    if (!collect() || !measure()) return core::fail(std::string(kCancelled));
    if (found_.items.empty()) return core::fail(folder.string() + ": not written: the model has nothing to show");
    tree_ = build_tile_tree(found_.items, costs_, options_.tile_triangles);
    if (!choose_errors(
            tree_, found_.items, options_.tolerance, options_.tile_triangles,
            [&](const TileItem& item, double error) { return cost(item, error); }, within(0.2, 0.5)))
      return core::fail(std::string(kCancelled));
    places_ = place_tiles(tree_, found_.items, options_.tolerance);
    auto made = NewFolder::create(folder, is_own_tileset);
    if (!made) return tl::unexpected(made.error());
    if (auto done = write_contents(made->path()); !done) return tl::unexpected(done.error());
    if (auto done = write_tileset(made->path()); !done) return tl::unexpected(done.error());
    if (auto done = made->commit(); !done) return tl::unexpected(done.error());
    return report_;
  }

 private:
  using Proceed = std::function<bool(double)>;
  /// Progress of a step that takes a part of the whole.
  Proceed within(double from, double to) const {
    return
        [this, from, to](double share) { return !options_.progress || options_.progress(from + (to - from) * share); };
  }

  bool collect() {
    bool on = true;
    const Proceed proceed = within(0.0, 0.1);
    found_ = collect_tile_items(scene_, top_, options_.collections ? 0 : options_.tile_triangles,
                                [&](double share) { return on = on && proceed(share); });
    report_.left_out = found_.left_out;
    report_.divided = found_.divided;
    if (!options_.collections) report_.items = found_.of_kind;  // else known when rows are written
    return on;
  }

  /// What items cost in leaves. Those without triangles are left out.
  bool measure() {
    const Proceed proceed = within(0.1, 0.2);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < found_.items.size(); ++i) {
      if (!proceed(double(i) / double(found_.items.size()))) return false;
      const TileItem& item = found_.items[i];
      const std::uint64_t of_item = cost(item, 0.0);
      if (of_item == 0) {
        ++report_.left_out;
        if (!options_.collections) --report_.items[std::size_t(scene_.kind(item.id))];
        continue;
      }
      costs_.push_back(of_item);
      if (kept != i) found_.items[kept] = item;
      ++kept;
    }
    found_.items.resize(kept);
    return true;
  }

  /// 0: the item shows nothing.
  std::uint64_t cost(const TileItem& item, double error) {
    if (options_.collections) {
      if (scene_.kind(item.id) == core::Kind::kLine) return 0;
      return std::max<std::uint64_t>(kItemCost, item.mesh ? item.mesh->indices.size() / 3 : 0);
    }
    shapes_.trim();
    const TileShapes::Placed placed = shapes_.place(item, error);
    return placed.empty() ? 0 : std::max<std::uint64_t>(kItemCost, placed.mesh->indices.size() / 3);
  }

  core::Expected<void> write_contents(const fs::path& folder) {
    std::error_code reason;
    if (!fs::create_directory(folder / kContentFolder, reason))
      return core::cannot_write(folder / kContentFolder, reason);
    const Proceed proceed = within(0.5, 1.0);
    contents_.resize(tree_.tiles.size());
    report_.tiles = tree_.tiles.size();
    for (std::size_t i = 0; i < tree_.tiles.size(); ++i) {
      if (!proceed(double(i) / double(tree_.tiles.size()))) return core::fail(std::string(kCancelled));
      if (auto done = write_content(folder, i); !done) return done;
    }
    return {};
  }

  core::Expected<void> write_content(const fs::path& folder, std::size_t number) {
    const Tile& tile = tree_.tiles[number];
    std::vector<const TileItem*> items;
    for (const std::uint32_t item : tree_.items_of(tile))
      if (found_.items[item].size > tile.error) items.push_back(&found_.items[item]);
    report_.leaves += tile.leaf();
    if (items.empty()) return {};
    GltfOutput output(options_.compress);
    const TileCounts counts = options_.collections ? TileCounts{} : write_triangles(items, number, output);
    if (options_.collections)
      if (auto done = write_rows(items, number, output); !done) return done;
    contents_[number] = fmt::format("{}/{}.glb", kContentFolder, number);
    const auto bytes = output.write(folder / contents_[number]);
    if (!bytes) return tl::unexpected(bytes.error());
    report_.triangles += counts.triangles;
    report_.bytes += *bytes;
    report_.largest_file = std::max(report_.largest_file, *bytes);
    if (!tile.leaf()) return {};
    report_.leaf_triangles += counts.triangles;
    report_.instances += counts.instances;
    report_.leaf_bytes += *bytes;
    report_.largest_chord_error = std::max(report_.largest_chord_error, counts.largest_chord_error);
    return {};
  }

  TileCounts write_triangles(const std::vector<const TileItem*>& items, std::size_t number, GltfOutput& output) {
    shapes_.trim();
    return write_tile_content(scene_, top_, {items, tree_.tiles[number].error, places_[number].centre}, shapes_,
                              output);
  }

  core::Expected<void> write_rows(const std::vector<const TileItem*>& items, std::size_t number, GltfOutput& output) {
    const Tile& tile = tree_.tiles[number];
    std::vector<CollectionItem> rows;
    for (const TileItem* item : items) rows.push_back({item->id, item->node, item->state});
    GltfWriteReport written;
    const GltfWriteOptions options{.tolerance = std::max(options_.tolerance, tile.error), .collections = true};
    if (auto done = write_collections(scene_, top_, {rows, places_[number].centre}, options, output, written); !done)
      return done;
    report_.triangles += written.triangles;
    if (!tile.leaf()) return {};
    report_.leaf_triangles += written.triangles;
    for (std::size_t kind = 0; kind < report_.items.size(); ++kind) report_.items[kind] += written.items[kind];
    report_.left_out += written.left_out;
    report_.analytic += written.analytic;
    report_.largest_chord_error = std::max(report_.largest_chord_error, written.largest_chord_error);
    return {};
  }

  std::uint64_t levels_below(std::uint32_t number) const {
    const Tile& tile = tree_.tiles[number];
    std::uint64_t most = 0;
    for (std::uint32_t c = 0; c < tile.child_count; ++c) most = std::max(most, levels_below(tile.first_child + c));
    return most + 1;
  }

  core::Expected<void> write_tileset(const fs::path& folder) {
    report_.levels = levels_below(0);
    report_.root_error = places_[0].error;
    report_.whole_error = std::max(places_[0].error, glm::length(places_[0].box.size()));
    const std::string text =
        tileset_json(tree_, places_, contents_, {options_.tolerance, report_.whole_error, options_.collections});
    report_.bytes += text.size();
    return core::write_file(folder / kTilesetName, {std::as_bytes(std::span(text))});
  }

  const core::Scene& scene_;
  core::NodeId top_;
  const TilesWriteOptions& options_;
  TileShapes shapes_;
  TileItems found_;
  std::vector<std::uint64_t> costs_;  // of found_, in leaves
  TileTree tree_;
  std::vector<TilePlace> places_;
  std::vector<std::string> contents_;
  TilesWriteReport report_;
};

}  // namespace

core::Expected<TilesWriteReport> write_tiles(const core::Scene& scene, core::NodeId node, const fs::path& folder,
                                             const TilesWriteOptions& options) {
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance))
    return core::fail(fmt::format("expected a tolerance above 0 m, found {}", options.tolerance));
  if (options.tile_triangles == 0) return core::fail("expected at least one triangle for each tile, found 0");
  return TilesWriter(scene, node, options).run(folder);
}

}  // namespace sightline::importers
