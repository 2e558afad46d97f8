#include "sightline/importers/cad/internal/cad_text.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zip.h>
#include <zlib.h>

#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"

namespace sightline::importers {
namespace {

constexpr std::size_t kMostInflated = std::size_t{4} << 30;
constexpr std::string_view kGzip = "\x1f\x8b", kZip = "PK";

core::Expected<std::string> gunzipped(std::string_view bytes) {
  z_stream stream{};
  constexpr int kGzipHeader = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzipHeader) != Z_OK) return core::fail("cannot be inflated: no memory");
  std::string text;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  int result = Z_OK;
  while (result == Z_OK && text.size() < kMostInflated) {
    const std::size_t before = text.size();
    text.resize(before + (std::size_t{1} << 20));
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
    stream.avail_out = uInt(text.size() - before);
    result = inflate(&stream, Z_NO_FLUSH);
    text.resize(text.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  if (result != Z_STREAM_END) return core::fail("is no whole gzip file");
  return text;
}

/// Comments may come before the first words of a file.
bool begins_like_step(std::string_view text) {
  return text.substr(0, 1024).find("ISO-10303-21") != text.npos;
}

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
using Archive = std::unique_ptr<zip_t, CloseArchive>;

/// The first bytes of an entry; nothing where it cannot be read.
std::string read_entry(zip_t* archive, zip_uint64_t entry, std::size_t most) {
  std::string text;
  zip_file_t* file = zip_fopen_index(archive, entry, 0);
  if (!file) return text;
  text.resize(most);
  text.resize(std::size_t(std::max<zip_int64_t>(0, zip_fread(file, text.data(), text.size()))));
  zip_fclose(file);
  return text;
}

core::Expected<std::string> unzipped(std::string_view bytes) {
  zip_error_t error{};
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  const Archive archive(source ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr);
  if (!archive) {
    zip_source_free(source);
    return core::fail("is no whole zip file");
  }
  constexpr std::size_t kBegin = 1024, kMostNamed = 8;
  std::vector<zip_uint64_t> models;
  std::vector<std::string> names;
  const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
  for (zip_uint64_t i = 0; i < zip_uint64_t(std::max<zip_int64_t>(0, count)); ++i) {
    const char* name = zip_get_name(archive.get(), i, 0);
    if (name && names.size() < kMostNamed) names.push_back(excerpt(name));
    if (begins_like_step(read_entry(archive.get(), i, kBegin))) models.push_back(i);
  }
  zip_stat_t stat{};
  if (models.size() != 1 || zip_stat_index(archive.get(), models[0], 0, &stat) != 0 || stat.size > kMostInflated)
    return core::fail(fmt::format("is no zip file with one STEP file: {} of {} entries are, the first {}",
                                  models.size(), std::max<zip_int64_t>(0, count), fmt::join(names, ", ")));
  std::string text = read_entry(archive.get(), models[0], stat.size);
  if (text.size() != stat.size) return core::fail("is no whole zip file");
  return text;
}

}  // namespace

core::Expected<std::string> read_cad_text(ImportJob& job, const std::filesystem::path& path) {
  const auto bytes = read_file_bytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string_view all(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  auto text = all.starts_with(kGzip)  ? gunzipped(all)
              : all.starts_with(kZip) ? unzipped(all)
                                      : core::Expected<std::string>(std::string(all));
  if (!text) return core::fail(fmt::format("{}: {}", path.filename().string(), text.error().message));
  std::string decoded;
  without_utf16(job, std::as_bytes(std::span(*text)), decoded);
  if (!decoded.empty()) text = std::move(decoded);
  if (text->starts_with(kByteOrderMark)) text->erase(0, kByteOrderMark.size());
  return text;
}

bool may_be_step(const std::filesystem::path& path) {
  std::array<char, 1024> begin{};
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), begin.size());
  const std::string_view text(begin.data(), std::size_t(file.gcount()));
  return begins_like_step(text) || text.starts_with(kGzip) || text.starts_with(kZip) ||
         utf8_from_utf16(std::as_bytes(std::span(text))).has_value();
}

}  // namespace sightline::importers
