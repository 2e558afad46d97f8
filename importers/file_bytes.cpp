#include "sightline/importers/internal/file_bytes.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "sightline/core/internal/platform/files.h"

namespace sightline::importers {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

core::Error system_error(const std::filesystem::path& path, const char* what) {
  return {fmt::format("{}: {}: {}", path.string(), what, std::strerror(errno))};
}

}  // namespace

core::Expected<std::vector<std::byte>> read_file_bytes(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, CloseFile> file(core::platform::open_file(path, "rb"));
  if (!file) return tl::unexpected(system_error(path, "cannot open"));
  std::error_code code;
  const auto size = std::filesystem::file_size(path, code);
  if (code) return core::fail(fmt::format("{}: cannot tell its size: {}", path.string(), code.message()));
  if (size == 0) return core::fail(fmt::format("{}: the file is empty", path.string()));
  try {
    std::vector<std::byte> bytes(size);
    const std::size_t got = std::fread(bytes.data(), 1, bytes.size(), file.get());
    if (std::ferror(file.get())) return tl::unexpected(system_error(path, "cannot read"));
    bytes.resize(got);
    return bytes;
  } catch (const std::exception&) {
    return core::fail(fmt::format("{}: {} bytes do not fit into memory", path.string(), size));
  }
}

}  // namespace sightline::importers
