#include "sightline/importers/gltf/internal/gltf_document.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include <fmt/format.h>

#include "sightline/importers/gltf/internal/gltf_compression.h"
#include "sightline/importers/internal/base64.h"
#include "sightline/importers/internal/side_files.h"
#include "sightline/importers/internal/text_encoding.h"

namespace sightline::importers {
namespace {

using Bytes = std::span<const std::byte>;

static_assert(std::endian::native == std::endian::little, "buffers are read as the processor holds numbers");

constexpr int kMaxGltfDepth = 128;                    // extras of some exporters nest their own trees
constexpr double kLargestIndex = 9007199254740992.0;  // 2^53

std::uint32_t word_at(Bytes bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The type that glTF has such a number for.
std::optional<NumberType> component_type(std::uint64_t number) {
  using enum NumberType;
  constexpr std::optional<NumberType> kTypes[] = {kInt8, kUint8, kInt16, kUint16, {}, kUint32, kFloat};
  return number >= 5120 && number <= 5126 ? kTypes[number - 5120] : std::nullopt;
}

int components_of(std::string_view type) {
  constexpr std::pair<std::string_view, int> kTypes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                                                         {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
  for (const auto& [name, components] : kTypes)
    if (name == type) return components;
  return 0;
}

/// The value of a number that may be a normalised integer (glTF 2.0, 3.6.2.2). The most negative integer counts as -1,
/// too.
template <class T>
double scaled(T value, bool normalized) {
  if constexpr (!std::is_floating_point_v<T>)
    if (normalized) return std::max(double(value) / double(std::numeric_limits<T>::max()), -1.0);
  return double(value);
}

template <class T>
void gather(const std::byte* from, std::uint64_t stride, std::uint64_t n, int components, bool normalized,
            double* out) {
  for (std::uint64_t i = 0; i < n; ++i, from += stride)
    for (int c = 0; c < components; ++c) {
      T value;
      std::memcpy(&value, from + std::size_t(c) * sizeof(T), sizeof(T));
      *out++ = scaled(value, normalized);
    }
}

/// Whether `count` elements of `size` bytes, `stride` apart, end within `available` bytes after `offset`.
bool fits(std::uint64_t offset, std::uint64_t count, std::uint64_t stride, std::uint64_t size,
          std::uint64_t available) {
  if (count == 0) return offset <= available;
  if (offset > available || size > available - offset) return false;
  return (count - 1) <= (available - offset - size) / stride;
}

std::vector<std::byte> base64_decoded(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const int digit = kBase64Values[static_cast<unsigned char>(c)];
    if (digit < 0) gltf_fail("a data URI: expected base64");
    bits = bits << 6 | std::uint32_t(digit);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes.push_back(std::byte(bits >> held & 0xff));
  }
  return bytes;
}

}  // namespace

// --- values --------------------------------------------------------------------------------------------------------

std::string GltfElement::where() const {
  return fmt::format("/{}/{}", array, index);
}

const Json* gltf_find(const Json& object, std::string_view key) {
  if (!object.is_object()) return nullptr;
  const auto it = object.find(key);
  return it == object.end() ? nullptr : &*it;
}

std::optional<std::uint64_t> gltf_whole(const Json& value) {
  const double number = value.is_number() ? value.get<double>() : -1.0;
  if (!(number >= 0.0 && number <= kLargestIndex && number == std::floor(number))) return std::nullopt;
  return std::uint64_t(number);
}

std::uint64_t gltf_index(const Json& object, std::string_view key, const std::string& where,
                         std::optional<std::uint64_t> fallback) {
  const Json* value = gltf_find(object, key);
  if (!value && fallback) return *fallback;
  if (!value) gltf_fail("{}/{}: expected a whole number, which is missing", where, key);
  const auto whole = gltf_whole(*value);
  if (!whole) gltf_fail("{}/{}: expected a whole number from 0, found {}", where, key, describe(*value));
  return *whole;
}

std::uint64_t gltf_indices(const Json& primitive, const std::string& where) {
  const Json* extensions = gltf_find(primitive, "extensions");
  const Json* draco = extensions ? gltf_find(*extensions, kDraco) : nullptr;
  if (!draco || gltf_find(primitive, "indices")) return gltf_index(primitive, "indices", where, core::kNone);
  return kImpliedIndices + gltf_index(*draco, "bufferView", where);
}

void gltf_numbers(const Json& object, std::string_view key, const std::string& where, double* to, std::size_t n) {
  const Json* value = gltf_find(object, key);
  if (!value) return;
  bool good = value->is_array() && value->size() == n;
  for (std::size_t i = 0; good && i < n; ++i) {
    const Json& number = (*value)[i];
    good = number.is_number() && std::isfinite(number.get<double>());
    if (good) to[i] = number.get<double>();
  }
  if (!good) gltf_fail("{}/{}: expected an array of {} finite numbers, found {}", where, key, n, describe(*value));
}

std::string gltf_text(const Json& object, std::string_view key) {
  const Json* value = gltf_find(object, key);
  return value && value->is_string() ? value->get<std::string>() : std::string();
}

namespace {

/// What a data URI holds: base64, or bytes of which some are escaped (RFC 2397).
std::vector<std::byte> data_of(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) gltf_fail("a data URI: expected a comma and what follows");
  const std::string_view data = uri.substr(comma + 1);
  if (uri.substr(0, comma).ends_with(";base64")) return base64_decoded(data);
  const std::string bytes = percent_decoded(data);
  const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
  return std::vector<std::byte>(first, first + bytes.size());
}

}  // namespace

// --- accessors -----------------------------------------------------------------------------------------------------

void GltfAccessor::read(std::uint64_t first, std::uint64_t n, double* out) const {
  const auto take = [&](const std::byte* from, std::uint64_t step, std::uint64_t number, double* to) {
    with_type(type, [&]<class T>(T) { gather<T>(from, step, number, components, normalized, to); });
  };
  if (data)
    take(data + first * stride, stride, n, out);
  else
    std::fill_n(out, n * std::uint64_t(components), 0.0);
  if (!sparse) return;
  const auto& indices = sparse->indices;
  for (auto it = std::lower_bound(indices.begin(), indices.end(), first); it != indices.end() && *it < first + n; ++it)
    take(sparse->values + std::uint64_t(it - indices.begin()) * element_bytes(), element_bytes(), 1,
         out + (*it - first) * std::uint64_t(components));
}

// --- the document --------------------------------------------------------------------------------------------------

void GltfDocument::open(Bytes bytes) {
  bytes_read_ = bytes.size();
  std::string_view text = as_text(bytes);
  if (text.starts_with("glTF")) open_binary(bytes, text);
  std::string decoded;
  if (text.data() == as_text(bytes).data()) text = as_text(without_utf16(job_, bytes, decoded));
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  text = as_utf8(job_, text, "the JSON", decoded);
  root_ = value_or_throw(parse_json(text, job_.file(), kMaxGltfDepth));
  with_place(job_.file(), [&] { check_asset(); });
}

void GltfDocument::open_binary(Bytes bytes, std::string_view& text) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
  const auto need = [&](bool good, std::string_view message) {
    if (!good) gltf_fail("{}: {}", job_.file(), message);
  };
  need(bytes.size() >= kHeader + kChunkHeader, "byte 0: expected a GLB header, found the end of the file");
  need(word_at(bytes, 4) == 2, fmt::format("byte 4: expected GLB version 2, found {}", word_at(bytes, 4)));
  if (word_at(bytes, 8) > bytes.size())
    value_or_throw(
        job_.damage(8, fmt::format("byte 8: expected a file of {} bytes, found {}", word_at(bytes, 8), bytes.size())));
  bytes = bytes.first(std::min<std::size_t>(bytes.size(), word_at(bytes, 8)));
  need(bytes.size() >= kHeader + kChunkHeader, "byte 8: expected a length beyond the header");
  need(word_at(bytes, 16) == kJson, "byte 16: expected a JSON chunk");
  std::size_t at = kHeader;
  for (bool first = true; at + kChunkHeader <= bytes.size(); first = false) {
    const std::uint64_t size = word_at(bytes, at), left = bytes.size() - at - kChunkHeader;
    const std::uint32_t kind = word_at(bytes, at + 4);
    if (size > left)
      value_or_throw(job_.damage(at, fmt::format("byte {}: expected a chunk of {} bytes, found {}", at, size, left)));
    const Bytes chunk = bytes.subspan(at + kChunkHeader, std::min(size, left));
    if (first) text = as_text(chunk);
    if (!first && kind == kBinary && binary_.empty()) binary_ = chunk;
    at += kChunkHeader + chunk.size();
  }
}

