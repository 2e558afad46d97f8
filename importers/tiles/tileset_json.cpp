#include "sightline/importers/tiles/internal/tileset_json.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sightline/importers/gltf/internal/gltf_placement.h"
#include "sightline/importers/tiles/internal/tile_content.h"

namespace sightline::importers {
namespace {

using core::AabbD;
using core::dvec3;

double largest(const dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

/// A power of two that is small beside the boxes, and of which doubles hold each multiple that is needed.
double grid_step(const AabbD& all) {
  constexpr int kBitsOfExtent = 20, kBitsOfReach = 46;
  const double reach = largest(glm::max(glm::abs(all.min), glm::abs(all.max)));
  return std::ldexp(1.0, std::max(std::ilogb(largest(all.size())) - kBitsOfExtent, std::ilogb(reach) - kBitsOfReach));
}

AabbD on_grid(const AabbD& box, double step) {
  return {step * glm::floor(box.min / step), step * glm::ceil(box.max / step)};
}

std::string comma_separated(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += fmt::format("{}{}", text.empty() ? "" : ",", value == 0.0 ? 0.0 : value);
  return text;
}

class TilesetText {
 public:
  TilesetText(const TileTree& tree, std::span<const TilePlace> places, std::span<const std::string> contents,
              const TilesetFacts& facts)
      : tree_(tree), places_(places), contents_(contents), facts_(facts) {}

  std::string run() {
    text_ = fmt::format("{},\"tolerance\":{}}}}},\"geometricError\":{},\"root\":", kTilesetBegin, facts_.tolerance,
                        facts_.whole_error);
    add(0, dvec3(0.0), true);
    return std::move(text_) + "}\n";
  }

 private:
  /// World directions in the frame of all tiles, which the root's transform turns for content with z up.
  dvec3 in_frame(const dvec3& v) const { return facts_.turned ? dvec3(v.x, -v.z, v.y) : v; }

  void add(std::uint32_t number, const dvec3& parent_centre, bool root) {
    const Tile& tile = tree_.tiles[number];
    const TilePlace& place = places_[number];
    const dvec3 shift = place.centre - parent_centre, to = root ? shift : in_frame(shift);
    text_ += root ? "{\"refine\":\"REPLACE\"," : "{";
    if (root && facts_.turned)
      text_ += fmt::format("\"transform\":[1,0,0,0,0,0,-1,0,0,1,0,0,{},1],", comma_separated({to.x, to.y, to.z}));
    else
      text_ += fmt::format("\"transform\":[1,0,0,0,0,1,0,0,0,0,1,0,{},1],", comma_separated({to.x, to.y, to.z}));
    const dvec3 c = in_frame(0.5 * (place.box.min - place.centre) + 0.5 * (place.box.max - place.centre));
    const dvec3 h = glm::abs(in_frame(0.5 * (place.box.max - place.box.min)));
    text_ += fmt::format("\"boundingVolume\":{{\"box\":[{}]}},\"geometricError\":{}",
                         comma_separated({c.x, c.y, c.z, h.x, 0, 0, 0, h.y, 0, 0, 0, h.z}), place.error);
    if (!contents_[number].empty()) text_ += fmt::format(",\"content\":{{\"uri\":\"{}\"}}", contents_[number]);
    if (!tile.leaf()) text_ += ",\"children\":[";
    for (std::uint32_t i = 0; i < tile.child_count; ++i) {
      if (i > 0) text_ += ',';
      add(tile.first_child + i, place.centre, false);
    }
    text_ += tile.leaf() ? "}" : "]}";
  }

  const TileTree& tree_;
  std::span<const TilePlace> places_;
  std::span<const std::string> contents_;
  const TilesetFacts& facts_;
  std::string text_;
};

}  // namespace

std::vector<TilePlace> place_tiles(const TileTree& tree, std::span<const TileItem> items, double tolerance) {
  AabbD all;
  for (const TileItem& item : items) all.grow(item.box);
  const double step = grid_step(all);
  std::vector<TilePlace> places(tree.tiles.size());
  for (std::size_t i = places.size(); i-- > 0;) {
    const Tile& tile = tree.tiles[i];
    AabbD box;
    for (const std::uint32_t item : tree.items_of(tile)) box.grow(items[item].box);
    // Content is as large as the box, and its coordinates are at most half as large as that, or the grid's rounding.
    const double rounding = kContentRounding * (largest(box.size()) + step);
    const double pad = rounding + kRoundingShare * std::max(tile.error, tolerance);
    box = on_grid({box.min - pad, box.max + pad}, step);
    double error = tile.leaf() ? 0.0 : tile.error + rounding;
    for (std::uint32_t c = 0; c < tile.child_count; ++c) {
      box.grow(places[tile.first_child + c].box);
      error = std::max(error, places[tile.first_child + c].error);
    }
    places[i] = {box, step * glm::round(box.centre() / step), error};
  }
  return places;
}

std::string tileset_json(const TileTree& tree, std::span<const TilePlace> places, std::span<const std::string> contents,
                         const TilesetFacts& facts) {
  return TilesetText(tree, places, contents, facts).run();
}

}  // namespace sightline::importers
