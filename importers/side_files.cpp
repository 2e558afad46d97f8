#include "sightline/importers/internal/side_files.h"

#include <algorithm>
#include <optional>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/internal/file_bytes.h"

namespace sightline::importers {

namespace fs = std::filesystem;

namespace {

/// The first by name of a folder's entries of that name.
std::optional<fs::path> similar_entry(const fs::path& folder, const std::string& name) {
  std::optional<fs::path> best;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    const fs::path& path = entry->path();
    if (core::same_but_for_case(path.filename().string(), name) && (!best || path < *best)) best = path;
  }
  return best;
}

std::optional<fs::path> similar_path(const fs::path& folder, const fs::path& name) {
  std::optional<fs::path> at = folder;
  for (const fs::path& part : name.relative_path()) {
    if (part.empty() || part == ".") continue;
    at = part == ".." ? std::nullopt : similar_entry(*at, part.string());
    if (!at) return {};
  }
  return at;
}

}  // namespace

core::Expected<fs::path> find_side_file(const fs::path& model, std::string_view name) {
  // The system would end the name at a NUL, after the whole name has been checked.
  if (name.empty() || name.find('\0') != std::string_view::npos)
    return core::fail("a side file's name is empty or holds a NUL");
  std::error_code code;
  const fs::path root = fs::weakly_canonical(model.has_parent_path() ? model.parent_path() : fs::path("."), code);
  if (code) return core::fail(fmt::format("'{}': {}", name, code.message()));
  const fs::path path = fs::weakly_canonical(root / core::platform::path_of(name), code);
  if (code) return core::fail(fmt::format("'{}' not found: {}", name, code.message()));
  const fs::path relative = path.lexically_relative(root);
  if (relative.empty() || *relative.begin() == "..")
    return core::fail(fmt::format("'{}' refused: it lies outside the model's directory", name));
  if (side_files_asked_for != nullptr) side_files_asked_for->push_back(path);
  if (!fs::is_regular_file(path, code)) return core::fail(fmt::format("'{}' not found", name));
  return path;
}

core::Expected<std::vector<std::byte>> read_side_file(const fs::path& model, std::string_view name,
                                                      std::uint64_t largest) {
  const auto path = find_side_file(model, name);
  if (!path) return tl::unexpected(path.error());
  std::error_code code;
  if (const auto size = fs::file_size(*path, code); !code && size > largest)
    return core::fail(fmt::format("'{}' is refused: {} bytes, expected at most {}", name, size, largest));
  return read_file_bytes(*path);
}

core::Expected<fs::path> find_similar_file(const fs::path& model, std::string_view name) {
  std::string slashes(name);
  std::replace(slashes.begin(), slashes.end(), '\\', '/');
  const fs::path folder = model.has_parent_path() ? model.parent_path() : fs::path("."),
                 wanted = core::platform::path_of(slashes);
  for (const fs::path& tried : {wanted, wanted.filename()})
    if (const auto similar = similar_path(folder, tried))
      if (auto found = find_side_file(model, fs::path(*similar).lexically_relative(folder).string())) return found;
  return core::fail(fmt::format("'{}' not found", name));
}

}  // namespace sightline::importers