void GltfDocument::check_asset() const {
  const Json* asset = gltf_find(root_, "asset");
  const std::string version = asset ? gltf_text(*asset, "version") : std::string();
  const std::string least = asset ? gltf_text(*asset, "minVersion") : std::string();
  if (!version.starts_with("2.") || (!least.empty() && least != "2.0"))
    gltf_fail("/asset/version: expected glTF \"2.0\", found \"{}\"{}", version,
              least.empty() ? "" : fmt::format(" that needs \"{}\"", least));
  for (const std::string_view array :
       {"accessors", "buffers", "bufferViews", "images", "materials", "meshes", "nodes", "scenes", "textures"})
    if (const Json* value = gltf_find(root_, array); value && !value->is_array())
      gltf_fail("/{}: expected an array, found {}", array, describe(*value));
}

std::size_t GltfDocument::count(std::string_view array) const {
  const Json* elements = gltf_find(root_, array);
  return elements ? elements->size() : 0;
}

GltfElement GltfDocument::element(std::string_view array, std::uint64_t index, std::string_view from) const {
  const Json* elements = gltf_find(root_, array);
  const std::size_t size = elements ? elements->size() : 0;
  if (index >= size) gltf_fail("{}: expected one of the {} {}, found {}", from, size, array, index);
  const GltfElement found{&(*elements)[index], array, std::size_t(index)};
  if (!found.json->is_object()) gltf_fail("{}: expected an object, found {}", found.where(), describe(*found.json));
  return found;
}

