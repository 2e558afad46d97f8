// Internal to the glTF reader: materials and what is left of their textures.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>

#include "sightline/importers/gltf/internal/gltf_document.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/internal/image_mean.h"

namespace sightline::importers {

/// Makes a material of the scene from one of the file when it is first asked for.
class GltfMaterials {
 public:
  GltfMaterials(ImportJob& job, GltfDocument& document) : job_(job), document_(document) {}
  /// `index` kNone: the default one of glTF, white. `tint`: colour of vertices, which multiplies; kNoColour: none. A
  /// material that cannot be read becomes the default one, with a warning.
  core::MaterialId material(std::uint64_t index, PackedColour tint, const std::string& from);
  /// Warns of the extensions of the materials made so far, each once.
  void warn_of_left_out();

 private:
  /// The material as the file has it, and whether it is blended.
  struct Look {
    core::Material material;
    bool blended = false;
  };
  Look make(const GltfElement& element);
  void note_left_out(const Json& material);
  static core::Material tinted(Look look, PackedColour tint);
  ImageMean texture_mean(std::uint64_t texture, const std::string& from, bool weigh);

  ImportJob& job_;
  GltfDocument& document_;
  std::unordered_map<std::uint64_t, std::optional<Look>> looks_;  // none: it cannot be read
  std::map<std::pair<std::uint64_t, PackedColour>, core::MaterialId> made_;
  std::map<std::string, core::Expected<ImageMean>> means_;
  std::uint64_t pixels_taken_ = 0;
  std::map<std::string, std::size_t> left_out_;  // extensions, with the number of materials that have them
};

}  // namespace sightline::importers
