#include "sightline/apps/viewpoints/zip_archive.h"

#include <algorithm>
#include <memory>

#include <zip.h>

namespace sightline::apps {
namespace {

constexpr zip_int64_t kMostEntries = 100'000;
constexpr std::size_t kPiece = std::size_t(1) << 16;

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_source_t* source) const { zip_source_free(source); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};
using Archive = std::unique_ptr<zip_t, Discard>;
using Source = std::unique_ptr<zip_source_t, Discard>;
using File = std::unique_ptr<zip_file_t, Discard>;

core::Error error_of(zip_error_t& error) {
  core::Error message{zip_error_strerror(&error)};
  zip_error_fini(&error);
  return message;
}

/// The archive shares `source`, which must be kept to be used after it.
core::Expected<Archive> open(zip_source_t* source, int flags) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_keep(source);
  Archive archive(zip_open_from_source(source, flags, &error));
  if (archive) {
    zip_error_fini(&error);
    return archive;
  }
  zip_source_free(source);
  return core::fail("expected a zip archive: " + error_of(error).message);
}

core::Expected<Source> source_of(const void* bytes, std::size_t size) {
  zip_error_t error;
  zip_error_init(&error);
  Source source(zip_source_buffer_create(bytes, size, 0, &error));
  if (!source) return tl::unexpected(error_of(error));
  zip_error_fini(&error);
  return source;
}

/// With slashes; empty where it leads outside the archive.
std::string safe_path(std::string path) {
  std::replace(path.begin(), path.end(), '\\', '/');
  const std::string framed = "/" + path + "/";
  const bool outside = path.starts_with('/') || framed.find("/../") != std::string::npos ||
                       path.substr(0, path.find('/')).find(':') != std::string::npos;
  return outside ? std::string() : path;
}

/// Fails beyond `most` bytes.
core::Expected<std::string> content(zip_t* archive, zip_uint64_t index, std::uint64_t most) {
  const File file(zip_fopen_index(archive, index, 0));
  if (!file) return core::fail(zip_strerror(archive));
  std::string bytes;
  for (;;) {
    const std::size_t before = bytes.size();
    bytes.resize(before + kPiece);
    const zip_int64_t read = zip_fread(file.get(), bytes.data() + before, kPiece);
    if (read < 0) return core::fail("damaged: " + std::string(zip_file_strerror(file.get())));
    bytes.resize(before + std::size_t(read));
    if (bytes.size() > most) return core::fail("the archive holds more than it may");
    if (read == 0) return bytes;
  }
}

}  // namespace

core::Expected<std::string> zip(const ZipEntries& entries) {
  const auto target = source_of(nullptr, 0);
  if (!target) return tl::unexpected(target.error());
  auto archive = open(target->get(), ZIP_CREATE | ZIP_TRUNCATE);
  if (!archive) return tl::unexpected(archive.error());
  for (const auto& [path, bytes] : entries) {
    zip_source_t* source = zip_source_buffer(archive->get(), bytes.data(), bytes.size(), 0);
    if (!source || zip_file_add(archive->get(), path.c_str(), source, ZIP_FL_ENC_UTF_8) < 0) {
      zip_source_free(source);
      return core::fail(path + ": " + zip_strerror(archive->get()));
    }
  }
  if (zip_close(archive->get()) != 0) return core::fail(zip_strerror(archive->get()));
  archive->release();
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_source_stat(target->get(), &stat) != 0 || zip_source_open(target->get()) != 0)
    return core::fail(zip_error_strerror(zip_source_error(target->get())));
  std::string bytes(stat.size, '\0');
  const zip_int64_t read = zip_source_read(target->get(), bytes.data(), bytes.size());
  zip_source_close(target->get());
  if (read != zip_int64_t(bytes.size())) return core::fail("the archive could not be made");
  return bytes;
}

core::Expected<ZipEntries> unzip(std::string_view bytes, std::uint64_t most_bytes) {
  const auto source = source_of(bytes.data(), bytes.size());
  if (!source) return tl::unexpected(source.error());
  const auto archive = open(source->get(), ZIP_RDONLY);
  if (!archive) return tl::unexpected(archive.error());
  const zip_int64_t count = zip_get_num_entries(archive->get(), 0);
  if (count > kMostEntries)
    return core::fail("expected at most " + std::to_string(kMostEntries) + " files, found " + std::to_string(count));
  ZipEntries entries;
  std::uint64_t left = most_bytes;
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* name = zip_get_name(archive->get(), zip_uint64_t(i), 0);
    if (!name) return core::fail("file " + std::to_string(i) + ": " + zip_strerror(archive->get()));
    const std::string path = safe_path(name);
    if (path.empty()) return core::fail(std::string(name) + ": the path leads outside the archive");
    if (path.ends_with('/')) continue;
    auto read = content(archive->get(), zip_uint64_t(i), left);
    if (!read) return core::fail(path + ": " + read.error().message);
    left -= read->size();
    entries[path] = std::move(*read);
  }
  return entries;
}

}  // namespace sightline::apps
