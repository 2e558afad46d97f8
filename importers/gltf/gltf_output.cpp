#include "sightline/importers/gltf/internal/gltf_output.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/srgb.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/internal/json_text.h"

namespace sightline::importers {
namespace {

using OutputBytes = std::vector<std::byte>;

void put_word(OutputBytes& to, std::uint64_t value) {
  for (int i = 0; i < 4; ++i) to.push_back(std::byte(value >> (8 * i) & 0xff));
}

std::size_t padded(std::size_t size) {
  return (size + 3) / 4 * 4;
}

std::string_view type_of(int components) {
  return components == 1 ? "SCALAR" : components == 3 ? "VEC3" : components == 4 ? "VEC4" : "MAT4";
}

/// A file's name as a relative URI.
std::string percent_encoded(std::string_view name) {
  std::string uri;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~").find(c) != std::string_view::npos;
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

}  // namespace

std::string json_string(std::string_view text) {
  return Json(text).dump();
}

std::string gltf_transform(const core::Affine& map) {
  const core::dmat3& m = map.linear;
  const core::dvec3& o = map.origin;
  if (m == core::dmat3(1.0))
    return o == core::dvec3(0.0) ? "" : fmt::format("\"translation\":[{},{},{}]", o.x, o.y, o.z);
  return fmt::format("\"matrix\":[{},{},{},0,{},{},{},0,{},{},{},0,{},{},{},1]", m[0].x, m[0].y, m[0].z, m[1].x, m[1].y,
                     m[1].z, m[2].x, m[2].y, m[2].z, o.x, o.y, o.z);
}

std::uint32_t GltfOutput::add(Array& array, std::string_view text) {
  if (array.count > 0) array.text += ',';
  array.text += '{';
  array.text += text;
  array.text += '}';
  return array.count++;
}

std::uint32_t GltfOutput::accessor(ViewKind kind, const void* data, std::size_t size, std::string_view members) {
  View& view = views_[kind];
  auto at = std::find(order_.begin(), order_.end(), kind);
  if (at == order_.end()) {
    at = order_.insert(at, kind);
    const bool vertices = kind == kPositions || kind == kNormals, corners = kind == kSmallIndices || kind == kIndices;
    view.members = vertices ? ",\"byteStride\":12,\"target\":34962" : corners ? ",\"target\":34963" : "";
  }
  const std::size_t offset = view.bytes.size();
  view.bytes.resize(padded(offset + size));
  std::memcpy(view.bytes.data() + offset, data, size);
  return add(accessors_, fmt::format("\"bufferView\":{},\"byteOffset\":{},{}", at - order_.begin(), offset, members));
}

std::uint32_t GltfOutput::positions(std::span<const core::vec3> values) {
  core::vec3 low(values[0]), high(values[0]);
  for (const core::vec3& p : values) low = glm::min(low, p), high = glm::max(high, p);
  return accessor(kPositions, values.data(), values.size_bytes(),
                  fmt::format("\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":[{},{},{}],"
                              "\"max\":[{},{},{}]",
                              values.size(), double(low.x), double(low.y), double(low.z), double(high.x),
                              double(high.y), double(high.z)));
}

std::uint32_t GltfOutput::normals(std::span<const core::vec3> values) {
  std::vector<core::vec3> units;
  units.reserve(values.size());
  for (const core::vec3& n : values) {
    const core::dvec3 normal(n);
    const double length = glm::length(normal);
    units.push_back(length > 0.0 && std::isfinite(length) ? core::vec3(normal / length) : core::vec3(0, 0, 1));
  }
  return accessor(kNormals, units.data(), std::span(units).size_bytes(),
                  fmt::format("\"componentType\":5126,\"count\":{},\"type\":\"VEC3\"", units.size()));
}

std::uint32_t GltfOutput::indices(std::span<const std::uint32_t> values, std::size_t vertices) {
  const auto members = [&](int type) {
    return fmt::format("\"componentType\":{},\"count\":{},\"type\":\"SCALAR\"", type, values.size());
  };
  // The largest index of each type is reserved.
  if (vertices > 0xffff) return accessor(kIndices, values.data(), values.size_bytes(), members(5125));
  const std::vector<std::uint16_t> small(values.begin(), values.end());
  return accessor(kSmallIndices, small.data(), std::span(small).size_bytes(), members(5123));
}

std::uint32_t GltfOutput::numbers(std::span<const float> values, int components) {
  return accessor(kNumbers, values.data(), values.size_bytes(),
                  fmt::format("\"componentType\":5126,\"count\":{},\"type\":\"{}\"",
                              values.size() / std::size_t(components), type_of(components)));
}

std::uint32_t GltfOutput::colours(std::span<const std::uint8_t> rgba) {
  return accessor(
      kColours, rgba.data(), rgba.size_bytes(),
      fmt::format("\"componentType\":5121,\"normalized\":true,\"count\":{},\"type\":\"VEC4\"", rgba.size() / 4));
}

std::uint32_t GltfOutput::material(const core::Material& material) {
  const auto channel = [&](int i) { return core::linear_from_srgb(std::clamp(double(material.colour[i]), 0.0, 1.0)); };
  const double alpha = std::clamp(double(material.alpha), 0.0, 1.0);
  const std::string name = material.name.empty() ? "" : "\"name\":" + json_string(material.name) + ",";
  return add(materials_, fmt::format("{}\"pbrMetallicRoughness\":{{\"baseColorFactor\":[{},{},{},{}],"
                                     "\"metallicFactor\":0,\"roughnessFactor\":0.7}},{}\"doubleSided\":true",
                                     name, channel(0), channel(1), channel(2), alpha,
                                     alpha < 1.0 ? "\"alphaMode\":\"BLEND\"," : ""));
}

std::uint32_t GltfOutput::node(std::uint32_t parent, std::string_view text) {
  nodes_ += text;
  ends_.push_back(nodes_.size());
  parents_.push_back(parent);
  return node_count() - 1;
}

void GltfOutput::use_extension(std::string_view name, bool required) {
  if (std::find(used_.begin(), used_.end(), name) != used_.end()) return;
  used_.emplace_back(name);
  if (required) required_.emplace_back(name);
}

void GltfOutput::prune(const std::vector<bool>& keep) {
  std::vector<std::uint32_t> place(parents_.size(), core::kNone);
  std::uint32_t kept = 0;
  std::uint64_t begin = 0, written = 0;
  for (std::uint32_t i = 0; i < place.size(); ++i) {
    const std::uint64_t end = ends_[i], size = end - begin;
    if (keep[i]) {
      std::memmove(nodes_.data() + written, nodes_.data() + begin, size);
      written += size;
      place[i] = kept;
      ends_[kept] = written;
      parents_[kept] = parents_[i] == core::kNone ? core::kNone : place[parents_[i]];
      ++kept;
    }
    begin = end;
  }
  nodes_.resize(written);
  ends_.resize(kept);
  parents_.resize(kept);
}

std::string GltfOutput::node_text() const {
  // Children by a counting sort: node i's are children[first[i] … first[i + 1]).
  std::vector<std::uint32_t> first(parents_.size() + 2), children(parents_.size());
  const auto slot = [&](std::uint32_t parent) { return parent == core::kNone ? parents_.size() : parent; };
  for (const std::uint32_t parent : parents_) ++first[slot(parent) + 1];
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t i = 0; i < parents_.size(); ++i) children[next[slot(parents_[i])]++] = i;

