#include "sightline/gl/internal/program_cache.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>
#include <system_error>

#include <fmt/format.h>

#include "sightline/core/internal/atomic_file.h"

namespace sightline::gl {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".program";

/// Start of an entry; the key and the binary follow.
struct Header {
  std::array<char, 8> magic;
  std::uint64_t key_bytes, binary_bytes;
  std::uint64_t checksum;  // of the binary
  std::uint64_t format;
};
constexpr std::array<char, 8> kMagic = {'S', 'L', 'P', 'R', 'O', 'G', '0', '1'};

/// FNV-1a: detects accidents, not attacks.
std::uint64_t checksum(std::string_view bytes, std::uint64_t sum = 0xcbf29ce484222325u) {
  for (const char byte : bytes) sum = (sum ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  return sum;
}

std::string driver_of(const Functions& gl) {
  std::string names;
  for (const GLenum name : {GL_VENDOR, GL_RENDERER, GL_VERSION}) {
    const auto* text = reinterpret_cast<const char*>(gl.GetString(name));
    names += fmt::format("{}\n", text ? text : "");
  }
  return names;
}

std::vector<GLenum> binary_formats(const Functions& gl) {
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, &count);
  std::vector<GLint> formats(static_cast<std::size_t>(std::max(count, 0)));
  if (!formats.empty()) gl.GetIntegerv(GL_PROGRAM_BINARY_FORMATS, formats.data());
  return {formats.begin(), formats.end()};
}

std::optional<std::string> read_file(const fs::path& file, std::uintmax_t most_bytes) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error || size > most_bytes) return std::nullopt;
  std::string bytes(size, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size))) return std::nullopt;
  return bytes;
}

struct Entry {
  GLenum format = GL_NONE;
  std::string_view binary;
};

std::optional<Entry> parse(std::string_view bytes, std::string_view key) {
  Header header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  if (header.magic != kMagic || header.key_bytes != key.size() || bytes.size() < key.size() ||
      header.binary_bytes != bytes.size() - key.size() || bytes.substr(0, key.size()) != key)
    return std::nullopt;
  bytes.remove_prefix(key.size());
  if (header.checksum != checksum(bytes)) return std::nullopt;
  return Entry{static_cast<GLenum>(header.format), bytes};
}

/// Only the user may access it, as the XDG base directory specification asks.
void make_folder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::create_directories(folder, ignored)) fs::permissions(folder, fs::perms::owner_all, ignored);
}

}  // namespace

ProgramCache::ProgramCache(const Functions& gl, fs::path folder, std::uintmax_t most_bytes)
    : folder_(std::move(folder)), most_bytes_(most_bytes), driver_(driver_of(gl)), formats_(binary_formats(gl)) {}

fs::path ProgramCache::default_folder() {
  for (const auto& [variable, below] : {std::pair{"XDG_CACHE_HOME", ""}, {"HOME", ".cache"}, {"LOCALAPPDATA", ""}}) {
    const char* value = std::getenv(variable);
    if (value && fs::path(value).is_absolute()) return fs::path(value) / below / "sightline";
  }
  return {};
}

fs::path ProgramCache::place_of(std::string_view key) const {
  return folder_ / fmt::format("{:016x}{}", checksum(key, checksum(driver_)), kExtension);
}

bool ProgramCache::load(const Functions& gl, GLuint program, std::string_view key) const {
  if (!enabled()) return false;
  const fs::path place = place_of(key);
  const auto bytes = read_file(place, most_bytes_);
  const auto entry = bytes ? parse(*bytes, driver_ + std::string(key)) : std::nullopt;
  if (!entry || std::find(formats_.begin(), formats_.end(), entry->format) == formats_.end()) return false;
  gl.ProgramBinary(program, entry->format, entry->binary.data(), static_cast<GLsizei>(entry->binary.size()));
  GLint linked = GL_FALSE;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) return false;
  std::error_code ignored;
  fs::last_write_time(place, fs::file_time_type::clock::now(), ignored);
  return true;
}

void ProgramCache::store(const Functions& gl, GLuint program, std::string_view key) const {
  if (!enabled()) return;
  GLint length = 0;
  gl.GetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &length);
  if (length <= 0) return;
  std::string binary(static_cast<std::size_t>(length), '\0');
  GLenum format = GL_NONE;
  gl.GetProgramBinary(program, length, &length, &format, binary.data());
  binary.resize(static_cast<std::size_t>(std::max(length, 0)));
  if (binary.empty()) return;

  const std::string whole_key = driver_ + std::string(key);
  const Header header{kMagic, whole_key.size(), binary.size(), checksum(binary), format};
  make_folder(folder_);
  // A failed write keeps nothing; the next run compiles again.
  (void)core::write_file(place_of(key), {std::as_bytes(std::span(&header, 1)), std::as_bytes(std::span(whole_key)),
                                         std::as_bytes(std::span(binary))});
  drop_oldest();
}

void ProgramCache::drop_oldest() const {
  struct File {
    fs::path path;
    std::uintmax_t bytes;
    fs::file_time_type used;
  };
  std::vector<File> files;
  std::uintmax_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    if (it->path().filename().string().find(kExtension) == std::string::npos) continue;
    std::error_code gone;
    const File file{it->path(), it->file_size(gone), it->last_write_time(gone)};
    if (gone) continue;
    sum += file.bytes;
    files.push_back(file);
  }
  if (sum <= most_bytes_) return;
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
  for (const File& file : files) {
    if (sum <= most_bytes_) break;
    fs::remove(file.path, error);
    sum -= file.bytes;
  }
}

}  // namespace sightline::gl
