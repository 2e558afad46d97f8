#include "sightline/importers/tiles/internal/tile_parts.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include <fmt/format.h>

#include "sightline/importers/internal/text_encoding.h"

namespace sightline::importers {
namespace {

using Rows = std::map<std::uint32_t, std::string>;  // values by row; others are empty

/// One property: what the schema says of it, and where its values are.
struct Column {
  std::string schema, values;
};

/// An identifier for the schema, which allows letters, digits and underscores of ASCII, that no other property has.
std::string identifier(std::string_view key, std::set<std::string>& taken) {
  std::string id;
  for (const char c : key) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'), digit = c >= '0' && c <= '9';
    id += letter || digit ? c : '_';
  }
  if (id.empty() || (id[0] >= '0' && id[0] <= '9')) id.insert(0, 1, '_');
  std::string free = id;
  for (int i = 2; !taken.insert(free).second; ++i) free = fmt::format("{}_{}", id, i);
  return free;
}

std::uint32_t write_numbers(std::span<const std::uint32_t> values, GltfOutput& output) {
  return output.table(std::as_bytes(values), sizeof values[0]);
}

/// Nothing where all are empty: buffer views are not.
Column string_column(const std::string& id, std::string_view name, const Rows& rows, std::size_t count,
                     GltfOutput& output) {
  std::string text;
  std::vector<std::uint32_t> offsets;
  auto at = rows.begin();
  for (std::uint32_t row = 0; row < count; ++row) {
    offsets.push_back(std::uint32_t(text.size()));
    if (at != rows.end() && at->first == row) text += (at++)->second;
  }
  offsets.push_back(std::uint32_t(text.size()));
  if (text.empty()) return {};
  const std::uint32_t values = output.table(std::as_bytes(std::span(text)), 1);
  return {fmt::format("\"{}\":{{\"name\":{},\"type\":\"STRING\",\"noData\":\"\"}}", id, json_string(name)),
          fmt::format("\"{}\":{{\"values\":{},\"stringOffsets\":{}}}", id, values, write_numbers(offsets, output))};
}

Column number_column(const std::string& id, std::span<const std::uint32_t> rows, GltfOutput& output) {
  return {fmt::format("\"{}\":{{\"type\":\"SCALAR\",\"componentType\":\"UINT32\",\"required\":true}}", id),
          fmt::format("\"{}\":{{\"values\":{}}}", id, write_numbers(rows, output))};
}

std::string joined(const std::vector<Column>& properties, std::string Column::*part) {
  std::string all;
  for (const Column& property : properties) {
    if ((property.*part).empty()) continue;
    if (!all.empty()) all += ',';
    all += property.*part;
  }
  return all;
}

}  // namespace

std::uint32_t TileParts::row(core::NodeId node) {
  const auto [at, added] = rows_.try_emplace(node.index, std::uint32_t(nodes_.size()));
  if (added) nodes_.push_back(node);
  return at->second;
}

std::string TileParts::feature_ids(std::span<const float> ids) {
  std::vector<float> distinct(ids.begin(), ids.end());
  std::ranges::sort(distinct);
  const auto count = std::unique(distinct.begin(), distinct.end()) - distinct.begin();
  return fmt::format("{{\"featureIds\":[{{\"featureCount\":{},\"attribute\":0,\"propertyTable\":0}}]}}", count);
}

/// The root of a scene has no name to tell.
core::NodeId TileParts::parent_of(core::NodeId node) const {
  if (node == top_) return {};
  const core::NodeId parent = scene_.parent(node);
  return parent == scene_.root() ? core::NodeId{} : parent;
}

void TileParts::add_parents() {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (const core::NodeId parent = parent_of(nodes_[i]); parent.valid()) row(parent);
}

void TileParts::write(GltfOutput& output) {
  if (nodes_.empty()) return;
  add_parents();
  std::vector<std::uint32_t> numbers_of_nodes, parents;
  Rows names;
  std::map<std::string, Rows> attributes;
  for (std::uint32_t row = 0; row < nodes_.size(); ++row) {
    numbers_of_nodes.push_back(nodes_[row].index);
    const core::NodeId parent = parent_of(nodes_[row]);
    parents.push_back(parent.valid() ? rows_.at(parent.index) : row);
    names[row] = utf8_by_guess(scene_.name(nodes_[row]));
    for (const auto& [key, value] : scene_.attributes(nodes_[row])) attributes[key][row] = utf8_by_guess(value);
  }
  std::set<std::string> taken{"name", "node", "parent"};
  std::vector<Column> properties{string_column("name", "Name", names, nodes_.size(), output),
                                 number_column("node", numbers_of_nodes, output),
                                 number_column("parent", parents, output)};
  for (const auto& [key, rows] : attributes)
    properties.push_back(string_column(identifier(key, taken), key, rows, nodes_.size(), output));
  output.add_extension(
      "EXT_structural_metadata",
      fmt::format("{{\"schema\":{{\"id\":\"sightline\",\"classes\":{{\"part\":{{\"properties\":{{{}}}}}}}}},"
                  "\"propertyTables\":[{{\"class\":\"part\",\"count\":{},\"properties\":{{{}}}}}]}}",
                  joined(properties, &Column::schema), nodes_.size(), joined(properties, &Column::values)));
}

}  // namespace sightline::importers