  std::string all;
  all.reserve(nodes_.size() + 16 * parents_.size());
  const auto list = [&](std::size_t of) {
    all += '[';
    for (std::uint32_t c = first[of]; c < first[of + 1]; ++c) {
      if (c > first[of]) all += ',';
      fmt::format_to(std::back_inserter(all), "{}", children[c]);
    }
    all += ']';
  };
  const std::size_t scene = parents_.size();
  all += ",\"scene\":0,\"scenes\":[{";
  if (first[scene] < first[scene + 1]) all += "\"nodes\":", list(scene);
  all += "}]";
  if (parents_.empty()) return all;
  all += ",\"nodes\":[";
  std::uint64_t begin = 0;
  for (std::size_t i = 0; i < parents_.size(); ++i) {
    if (i > 0) all += ',';
    all += '{';
    all.append(nodes_, begin, ends_[i] - begin);
    if (first[i] < first[i + 1]) {
      if (ends_[i] > begin) all += ',';
      all += "\"children\":";
      list(i);
    }
    all += '}';
    begin = ends_[i];
  }
  return all + ']';
}

std::string GltfOutput::text(std::uint64_t binary_bytes, std::string_view uri) const {
  std::string all = "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Sightline\"}";
  const auto names = [&](std::string_view key, const std::vector<std::string>& list) {
    if (list.empty()) return;
    all += fmt::format(",\"{}\":[", key);
    for (std::size_t i = 0; i < list.size(); ++i) all += (i ? "," : "") + json_string(list[i]);
    all += ']';
  };
  names("extensionsUsed", used_);
  names("extensionsRequired", required_);
  all += node_text();
  const auto array = [&](std::string_view key, const Array& objects) {
    if (objects.count > 0) all += fmt::format(",\"{}\":[", key), all += objects.text, all += ']';
  };
  array("meshes", meshes_);
  array("materials", materials_);
  array("accessors", accessors_);
  if (!order_.empty()) {
    all += ",\"bufferViews\":[";
    std::uint64_t offset = 0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const View& view = views_[order_[i]];
      all += fmt::format("{}{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}{}}}", i ? "," : "", offset,
                         view.bytes.size(), view.members);
      offset += view.bytes.size();
    }
    all += fmt::format("],\"buffers\":[{{\"byteLength\":{}{}}}]", binary_bytes,
                       uri.empty() ? "" : ",\"uri\":" + json_string(uri));
  }
  return all + '}';
}

