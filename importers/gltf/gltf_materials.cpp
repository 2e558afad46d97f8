#include "sightline/importers/gltf/internal/gltf_materials.h"

#include <algorithm>

#include <fmt/format.h>

#include "sightline/core/internal/srgb.h"

namespace sightline::importers {

namespace {

constexpr std::string_view kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

/// Where a material says what its base colour is.
struct BaseColour {
  const Json* object = nullptr;  // null: nowhere
  std::string_view factor, texture;
  std::string where;  // of the object, below the material
};

/// The older model of materials comes first, as its specification asks of those who know it.
BaseColour base_colour_of(const Json& material) {
  const Json* extensions = gltf_find(material, "extensions");
  if (const Json* older = extensions ? gltf_find(*extensions, kSpecularGlossiness) : nullptr)
    return {older, "diffuseFactor", "diffuseTexture", fmt::format("/extensions/{}", kSpecularGlossiness)};
  return {gltf_find(material, "pbrMetallicRoughness"), "baseColorFactor", "baseColorTexture", "/pbrMetallicRoughness"};
}

}  // namespace

void GltfMaterials::note_left_out(const Json& material) {
  const Json* extensions = gltf_find(material, "extensions");
  if (!extensions || !extensions->is_object()) return;
  for (const auto& [name, value] : extensions->items())
    if (name != kSpecularGlossiness && name != "KHR_materials_unlit") ++left_out_[name];
}

void GltfMaterials::warn_of_left_out() {
  for (const auto& [name, count] : left_out_)
    job_.warn(0, fmt::format("{}: left out of {} material{}, of which the base colour is read", name, count,
                             count == 1 ? "" : "s"));
}

core::MaterialId GltfMaterials::material(std::uint64_t index, PackedColour tint, const std::string& from) {
  if (const auto known = made_.find({index, tint}); known != made_.end()) return known->second;
  if (index != core::kNone && !looks_.contains(index)) {
    std::optional<Look>& look = looks_[index];
    or_warn(job_, "the default material instead", [&] { look = make(document_.element("materials", index, from)); });
  }
  std::optional<Look> look = index != core::kNone ? looks_[index] : std::nullopt;
  if (!look && tint == kNoColour) return made_[{index, tint}] = {};
  if (!look) look.emplace().material.colour = core::vec3(1.0f);
  return made_[{index, tint}] = job_.scene().add_material(tinted(std::move(*look), tint));
}

GltfMaterials::Look GltfMaterials::make(const GltfElement& element) {
  const Json empty = Json::object();
  const BaseColour names = base_colour_of(*element.json);
  const std::string where = element.where() + names.where;
  const Json* pbr = names.object ? names.object : &empty;
  double factor[4] = {1.0, 1.0, 1.0, 1.0};
  gltf_numbers(*pbr, names.factor, where, factor, 4);
  // Writers of both models state how much shows through in either.
  if (const Json* newer = gltf_find(*element.json, "pbrMetallicRoughness"); newer && newer != pbr) {
    double other[4] = {1.0, 1.0, 1.0, 1.0};
    try {
      gltf_numbers(*newer, "baseColorFactor", where, other, 4);
      factor[3] = std::min(factor[3], other[3]);
    } catch (const ImportFault&) {  // the older model's stands
    }
  }
  note_left_out(*element.json);
  const std::string mode = gltf_text(*element.json, "alphaMode");
  const bool opaque = mode.empty() || mode == "OPAQUE";
  ImageMean mean;
  if (const Json* texture = gltf_find(*pbr, names.texture)) {
    const std::string at = fmt::format("{}/{}", where, names.texture);
    or_warn(job_, "texture left out",
            [&] { mean = texture_mean(gltf_index(*texture, "index", at), at + "/index", !opaque); });
  }
  Look look{{}, mode == "BLEND"};
  core::Material& material = look.material;
  material.name = gltf_text(*element.json, "name");
  for (int i = 0; i < 3; ++i)
    material.colour[i] = float(core::srgb_from_linear(std::clamp(factor[i] * mean.colour[i], 0.0, 1.0)));
  if (look.blended) material.alpha = float(std::clamp(factor[3] * mean.alpha, 0.0, 1.0));
  return look;
}

ImageMean GltfMaterials::texture_mean(std::uint64_t texture, const std::string& from, bool weigh) {
  const GltfElement found = document_.element("textures", texture, from);
  const std::uint64_t source = gltf_index(*found.json, "source", found.where());
  const GltfElement image = document_.element("images", source, found.where() + "/source");
  const std::string where = image.where();
  const Json* uri = gltf_find(*image.json, "uri");
  const bool embedded = !uri || !uri->is_string();
  const std::uint64_t view = embedded ? gltf_index(*image.json, "bufferView", where) : 0;

  // Images are recognised by their source: a file may name one image many times.
  const std::string name = embedded ? fmt::format("view {}", view) : uri->get<std::string>();
  const bool inside = name.starts_with("data:");
  const std::string key = fmt::format("{} {}", weigh, inside ? where : name);
  if (const auto known = means_.find(key); known != means_.end()) return value_or_throw(known->second);

  const std::size_t held = document_.held();
  std::span<const std::byte> bytes;
  if (embedded)
    bytes = document_.view_bytes(view, where);
  else
    with_place(where + "/uri", [&] { bytes = document_.uri_bytes(name); });
  const std::uint64_t most = kMostPixels + kPixelsPerByte * document_.bytes_read();
  std::uint64_t left = most - std::min(most, pixels_taken_);
  auto mean = image_mean(bytes, weigh, left);
  pixels_taken_ = most - left;
  if (!embedded) document_.release(held);
  if (!mean) mean.error().message.insert(0, where + ": ");
  return value_or_throw(means_.emplace(key, std::move(mean)).first->second);
}

core::Material GltfMaterials::tinted(Look look, PackedColour tint) {
  core::Material& material = look.material;
  if (tint == kNoColour) return std::move(material);
  if (!look.blended) tint |= 255;  // an opaque material ignores all alphas (glTF 2.0, 3.9.4)
  if (tint == pack_colour(255, 255, 255) && !material.name.empty()) return std::move(material);
  const auto channel = [&](int i) { return double(tint >> (24 - 8 * i) & 255) / 255.0; };
  for (int i = 0; i < 3; ++i) {
    const double factor = core::linear_from_srgb(double(material.colour[i]));
    // White leaves the tint exact.
    material.colour[i] =
        factor == 1.0 ? float(channel(i)) : float(core::srgb_from_linear(factor * core::linear_from_srgb(channel(i))));
  }
  material.alpha *= float(channel(3));
  if (!material.name.empty()) material.name += ' ';
  material.name += colour_name(tint);
  return std::move(material);
}

}  // namespace sightline::importers
