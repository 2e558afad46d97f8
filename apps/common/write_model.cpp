#include "sightline/apps/common/write_model.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <numeric>
#include <string_view>

#include <fmt/format.h>

#include "sightline/apps/common/file_formats.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/internal/extension.h"

namespace sightline::apps {
namespace {

/// Names the file that the format writes beside its own; empty: it writes none.
std::string companion_of(const std::string& output) {
  std::filesystem::path beside = core::platform::path_of(output);
  const std::string extension = importers::lower_case_extension(beside);
  if (extension == ".obj") {
    std::string name = beside.replace_extension(".mtl").filename().string();
    for (char& c : name)
      if (std::isspace(static_cast<unsigned char>(c))) c = '_';
    return beside.replace_filename(core::platform::path_of(name)).string();
  }
  return extension == ".gltf" ? beside.replace_extension(".bin").string() : std::string();
}

}  // namespace

std::uint64_t total(const ItemCounts& items) {
  return std::accumulate(items.begin(), items.end(), std::uint64_t{0});
}

core::Expected<void> check_output(const std::string& output, std::span<const std::string> read) {
  const std::vector<FileFormat> formats = written_formats();
  const auto is_of = [path = core::platform::path_of(output)](const FileFormat& format) { return format.has(path); };
  if (std::none_of(formats.begin(), formats.end(), is_of))
    return core::fail("expected a name ending in .rvm, .obj, .glb, .gltf, .stl, .ply or .slc, found \"" + output +
                      "\"");
  for (const std::string& written : {output, companion_of(output)})
    for (const std::string& file : read) {
      std::error_code absent;
      if (std::filesystem::equivalent(core::platform::path_of(file), core::platform::path_of(written), absent) &&
          !absent)
        return core::fail(written + " is also a file of the model that is read, and would be lost: take another name");
    }
  return {};
}

core::Expected<void> check_tiles_folder(const std::string& folder, std::span<const std::string> read) {
  namespace fs = std::filesystem;
  const fs::path path = core::platform::path_of(folder);
  for (const auto& formats : {written_formats(), model_formats()})
    for (const FileFormat& format : formats)
      if (format.has(path) && !fs::is_directory(path))
        return core::fail("expected the name of a folder, found \"" + folder + "\"");
  std::error_code absent;
  const fs::path place = fs::weakly_canonical(path, absent);
  for (const std::string& file : read) {
    const fs::path within = fs::weakly_canonical(core::platform::path_of(file), absent).lexically_relative(place);
    if (!within.empty() && *within.begin() != "..")
      return core::fail(file + " is read, lies in " + folder + ", and would be lost: take another folder");
  }
  return {};
}

std::vector<std::string> files_read(std::span<const std::string> files, const importers::ImportReport& report) {
  std::vector<std::string> all(files.begin(), files.end());
  for (const std::filesystem::path& file : report.side_files) all.push_back(file.string());
  return all;
}

core::NodeId node_to_write(const core::Scene& scene, std::span<const core::NodeId> tops) {
  return tops.size() == 1 ? tops[0] : scene.root();
}

std::string words_of(const importers::WriteReport& written, const std::string& output, std::uint64_t items) {
  std::string words = fmt::format("{}: {} of {} items, {} bytes", output, total(written.items), items, written.bytes);
  if (written.attributes_lost > 0)
    words += fmt::format(", without the attributes of {} nodes (.slc and .glb hold them)", written.attributes_lost);
  if (written.tiles) {
    const importers::TilesWriteReport& tiles = *written.tiles;
    return words + fmt::format(", {} tiles on {} levels, errors up to {:.3g} m, {} triangles", tiles.tiles,
                               tiles.levels, tiles.root_error, tiles.leaf_triangles);
  }
  if (!written.triangles) return words;
  return words + fmt::format(", {} triangles, at most {:.3g} m from the primitives they stand for",
                             written.triangles->triangles, written.triangles->largest_chord_error);
}

}  // namespace sightline::apps
