#include "sightline/importers/rvm/internal/rvm_scene_builder.h"

#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "sightline/importers/rvm/internal/rvm_reader.h"

namespace sightline::importers {
namespace {

core::Affine placement_of(const std::array<float, 12>& m) {
  core::Affine placement;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) placement.linear[column][row] = double(m[3 * column + row]);
  placement.origin = {double(m[9]), double(m[10]), double(m[11])};
  return placement;
}

bool any_bit_set(const std::array<float, 3>& values) {
  for (const float value : values)
    if (std::bit_cast<std::uint32_t>(value) != 0) return true;
  return false;
}

}  // namespace

RvmSceneBuilder::RvmSceneBuilder(ImportJob& job) : job_(job), scene_(job.scene()), decoder_(job) {
  open_.push_back({job.file_node(), 1, {}, {}});
}

void RvmSceneBuilder::set_text(std::string_view key, std::string_view value, std::uint64_t offset) {
  if (!value.empty()) scene_.set_attribute(job_.file_node(), key, decoder_.decode(value, offset));
}

void RvmSceneBuilder::add(const rvm::Head& head) {
  decoder_.state(head.encoding);
  set_text(rvm::kInfoKey, head.info, 0);
  set_text(rvm::kNoteKey, head.note, 0);
  set_text(rvm::kDateKey, head.date, 0);
  set_text(rvm::kUserKey, head.user, 0);
  set_text(rvm::kEncodingKey, head.encoding, 0);
}

void RvmSceneBuilder::add(const rvm::Model& model, std::uint64_t offset) {
  set_text(rvm::kProjectKey, model.project, offset);
  set_text(rvm::kModelKey, model.name, offset);
}

void RvmSceneBuilder::open(const rvm::Group& group, std::uint64_t offset) {
  const core::NodeId node = scene_.add_node(open_.back().node, decoder_.decode(group.name, offset));
  open_.push_back({node, group.colour, {}, {}});
  want_material(node, {group.colour, group.transparency});
  const auto& p = group.position;
  if (any_bit_set(p)) scene_.set_attribute(node, rvm::kPositionKey, fmt::format("{} {} {}", p[0], p[1], p[2]));
}

core::NodeId RvmSceneBuilder::node_for(const rvm::Item& item, std::uint32_t layers) {
  OpenGroup& group = open_.back();
  if (layers == core::kLayerModel) return group.node;
  LayerNode& layer = layers == core::kLayerObstruction ? group.obstruction : group.insulation;
  if (layer.node.valid() && layer.transparency == item.transparency) return layer.node;
  layer = {scene_.add_node(group.node), item.transparency};
  scene_.set_layers(layer.node, layers);
  want_material(layer.node, {group.colour, item.transparency});
  return layer.node;
}

void RvmSceneBuilder::add(const rvm::Item& item, std::uint32_t layers, std::span<const std::byte> file) {
  const core::NodeId node = node_for(item, layers);
  const core::Affine placement = placement_of(item.matrix);
  if (item.kind == core::Kind::kFacetGroup) {
    job_.add_mesh(node, rvm::read_facets(file, item), placement, {}, item.kind);
    return;
  }
  const auto count = std::size_t(core::parameter_count(item.kind));
  job_.add_primitive(node, core::make_primitive(item.kind, {item.parameters.data(), count}), placement);
}

void RvmSceneBuilder::finish() {
  // What is written from here on has the names as they are now.
  if (decoder_.has_decoded()) scene_.set_attribute(job_.file_node(), rvm::kEncodingKey, "Unicode UTF-8");
  std::map<MaterialKey, core::MaterialId> made;
  for (const auto& [node, key] : wanted_) {
    core::MaterialId& id = made[key];
    if (!id.valid()) {
      const auto stored = colours_.find(key.colour);
      const auto rgb = stored != colours_.end() ? stored->second : rvm_default_colour(key.colour);
      core::Material material;
      material.name = fmt::format("rvm {}", key.colour);
      for (int i = 0; i < 3; ++i) material.colour[i] = float(rgb[std::size_t(i)]) / 255.0f;
      material.alpha = 1.0f - float(key.transparency) / 100.0f;
      material.code = key.colour;
      id = scene_.add_material(std::move(material));
    }
    scene_.set_material(node, id);
  }
}

std::array<std::uint8_t, 3> rvm_default_colour(std::uint32_t index) {
  constexpr std::array<std::array<std::uint8_t, 3>, 16> kUsual = {{{150, 155, 160},
                                                                   {196, 64, 58},
                                                                   {222, 134, 54},
                                                                   {222, 192, 74},
                                                                   {88, 160, 92},
                                                                   {84, 176, 186},
                                                                   {74, 116, 188},
                                                                   {134, 96, 176},
                                                                   {142, 104, 74},
                                                                   {232, 232, 228},
                                                                   {222, 150, 150},
                                                                   {176, 148, 190},
                                                                   {94, 184, 168},
                                                                   {88, 92, 150},
                                                                   {58, 60, 64},
                                                                   {190, 84, 150}}};
  if (index >= 1 && index <= kUsual.size()) return kUsual[index - 1];
  // A hue in [0, 6) from the golden ratio's multiples modulo 2^32, at saturation 0.4 and value 0.8.
  const double hue = 6.0 * double(index * 2654435769u) / 4294967296.0;
  const auto channel = [hue](double at) {
    const double distance = std::abs(std::remainder(hue - at, 6.0));
    const double share = std::min(std::max(2.0 - distance, 0.0), 1.0);
    return std::uint8_t(std::lround(204.0 * (0.6 + 0.4 * share)));
  };
  return {channel(0.0), channel(2.0), channel(4.0)};
}

}  // namespace sightline::importers
