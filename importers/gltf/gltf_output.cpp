#include "sightline/importers/gltf/internal/gltf_output.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/srgb.h"
#include "sightline/importers/gltf/internal/gltf_compression.h"
#include "sightline/importers/gltf/internal/meshopt_encoding.h"
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

constexpr std::size_t kTableAlignment = 8;  // as EXT_structural_metadata has it for the numbers of all types

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

GltfOutput::GltfOutput(bool compress) : compress_(compress && encodes_meshopt()) {}

/// The view of all arrays of a kind with elements of that size.
GltfOutput::View& GltfOutput::view_for(Kind kind, std::size_t stride) {
  const auto known = std::find_if(views_.begin(), views_.end(),
                                  [&](const View& view) { return view.kind == kind && view.stride == stride; });
  return known != views_.end() ? *known : views_.emplace_back(View{kind, stride, {}});
}

std::uint32_t GltfOutput::accessor(Kind kind, std::span<const std::byte> data, std::size_t stride,
                                   std::string_view members) {
  View& view = view_for(kind, stride);
  const std::size_t offset = view.bytes.size();
  view.bytes.insert(view.bytes.end(), data.begin(), data.end());
  return add(accessors_, fmt::format("\"bufferView\":{},\"byteOffset\":{},{}", &view - views_.data(), offset, members));
}

std::uint32_t GltfOutput::floats(Kind kind, std::span<const float> values, int components, std::string_view bounds) {
  return accessor(kind, std::as_bytes(values), sizeof(float) * std::size_t(components),
                  fmt::format("\"componentType\":5126,\"count\":{},\"type\":\"{}\"{}",
                              values.size() / std::size_t(components), type_of(components), bounds));
}

std::uint32_t GltfOutput::table(std::span<const std::byte> bytes, std::size_t stride) {
  views_.push_back({Kind::kTable, stride, {bytes.begin(), bytes.end()}});
  return std::uint32_t(views_.size() - 1);
}

/// Compresses views where that makes them smaller.
void GltfOutput::compress() {
  if (!compress_) return;
  for (View& view : views_) {
    if (view.raw_bytes > 0 || (view.kind == Kind::kTable && view.stride % 4 != 0)) continue;
    std::vector<std::byte> encoded = view.is_corners() ? encode_meshopt_triangles(view.bytes, view.stride)
                                                       : encode_meshopt_attributes(view.bytes, view.stride);
    if (encoded.size() >= view.bytes.size() && !view.is_filtered()) continue;
    view.raw_bytes = view.bytes.size();
    view.bytes = std::move(encoded);
    use_extension(kMeshopt, true);
    compressed_ = true;
  }
}

std::uint32_t GltfOutput::positions(std::span<const core::vec3> values) {
  core::vec3 low(values[0]), high(values[0]);
  for (const core::vec3& p : values) low = glm::min(low, p), high = glm::max(high, p);
  const std::string bounds = fmt::format(",\"min\":[{},{},{}],\"max\":[{},{},{}]", double(low.x), double(low.y),
                                         double(low.z), double(high.x), double(high.y), double(high.z));
  if (compress_)
    if (const auto counts = exponential_positions(values); !counts.empty())
      return accessor(Kind::kCountedPositions, counts, 12,
                      fmt::format("\"componentType\":5126,\"count\":{},\"type\":\"VEC3\"{}", values.size(), bounds));
  return floats(Kind::kPositions, {&values[0].x, 3 * values.size()}, 3, bounds);
}

std::uint32_t GltfOutput::normals(std::span<const core::vec3> values) {
  std::vector<core::vec3> units;
  units.reserve(values.size());
  for (const core::vec3& n : values) {
    const core::dvec3 normal(n);
    const double length = glm::length(normal);
    units.push_back(length > 0.0 && std::isfinite(length) ? core::vec3(normal / length) : core::vec3(0, 0, 1));
  }
  if (!compress_) return floats(Kind::kNormals, {&units[0].x, 3 * units.size()}, 3);
  use_extension("KHR_mesh_quantization", true);
  return accessor(
      Kind::kByteNormals, octahedral_normals(units), 4,
      fmt::format("\"componentType\":5120,\"normalized\":true,\"count\":{},\"type\":\"VEC3\"", units.size()));
}

std::uint32_t GltfOutput::features(std::span<const float> values) {
  return floats(Kind::kFeatures, values, 1);
}

std::uint32_t GltfOutput::indices(std::span<const std::uint32_t> values, std::size_t vertices) {
  const auto members = [&](int type) {
    return fmt::format("\"componentType\":{},\"count\":{},\"type\":\"SCALAR\"", type, values.size());
  };
  // The largest index of each type is reserved.
  if (vertices > 0xffff) return accessor(Kind::kIndices, std::as_bytes(values), 4, members(5125));
  const std::vector<std::uint16_t> small(values.begin(), values.end());
  return accessor(Kind::kIndices, std::as_bytes(std::span(small)), 2, members(5123));
}