Bytes GltfDocument::uri_bytes(std::string_view uri) {
  if (uri.starts_with("data:")) return held_.emplace_back(data_of(uri));
  if (uri.find("://") != std::string_view::npos) gltf_fail("'{}' refused: only files beside the model are read", uri);
  auto path = find_named_file(path_, uri);
  if (!path)
    if (auto similar = find_similar_file(path_, percent_decoded(uri))) {
      job_.warn(0, fmt::format("'{}' not found: '{}' is read instead", uri, similar->filename().string()));
      path = std::move(similar);
    }
  const std::string name = value_or_throw(std::move(path)).string();
  if (const auto known_file = files_.find(name); known_file != files_.end()) return known_file->second;
  const auto& read = held_.emplace_back(value_or_throw(read_side_file(path_, name)));
  bytes_read_ += read.size();
  return files_[name] = read;
}

bool GltfDocument::take_corners(std::uint64_t corners) {
  corners_ += corners;
  overdrawn_ = overdrawn_ || corners_ > kNumbersPerByte * allowance() + kSpareNumbers;
  return !overdrawn_;
}

bool GltfDocument::take_items(std::uint64_t items) {
  items_ += items;
  overdrawn_ = overdrawn_ || items_ > allowance() + kSpareNumbers;
  return !overdrawn_;
}

void GltfDocument::release(std::size_t held) {
  for (std::size_t i = held; i < held_.size(); ++i)
    std::erase_if(files_, [&](const auto& file) { return file.second.data() == held_[i].data(); });
  held_.resize(held);
}

Bytes GltfDocument::buffer(std::uint64_t index, std::string_view from) {
  if (const auto known_buffer = buffers_.find(index); known_buffer != buffers_.end()) return known_buffer->second;
  const GltfElement found = element("buffers", index, from);
  const std::string where = found.where();
  const std::uint64_t length = gltf_index(*found.json, "byteLength", where);
  Bytes bytes;
  if (const Json* uri = gltf_find(*found.json, "uri"); uri && uri->is_string())
    with_place(where + "/uri", [&] { bytes = uri_bytes(uri->string()); });
  else if (index == 0)
    bytes = binary_;
  if (length > bytes.size())
    refuse_or_warn(job_, fmt::format("{}: expected {} bytes, found {}", where, length, bytes.size()));
  return buffers_[index] = bytes.first(std::min<std::uint64_t>(length, bytes.size()));
}

