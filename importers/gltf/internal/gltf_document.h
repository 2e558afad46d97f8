// Internal to the glTF reader: the file's JSON with checked access, its buffers, and accessors that cannot be read
// beyond their ends. What the file has wrong is thrown as an ImportFault.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <fmt/format.h>

#include "sightline/core/affine.h"
#include "sightline/importers/internal/byte_order.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/json_text.h"

namespace sightline::importers {

template <class... Args>
[[noreturn]] void gltf_fail(fmt::format_string<Args...> format, Args&&... args) {
  throw ImportFault{{fmt::format(format, std::forward<Args>(args)...)}};
}
/// Throws the message, or where the import is lenient, warns.
inline void refuse_or_warn(ImportJob& job, std::string message) {
  if (!job.options().lenient) throw ImportFault{{std::move(message)}};
  job.warn(0, std::move(message));
}
/// Runs `read`, and puts the place before the message that it throws.
template <class Read>
void with_place(std::string_view place, Read&& read) try {
  read();
} catch (ImportFault& fault) {
  if (fault.error.message != kCancelled) fault.error.message.insert(0, fmt::format("{}: ", place));
  throw;
}
/// Runs `read`. What it throws becomes a warning, with `instead` behind it, and the answer false.
template <class Read>
bool or_warn(ImportJob& job, std::string_view instead, Read&& read) try {
  read();
  return true;
} catch (const ImportFault& fault) {
  job.warn(0, fmt::format("{}; {}", fault.error.message, instead));
  return false;
}

/// One object of the file, with its place: "/nodes/12".
struct GltfElement {
  const Json* json = nullptr;
  std::string_view array;
  std::size_t index = 0;
  std::string where() const;
};

/// Numbers in a buffer. `data` is null when all of them are zero.
struct GltfAccessor {
  NumberType type = NumberType::kFloat;
  bool normalized = false;
  int components = 1;  ///< 1, 2, 3, 4, 9 or 16 numbers for each element
  std::uint64_t count = 0;
  const std::byte* data = nullptr;
  std::uint64_t stride = 0;  ///< bytes from element to element
  /// Elements that differ from `data`: rising indices into it, and their values back to back.
  struct Sparse {
    std::vector<std::uint32_t> indices;
    const std::byte* values = nullptr;
  };
  std::optional<Sparse> sparse;

  std::uint64_t element_bytes() const { return size_of(type) * std::uint64_t(components); }
  /// Reads elements first … first + n - 1 (within count) to out[0 … n * components - 1], normalised where the file says
  /// so.
  void read(std::uint64_t first, std::uint64_t n, double* out) const;
};

/// Most numbers per byte of a file: corners of triangles (a strip of bytes has three a byte), or sparse values. Items
/// are limited to one a byte. The spare ones let small files repeat a mesh often. Bytes that decompression makes count
/// as the file's.
inline constexpr std::uint64_t kNumbersPerByte = 3, kSpareNumbers = 65536;
/// Most bytes that decompression may make of each byte of the file, and spare ones: meshes of long rows of equal
/// numbers shrink that far.
inline constexpr std::uint64_t kInflatedPerByte = 64, kSpareInflated = std::uint64_t{1} << 20;

class GltfDocument {
 public:
  explicit GltfDocument(ImportJob& job, const std::filesystem::path& path) : job_(job), path_(path) {}
  /// `bytes` must outlive the document. Fails on what cannot be a glTF 2.0 file; other damage goes to the job.
  void open(std::span<const std::byte> bytes);

  const Json& root() const { return root_; }
  /// Elements of a top-level array: 0 when it is missing.
  std::size_t count(std::string_view array) const;
  /// Fails when there is no such element. `from` names the place that refers to it, for messages.
  GltfElement element(std::string_view array, std::uint64_t index, std::string_view from) const;

