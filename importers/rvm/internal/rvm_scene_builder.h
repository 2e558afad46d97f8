// Puts the chunks of one RVM file into a scene (see rvm_reader.h for what becomes what).
#pragma once

#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/rvm/internal/rvm_chunks.h"

namespace sightline::importers {

class RvmSceneBuilder {
 public:
  explicit RvmSceneBuilder(ImportJob& job);

  void add(const rvm::Head& head);
  void add(const rvm::Model& model, std::uint64_t offset);
  /// `offset`: of the chunk, as for models.
  void open(const rvm::Group& group, std::uint64_t offset);
  void close() { open_.pop_back(); }
  void add(const rvm::Colour& colour) { colours_[colour.index] = colour.rgb; }
  /// `layers` is kLayerModel for PRIM.
  void add(const rvm::Item& item, std::uint32_t layers, std::span<const std::byte> file);
  /// Makes the materials, once all colours are known.
  void finish();

 private:
  struct MaterialKey {
    std::uint32_t colour = 0, transparency = 0;
    friend auto operator<=>(const MaterialKey&, const MaterialKey&) = default;
  };
  struct LayerNode {
    core::NodeId node;
    std::uint32_t transparency = 0;
  };
  struct OpenGroup {
    core::NodeId node;
    std::uint32_t colour = 1;
    LayerNode obstruction, insulation;
  };

  void set_text(std::string_view key, std::string_view value, std::uint64_t offset);
  void want_material(core::NodeId node, MaterialKey key) { wanted_.emplace_back(node, key); }
  core::NodeId node_for(const rvm::Item& item, std::uint32_t layers);

  ImportJob& job_;
  core::Scene& scene_;
  NameDecoder decoder_;
  std::vector<OpenGroup> open_;  // the file's node first
  std::map<std::uint32_t, std::array<std::uint8_t, 3>> colours_;
  std::vector<std::pair<core::NodeId, MaterialKey>> wanted_;
};

}  // namespace sightline::importers