Bytes GltfDocument::part_of_buffer(const Json& json, const std::string& where) {
  const std::uint64_t of = gltf_index(json, "buffer", where);
  const std::uint64_t offset = gltf_index(json, "byteOffset", where, 0);
  const std::uint64_t length = gltf_index(json, "byteLength", where);
  const Bytes bytes = buffer(of, where + "/buffer");
  if (!fits(offset, length, 1, 1, bytes.size()))
    gltf_fail("{}: expected {} bytes from {} within the {} of buffer {}", where, length, offset, bytes.size(), of);
  return bytes.subspan(offset, length);
}

GltfDocument::View GltfDocument::view(std::uint64_t index, std::string_view from) {
  const GltfElement found = element("bufferViews", index, from);
  const std::string where = found.where();
  const std::uint64_t stride = gltf_index(*found.json, "byteStride", where, 0);
  const Json* extensions = gltf_find(*found.json, "extensions");
  const Json* meshopt = extensions ? gltf_find(*extensions, kMeshopt) : nullptr;
  if (!meshopt || (!can_decompress(kMeshopt) && !is_fallback(*found.json)))
    return {part_of_buffer(*found.json, where), stride};
  if (const auto known = meshopt_views_.find(index); known != meshopt_views_.end()) return {known->second, stride};
  const std::uint64_t length = gltf_index(*found.json, "byteLength", where);
  auto bytes = inflated_view(*meshopt, length, fmt::format("{}/extensions/{}", where, kMeshopt));
  return {meshopt_views_[index] = std::move(bytes), stride};
}

bool GltfDocument::is_fallback(const Json& view) const {
  const Json* index = gltf_find(view, "buffer");
  if (!index || !index->is_number_unsigned() || index->get<std::uint64_t>() >= count("buffers")) return false;
  const Json& of = (*gltf_find(root_, "buffers"))[index->get<std::uint64_t>()];
  const Json* extensions = gltf_find(of, "extensions");
  const Json* meshopt = extensions ? gltf_find(*extensions, kMeshopt) : nullptr;
  const Json* fallback = meshopt ? gltf_find(*meshopt, "fallback") : nullptr;
  return fallback && *fallback == true && !gltf_find(of, "uri");
}

std::vector<std::byte> GltfDocument::inflated_view(const Json& extension, std::uint64_t length,
                                                   const std::string& where) {
  const std::uint64_t count_of = gltf_index(extension, "count", where);
  const std::uint64_t stride = gltf_index(extension, "byteStride", where);
  if (stride > 256 || count_of >= core::kNone || count_of * stride != length)
    gltf_fail("{}: expected {} elements of {} bytes to be the view's {} bytes", where, count_of, stride, length);
  const Bytes bytes = part_of_buffer(extension, where);
  take_inflated(length, where);
  std::vector<std::byte> inflated;
  with_place(where, [&] {
    inflated = value_or_throw(
        decompress_meshopt(bytes, {count_of, stride, gltf_text(extension, "mode"), gltf_text(extension, "filter")}));
  });
  return inflated;
}

void GltfDocument::take_inflated(std::uint64_t bytes, const std::string& where) {
  const std::uint64_t most = kInflatedPerByte * bytes_read_ + kSpareInflated;
  if (bytes > most - std::min(most, inflated_))
    gltf_fail("{}: holds more than {} times the {} bytes of the file", where, kInflatedPerByte, bytes_read_);
  inflated_ += bytes;
}

/// Accessors that get their numbers from a compressed mesh, those of the attributes first, then that of the corners.
struct GltfDocument::DracoMeshUse {
  std::vector<std::uint64_t> accessors;
  std::vector<GltfAccessor> made;
  std::vector<DracoAttribute> attributes;
  bool known = true;  // all of them have them already
};