core::Expected<std::uint64_t> GltfOutput::write(const std::filesystem::path& path) {
  std::uint64_t binary = 0;
  for (const ViewKind kind : order_) binary += views_[kind].bytes.size();
  const auto write_views = [&](core::AtomicFile& file) {
    for (const ViewKind kind : order_) file.write(views_[kind].bytes);
  };
  auto file = core::AtomicFile::create(path);
  if (!file) return tl::unexpected(file.error());
  if (lower_case_extension(path) == ".gltf") {
    std::filesystem::path beside = path;
    beside.replace_extension(".bin");
    const std::string json = text(binary, percent_encoded(beside.filename().string()));
    file->write(std::as_bytes(std::span(json)));
    if (binary > 0) {
      auto numbers = core::AtomicFile::create(beside);
      if (!numbers) return tl::unexpected(numbers.error());
      write_views(*numbers);
      if (auto done = numbers->commit(); !done) return tl::unexpected(done.error());
    }
    if (auto done = file->commit(); !done) return tl::unexpected(done.error());
    return json.size() + binary;
  }
  std::string json = text(binary, "");
  json.resize(padded(json.size()), ' ');
  const std::uint64_t size = 12 + 8 + json.size() + (binary > 0 ? 8 + binary : 0);
  if (size > std::numeric_limits<std::uint32_t>::max())
    return core::fail(fmt::format("{}: takes {} bytes, more than the 4 GiB of a GLB file", path.string(), size));
  OutputBytes head;
  put_word(head, 0x46546C67), put_word(head, 2), put_word(head, size);
  put_word(head, json.size()), put_word(head, 0x4E4F534A);
  file->write(head);
  file->write(std::as_bytes(std::span(json)));
  if (binary > 0) {
    OutputBytes chunk;
    put_word(chunk, binary), put_word(chunk, 0x004E4942);
    file->write(chunk);
    write_views(*file);
  }
  if (auto done = file->commit(); !done) return tl::unexpected(done.error());
  return size;
}

}  // namespace sightline::importers