std::uint32_t GltfOutput::numbers(std::span<const float> values, int components) {
  return floats(Kind::kNumbers, values, components);
}

std::uint32_t GltfOutput::colours(std::span<const std::uint8_t> rgba) {
  return accessor(
      Kind::kColours, std::as_bytes(rgba), 4,
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

void GltfOutput::add_extension(std::string_view name, std::string_view text) {
  use_extension(name, false);
  if (!extensions_.empty()) extensions_ += ',';
  extensions_ += json_string(name) + ':';
  extensions_ += text;
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

std::vector<GltfOutput::Place> GltfOutput::places() const {
  std::vector<Place> places;
  Place end;
  for (const View& view : views_) {
    const std::size_t alignment = view.kind == Kind::kTable ? kTableAlignment : 4;
    end.offset = (end.offset + alignment - 1) / alignment * alignment;
    end.raw_offset = (end.raw_offset + alignment - 1) / alignment * alignment;
    places.push_back(end);
    end.offset += view.bytes.size();
    end.raw_offset += view.raw_bytes;
  }
  end.offset = padded(end.offset), end.raw_offset = padded(end.raw_offset);
  places.push_back(end);
  return places;
}

std::string GltfOutput::view_text(const View& view, const Place& place) const {
  const bool vertices = view.kind < Kind::kIndices, corners = view.is_corners();
  const std::string members = vertices  ? fmt::format(",\"byteStride\":{},\"target\":34962", view.stride)
                              : corners ? ",\"target\":34963"
                                        : "";
  if (view.raw_bytes == 0)
    return fmt::format("{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}{}}}", place.offset, view.bytes.size(),
                       members);
  return fmt::format(
      "{{\"buffer\":1,\"byteOffset\":{},\"byteLength\":{}{},\"extensions\":{{\"{}\":{{\"buffer\":0,\"byteOffset\":{},"
      "\"byteLength\":{},\"byteStride\":{},\"count\":{},\"mode\":\"{}\"{}}}}}}}",
      place.raw_offset, view.raw_bytes, members, kMeshopt, place.offset, view.bytes.size(), view.stride,
      view.raw_bytes / view.stride, corners ? "TRIANGLES" : "ATTRIBUTES",
      view.kind == Kind::kByteNormals        ? ",\"filter\":\"OCTAHEDRAL\""
      : view.kind == Kind::kCountedPositions ? ",\"filter\":\"EXPONENTIAL\""
                                             : "");
}

std::string GltfOutput::text(std::string_view uri) const {
  std::string all = "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Sightline\"}";
  const auto names = [&](std::string_view key, const std::vector<std::string>& list) {
    if (list.empty()) return;
    all += fmt::format(",\"{}\":[", key);
    for (std::size_t i = 0; i < list.size(); ++i) all += (i ? "," : "") + json_string(list[i]);
    all += ']';
  };
  names("extensionsUsed", used_);
  names("extensionsRequired", required_);
  if (!extensions_.empty()) all += ",\"extensions\":{" + extensions_ + '}';
  all += node_text();
  const auto array = [&](std::string_view key, const Array& objects) {
    if (objects.count > 0) all += fmt::format(",\"{}\":[", key), all += objects.text, all += ']';
  };
  array("meshes", meshes_);
  array("materials", materials_);
  array("accessors", accessors_);
  if (views_.empty()) return all + '}';
  const std::vector<Place> at = places();
  all += ",\"bufferViews\":[";
  for (std::size_t i = 0; i < views_.size(); ++i) all += (i ? "," : "") + view_text(views_[i], at[i]);
  all += fmt::format("],\"buffers\":[{{\"byteLength\":{}{}}}", at.back().offset,
                     uri.empty() ? "" : ",\"uri\":" + json_string(uri));
  // What the compressed views stand for is in no file.
  if (compressed_)
    all += fmt::format(",{{\"byteLength\":{},\"extensions\":{{\"{}\":{{\"fallback\":true}}}}}}", at.back().raw_offset,
                       kMeshopt);
  return all + "]}";
}

core::Expected<std::uint64_t> GltfOutput::write(const std::filesystem::path& path) {
  compress();
  const std::vector<Place> at = places();
  const std::uint64_t binary = at.back().offset;
  const auto write_views = [&](core::AtomicFile& file) {
    constexpr std::byte kNothing[kTableAlignment] = {};
    for (std::size_t i = 0; i < views_.size(); ++i) {
      file.write(views_[i].bytes);
      file.write(std::span(kNothing).first(at[i + 1].offset - at[i].offset - views_[i].bytes.size()));
    }
  };
  auto file = core::AtomicFile::create(path);
  if (!file) return tl::unexpected(file.error());
  if (lower_case_extension(path) == ".gltf") {
    std::filesystem::path beside = path;
    beside.replace_extension(".bin");
    const std::string json = text(percent_encoded(beside.filename().string()));
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
  std::string json = text("");
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