GltfDocument::DracoMeshUse GltfDocument::draco_use(const Json& primitive, const Json& draco, std::uint64_t view_of,
                                                   const std::string& where) {
  const std::string here = fmt::format("{}/extensions/{}", where, kDraco);
  const Json& attributes = *gltf_find(primitive, "attributes");
  const std::uint64_t indices = gltf_indices(primitive, where);
  const Json* ids = gltf_find(draco, "attributes");
  if (!ids || !ids->is_object()) gltf_fail("{}/attributes: expected an object", here);
  DracoMeshUse use;
  const auto want = [&](std::uint64_t accessor, const std::string& from) {
    GltfAccessor plain = make_accessor(element("accessors", accessor, from));
    const auto known_view = draco_views_.find(accessor);
    if (known_view != draco_views_.end() && known_view->second != view_of)
      gltf_fail("{}: expected accessor {} to be that of one compressed mesh", from, accessor);
    use.known = use.known && known_view != draco_views_.end();
    use.accessors.push_back(accessor);
    use.made.push_back(std::move(plain));
  };
  for (const auto& [name, id] : ids->items()) {
    if (!gltf_find(attributes, name)) continue;
    const std::uint64_t number = gltf_index(*ids, name, here + "/attributes");
    want(gltf_index(attributes, name, where + "/attributes"), where + "/attributes/" + name);
    use.attributes.push_back({std::uint32_t(number), use.made.back().type, use.made.back().components});
  }
  if (indices < kImpliedIndices) {
    want(indices, where + "/indices");
  } else {
    use.known = use.known && draco_views_.contains(indices);
    use.accessors.push_back(indices);
    use.made.emplace_back();
  }
  return use;
}

void GltfDocument::read_draco(DracoMeshUse use, std::uint64_t view_of, const std::string& here) {
  const Bytes bytes = view(view_of, here + "/bufferView").bytes;
  const auto counts = draco_counts(bytes);
  if (!counts) gltf_fail("{}: {}", here, counts.error().message);
  constexpr std::uint64_t kBytesPerFace = 12;
  std::uint64_t bytes_per_vertex = 0;
  for (const GltfAccessor& accessor : use.made) bytes_per_vertex += accessor.element_bytes();
  if (counts->faces >= core::kNone || counts->vertices >= core::kNone)
    gltf_fail("{}: expected counts below {}", here, core::kNone);
  take_inflated(kBytesPerFace * counts->faces + bytes_per_vertex * counts->vertices, here);
  auto mesh = decompress_draco(bytes, use.attributes);
  if (!mesh) gltf_fail("{}: {}", here, mesh.error().message);
  std::vector<std::byte> corners(mesh->corners.size() * sizeof(std::uint32_t));
  if (!corners.empty()) std::memcpy(corners.data(), mesh->corners.data(), corners.size());
  mesh->attributes.push_back(std::move(corners));
  use.made.back().type = NumberType::kUint32;
  use.made.back().components = 1;
  for (std::size_t i = 0; i < use.accessors.size(); ++i) {
    GltfAccessor& accessor = use.made[i];
    std::vector<std::byte>& numbers = draco_numbers_[use.accessors[i]] = std::move(mesh->attributes[i]);
    accessor.data = numbers.data();
    accessor.stride = accessor.element_bytes();
    accessor.count = i + 1 < use.accessors.size() ? mesh->vertices : mesh->corners.size();
    accessor.sparse.reset();
    draco_views_[use.accessors[i]] = view_of;
    accessors_[use.accessors[i]] = accessor;
  }
}

void GltfDocument::decompress(const Json& primitive, const std::string& where) {
  const Json* extensions = gltf_find(primitive, "extensions");
  const Json* draco = extensions ? gltf_find(*extensions, kDraco) : nullptr;
  const Json* attributes = gltf_find(primitive, "attributes");
  if (!draco || !attributes || !gltf_find(*attributes, "POSITION")) return;
  const std::string here = fmt::format("{}/extensions/{}", where, kDraco);
  const std::uint64_t positions = gltf_index(*attributes, "POSITION", where + "/attributes");
  if (auto can = can_decompress(kDraco); !can) {
    const bool known = positions < count("accessors");
    if (known && gltf_find((*gltf_find(root_, "accessors"))[positions], "bufferView")) return;
    gltf_fail("{}: {}", here, can.error().message);
  }
  const std::uint64_t mode = gltf_index(primitive, "mode", where, 4);
  const std::uint64_t view_of = gltf_index(*draco, "bufferView", here);
  if (mode != 4) gltf_fail("{}: expected triangles (mode 4), found mode {}", here, mode);
  if (DracoMeshUse use = draco_use(primitive, *draco, view_of, where); !use.known)
    read_draco(std::move(use), view_of, here);
}