  const GltfAccessor& accessor(std::uint64_t index, std::string_view from);
  /// Gives the accessors of a primitive with KHR_draco_mesh_compression their numbers. Nothing to do for others, and
  /// for those that this build cannot decompress but that hold the same uncompressed. `where` is the primitive's place.
  void decompress(const Json& primitive, const std::string& where);
  /// The bytes of a buffer view, of an image say.
  std::span<const std::byte> view_bytes(std::uint64_t index, std::string_view from) { return view(index, from).bytes; }
  /// The bytes behind a URI, from the text itself or from a file beside the model, held by the document.
  std::span<const std::byte> uri_bytes(std::string_view uri);
  /// Releases the bytes of data URIs and files that uri_bytes() brought since held() was `held`.
  std::size_t held() const { return held_.size(); }
  void release(std::size_t held);

  std::uint64_t bytes_read() const { return bytes_read_; }  ///< of this file and the files that it names

  /// Counts what the file asks to be made. Returns false when that is out of proportion to the file's bytes. A few
  /// bytes of JSON can name the same numbers again and again: only such limits keep memory proportional.
  bool take_corners(std::uint64_t corners);
  bool take_items(std::uint64_t items);
  bool overdrawn() const { return overdrawn_; }  ///< one of these returned false: going on would only take time

 private:
  struct View {
    std::span<const std::byte> bytes;
    std::uint64_t stride = 0;  ///< 0: elements are packed
  };
  void open_binary(std::span<const std::byte> bytes, std::string_view& text);
  void check_asset() const;
  std::span<const std::byte> buffer(std::uint64_t index, std::string_view from);
  View view(std::uint64_t index, std::string_view from);
  std::vector<std::byte> inflated_view(const Json& extension, std::uint64_t length, const std::string& where);
  bool is_fallback(const Json& view) const;  ///< of a buffer that stands for compressed data and holds nothing
  std::span<const std::byte> part_of_buffer(const Json& json, const std::string& where);
  void take_inflated(std::uint64_t bytes, const std::string& where);
  struct DracoMeshUse;
  DracoMeshUse draco_use(const Json& primitive, const Json& draco, std::uint64_t view_of, const std::string& where);
  void read_draco(DracoMeshUse use, std::uint64_t view_of, const std::string& here);
  std::uint64_t allowance() const { return bytes_read_ + inflated_; }
  GltfAccessor make_accessor(const GltfElement& element);
  GltfAccessor::Sparse read_sparse(const Json& json, const GltfAccessor& of, const std::string& where);

  ImportJob& job_;
  const std::filesystem::path& path_;
  Json root_;
  std::span<const std::byte> binary_;
  bool overdrawn_ = false;
  std::uint64_t bytes_read_ = 0, inflated_ = 0, corners_ = 0, items_ = 0, sparse_ = 0;
  std::unordered_map<std::uint64_t, GltfAccessor> accessors_;
  std::unordered_map<std::uint64_t, std::span<const std::byte>> buffers_;
  std::vector<std::vector<std::byte>> held_;
  std::unordered_map<std::uint64_t, std::vector<std::byte>> meshopt_views_;
  std::unordered_map<std::uint64_t, std::vector<std::byte>> draco_numbers_;  // of accessors
  std::unordered_map<std::uint64_t, std::uint64_t> draco_views_;             // that these came from
  std::map<std::string, std::span<const std::byte>, std::less<>> files_;
};

// --- checked access to values; `where` is the pointer of `object`, for messages -----------------------------------

const Json* gltf_find(const Json& object, std::string_view key);
/// A whole number from 0 to 2^53, which some writers give as 3.0; none for anything else.
std::optional<std::uint64_t> gltf_whole(const Json& value);
/// A whole number from 0 to 2^53. Missing: the fallback, or an error when there is none.
std::uint64_t gltf_index(const Json& object, std::string_view key, const std::string& where,
                         std::optional<std::uint64_t> fallback = {});
/// The accessor of a primitive's indices; kNone: it has none. Some writers leave it out where the corners are
/// compressed by Draco: then kImpliedIndices and the number of the compressed view.
std::uint64_t gltf_indices(const Json& primitive, const std::string& where);
inline constexpr std::uint64_t kImpliedIndices = std::uint64_t{1} << 54;  // beyond what gltf_index() gives
/// `n` finite numbers into `to`, left alone when the key is missing.
void gltf_numbers(const Json& object, std::string_view key, const std::string& where, double* to, std::size_t n);
std::string gltf_text(const Json& object, std::string_view key);  ///< empty when it is missing or no string

}  // namespace sightline::importers
