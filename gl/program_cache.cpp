#include "sightline/gl/internal/program_cache.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <system_error>

#include <fmt/format.h>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/hash.h"
#include "sightline/core/internal/platform/files.h"

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
constexpr std::array<char, 8> kMagic = {'S', 'L', 'P', 'R', 'O', 'G', '0', '2'};

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

// Some drivers forget the bindings that shaders declare when they load a program's binary (ANGLE: reapply_UBO_bindings;
// Cemu 1209). So an entry says them before the binary, and they are set again.

bool names_unit(GLenum type) {
  const auto within = [type](GLenum first, GLenum last) { return type >= first && type <= last; };
  return within(GL_SAMPLER_1D, GL_SAMPLER_2D_RECT_SHADOW) || within(GL_SAMPLER_1D_ARRAY, GL_SAMPLER_CUBE_SHADOW) ||
         within(GL_INT_SAMPLER_1D, GL_UNSIGNED_INT_SAMPLER_BUFFER) ||
         within(GL_SAMPLER_2D_MULTISAMPLE, GL_UNSIGNED_INT_SAMPLER_2D_MULTISAMPLE_ARRAY) ||
         within(GL_IMAGE_1D, GL_UNSIGNED_INT_IMAGE_2D_MULTISAMPLE_ARRAY);
}

GLint property(const Functions& gl, GLuint program, GLenum interface, GLuint index, GLenum name) {
  GLint value = -1;
  gl.GetProgramResourceiv(program, interface, index, 1, &name, 1, nullptr, &value);
  return value;
}

/// A line for each block and each uniform that names a texture or image unit: its interface, its name or location, its
/// binding.
std::string bindings_of(const Functions& gl, GLuint program) {
  std::string lines;
  for (const GLenum interface : {GL_UNIFORM_BLOCK, GL_SHADER_STORAGE_BLOCK, GL_UNIFORM}) {
    GLint count = 0;
    gl.GetProgramInterfaceiv(program, interface, GL_ACTIVE_RESOURCES, &count);
    for (GLuint i = 0; i < GLuint(std::max(count, 0)); ++i) {
      if (interface == GL_UNIFORM) {
        const GLint location = property(gl, program, interface, i, GL_LOCATION);
        if (location < 0 || !names_unit(GLenum(property(gl, program, interface, i, GL_TYPE)))) continue;
        GLint unit = 0;
        gl.GetUniformiv(program, location, &unit);
        lines += fmt::format("{} {} {}\n", interface, location, unit);
      } else {
        std::array<char, 256> name{};
        gl.GetProgramResourceName(program, interface, i, GLsizei(name.size()), nullptr, name.data());
        lines +=
            fmt::format("{} {} {}\n", interface, name.data(), property(gl, program, interface, i, GL_BUFFER_BINDING));
      }
    }
  }
  return lines;
}

void set_bindings(const Functions& gl, GLuint program, const std::string& lines) {
  std::istringstream in(lines);
  GLenum interface = GL_NONE;
  std::string name;
  GLuint binding = 0;
  while (in >> interface >> name >> binding) {
    const GLuint index = interface == GL_UNIFORM ? 0 : gl.GetProgramResourceIndex(program, interface, name.c_str());
    if (index == GL_INVALID_INDEX) continue;
    if (interface == GL_UNIFORM) gl.ProgramUniform1i(program, std::atoi(name.c_str()), GLint(binding));
    if (interface == GL_UNIFORM_BLOCK) gl.UniformBlockBinding(program, index, binding);
    if (interface == GL_SHADER_STORAGE_BLOCK) gl.ShaderStorageBlockBinding(program, index, binding);
  }
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
  const fs::path folder = core::platform::cache_folder();
  return folder.empty() ? fs::path() : folder / "sightline";
}

fs::path ProgramCache::place_of(std::string_view key) const {
  return folder_ / fmt::format("{:016x}{}", core::fnv1a(key, core::fnv1a(driver_)), kExtension);
}

std::optional<ProgramCache::Entry> ProgramCache::find(std::string_view key) const {
  const auto file = enabled() ? read_file(place_of(key), most_bytes_) : std::nullopt;
  Header header;
  if (!file || file->size() < sizeof header) return std::nullopt;
  std::memcpy(&header, file->data(), sizeof header);
  std::string_view bytes = std::string_view(*file).substr(sizeof header);
  const std::string whole_key = driver_ + std::string(key);
  if (header.magic != kMagic || header.key_bytes != whole_key.size() || bytes.size() < whole_key.size() ||
      header.binary_bytes != bytes.size() - whole_key.size() || bytes.substr(0, whole_key.size()) != whole_key)
    return std::nullopt;
  bytes.remove_prefix(whole_key.size());
  if (header.checksum != core::fnv1a(bytes)) return std::nullopt;
  return Entry{static_cast<GLenum>(header.format), std::string(bytes)};
}

void ProgramCache::keep(std::string_view key, GLenum format, std::string_view bytes) const {
  const std::string whole_key = driver_ + std::string(key);
  const Header header{kMagic, whole_key.size(), bytes.size(), core::fnv1a(bytes), format};
  make_folder(folder_);
  // A failed write keeps nothing; the next run compiles again.
  (void)core::write_file(place_of(key), {std::as_bytes(std::span(&header, 1)), std::as_bytes(std::span(whole_key)),
                                         std::as_bytes(std::span(bytes))});
  drop_oldest();
}

bool ProgramCache::load(const Functions& gl, GLuint program, std::string_view key) const {
  const auto entry = find(key);
  if (!entry || std::find(formats_.begin(), formats_.end(), entry->format) == formats_.end()) return false;
  const std::size_t bindings = entry->bytes.find('\0');
  if (bindings == std::string::npos) return false;
  const std::string_view binary = std::string_view(entry->bytes).substr(bindings + 1);
  gl.ProgramBinary(program, entry->format, binary.data(), static_cast<GLsizei>(binary.size()));
  GLint linked = GL_FALSE;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) return false;
  set_bindings(gl, program, entry->bytes.substr(0, bindings));
  std::error_code ignored;
  fs::last_write_time(place_of(key), fs::file_time_type::clock::now(), ignored);
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
  if (!binary.empty()) keep(key, format, bindings_of(gl, program) + '\0' + binary);
}

std::optional<std::string> ProgramCache::recall(std::string_view key) const {
  auto entry = find(key);
  return entry && entry->format == GL_NONE ? std::optional(std::move(entry->bytes)) : std::nullopt;
}

void ProgramCache::remember(std::string_view key, std::string_view text) const {
  if (enabled()) keep(key, GL_NONE, text);
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