const GltfAccessor& GltfDocument::accessor(std::uint64_t index, std::string_view from) {
  if (const auto known = accessors_.find(index); known != accessors_.end()) return known->second;
  return accessors_.emplace(index, make_accessor(element("accessors", index, from))).first->second;
}

GltfAccessor GltfDocument::make_accessor(const GltfElement& of) {
  const std::string where = of.where();
  const Json& json = *of.json;
  GltfAccessor made;
  const std::uint64_t type = gltf_index(json, "componentType", where);
  const auto known_type = component_type(type);
  if (!known_type) gltf_fail("{}/componentType: expected 5120 … 5126, found {}", where, type);
  made.type = *known_type;
  made.components = components_of(gltf_text(json, "type"));
  if (made.components == 0)
    gltf_fail("{}/type: expected SCALAR, VEC2 … MAT4, found \"{}\"", where, gltf_text(json, "type"));
  made.count = gltf_index(json, "count", where);
  if (made.count >= core::kNone) gltf_fail("{}/count: expected less than {}, found {}", where, core::kNone, made.count);
  const Json* normalized = gltf_find(json, "normalized");
  made.normalized = normalized && normalized->is_boolean() && normalized->get<bool>();
  const std::uint64_t size = made.element_bytes();
  made.stride = size;
  if (gltf_find(json, "bufferView")) {
    const std::uint64_t index = gltf_index(json, "bufferView", where);
    const std::uint64_t offset = gltf_index(json, "byteOffset", where, 0);
    const View in = view(index, where + "/bufferView");
    if (in.stride != 0) made.stride = in.stride;
    if (made.stride < size || !fits(offset, made.count, made.stride, size, in.bytes.size()))
      gltf_fail("{}: expected {} elements of {} bytes, {} apart from {}, within the {} of buffer view {}", where,
                made.count, size, made.stride, offset, in.bytes.size(), index);
    made.data = in.bytes.data() + offset;
  }
  if (const Json* sparse = gltf_find(json, "sparse")) made.sparse = read_sparse(*sparse, made, where + "/sparse");
  return made;
}

GltfAccessor::Sparse GltfDocument::read_sparse(const Json& json, const GltfAccessor& of, const std::string& where) {
  const Json* indices = gltf_find(json, "indices");
  const Json* values = gltf_find(json, "values");
  if (!indices || !values) gltf_fail("{}: expected indices and values", where);
  const std::uint64_t changed = gltf_index(json, "count", where);
  /// The packed elements that "indices" or "values" names.
  const auto part = [&](const Json& named, std::uint64_t size, const std::string& at) {
    const std::uint64_t index = gltf_index(named, "bufferView", at);
    const std::uint64_t offset = gltf_index(named, "byteOffset", at, 0);
    const Bytes in = view(index, at + "/bufferView").bytes;
    if (!fits(offset, changed, size, size, in.size()))
      gltf_fail("{}: expected {} elements of {} bytes from {} within the {} of buffer view {}", at, changed, size,
                offset, in.size(), index);
    return in.data() + offset;
  };
  const std::uint64_t type = gltf_index(*indices, "componentType", where + "/indices");
  if (type != 5121 && type != 5123 && type != 5125)
    gltf_fail("{}/indices/componentType: expected an unsigned integer (5121, 5123, 5125), found {}", where, type);
  const std::uint64_t index_size = size_of(*component_type(type));
  const std::byte* index_bytes = part(*indices, index_size, where + "/indices");
  const std::byte* value_bytes = part(*values, of.element_bytes(), where + "/values");

  sparse_ += changed;
  if (sparse_ > kNumbersPerByte * allowance() + kSpareNumbers)
    gltf_fail("{}: more sparse values than a file of {} bytes may hold", where, bytes_read_);
  GltfAccessor::Sparse sparse{std::vector<std::uint32_t>(changed), value_bytes};
  for (std::uint64_t i = 0; i < changed; ++i) {
    std::memcpy(&sparse.indices[i], index_bytes + i * index_size, index_size);
    if (sparse.indices[i] >= of.count || (i > 0 && sparse.indices[i] <= sparse.indices[i - 1]))
      gltf_fail("{}/indices: expected rising indices below {}, found {} at place {}", where, of.count,
                sparse.indices[i], i);
  }
  return sparse;
}

}  // namespace sightline::importers
