#include "sightline/importers/gltf/internal/gltf_materials.h"

#include <algorithm>

#include <fmt/format.h>

#include "sightline/core/internal/srgb.h"

namespace sightline::importers {

core::Expected<core::MaterialId> GltfMaterials::material(std::uint64_t index, PackedColour tint,
                                                         const std::string& from) {
  if (index == core::kNone && tint == kNoColour) return core::MaterialId{};
  if (const auto known = made_.find({index, tint}); known != made_.end()) return known->second;
  if (index != core::kNone && !looks_.contains(index)) {
    const auto element = document_.element("materials", index, from);
    if (!element) return tl::unexpected(element.error());
    auto look = make(*element);
    if (!look) return tl::unexpected(look.error());
    looks_[index] = std::move(*look);
  }
  Look look;
  look.material.colour = core::vec3(1.0f);
  if (index != core::kNone) look = looks_[index];
  return made_[{index, tint}] = job_.scene().add_material(tinted(std::move(look), tint));
}

core::Expected<GltfMaterials::Look> GltfMaterials::make(const GltfElement& element) {
  const std::string where = element.where();
  const Json empty = Json::object();
  const Json* pbr = gltf_find(*element.json, "pbrMetallicRoughness");
  if (!pbr) pbr = &empty;
  double factor[4] = {1.0, 1.0, 1.0, 1.0};
  if (auto read = gltf_numbers(*pbr, "baseColorFactor", where + "/pbrMetallicRoughness", factor, 4); !read)
    return tl::unexpected(read.error());
  const std::string mode = gltf_text(*element.json, "alphaMode");
  const bool opaque = mode.empty() || mode == "OPAQUE";
  ImageMean mean;
  if (const Json* texture = gltf_find(*pbr, "baseColorTexture")) {
    const std::string at = where + "/pbrMetallicRoughness/baseColorTexture";
    const auto index = gltf_index(*texture, "index", at);
    if (!index) return tl::unexpected(index.error());
    const auto found = texture_mean(*index, at + "/index", !opaque);
    if (found)
      mean = *found;
    else
      job_.warn(0, found.error().message + "; texture left out");
  }
  Look look{{}, mode == "BLEND"};
  core::Material& material = look.material;
  material.name = gltf_text(*element.json, "name");
  for (int i = 0; i < 3; ++i)
    material.colour[i] = float(core::srgb_from_linear(std::clamp(factor[i] * mean.colour[i], 0.0, 1.0)));
  if (look.blended) material.alpha = float(std::clamp(factor[3] * mean.alpha, 0.0, 1.0));
  return look;
}

core::Expected<ImageMean> GltfMaterials::texture_mean(std::uint64_t texture, const std::string& from, bool weigh) {
  const auto found = document_.element("textures", texture, from);
  if (!found) return tl::unexpected(found.error());
  const auto source = gltf_index(*found->json, "source", found->where());
  if (!source) return tl::unexpected(source.error());
  const auto image = document_.element("images", *source, found->where() + "/source");
  if (!image) return tl::unexpected(image.error());
  const std::string where = image->where();
  const Json* uri = gltf_find(*image->json, "uri");
  const bool embedded = !uri || !uri->is_string();
  const auto view = embedded ? gltf_index(*image->json, "bufferView", where) : 0;
  if (!view) return tl::unexpected(view.error());

  // Images are recognised by their source: a file may name one picture many times.
  const std::string name = embedded ? fmt::format("view {}", *view) : uri->get<std::string>();
  const bool inside = name.starts_with("data:");
  const std::string key = fmt::format("{} {}", weigh, inside ? where : name);
  if (const auto known = means_.find(key); known != means_.end()) return known->second;

  const std::size_t held = document_.held();
  const auto bytes = embedded ? document_.view_bytes(*view, where) : document_.uri_bytes(name);
  if (!bytes)
    return embedded ? tl::unexpected(bytes.error())
                    : tl::unexpected(core::Error{fmt::format("{}/uri: {}", where, bytes.error().message)});
  const std::uint64_t most = kMostPixels + kPixelsPerByte * document_.bytes_read();
  std::uint64_t left = most - std::min(most, pixels_taken_);
  auto mean = image_mean(*bytes, weigh, left);
  pixels_taken_ = most - left;
  if (!embedded) document_.release(held);
  if (!mean) mean.error().message.insert(0, where + ": ");
  return means_.emplace(key, std::move(mean)).first->second;
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
