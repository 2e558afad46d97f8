// Writes models in the format that a file's name asks for, in the same way for every tool.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/importers/import.h"
#include "sightline/importers/obj/obj_writer.h"
#include "sightline/importers/tiles/tiles_writer.h"

namespace sightline::apps {

using ItemCounts = std::array<std::uint64_t, core::kKindCount>;
std::uint64_t total(const ItemCounts& items);

/// Fails unless models can be written under that name, and where it, or the file that its format has beside it, is one
/// of those that were or will be read: it would be lost.
core::Expected<void> check_output(const std::string& output, std::span<const std::string> read);
/// Fails where a folder of 3D Tiles cannot be written under that name without losing one of those files: it replaces what
/// is there.
core::Expected<void> check_tiles_folder(const std::string& folder, std::span<const std::string> read);
/// The files of a model, and those that they name.
std::vector<std::string> files_read(std::span<const std::string> files, const importers::ImportReport& report);

/// One file is written as itself; several become the groups of one. `tops`: the nodes of the files.
core::NodeId node_to_write(const core::Scene& scene, std::span<const core::NodeId> tops);

struct WriteOptions {
  double tolerance = importers::ObjWriteOptions{}.tolerance;  ///< of OBJ and glTF triangles, metres
  bool collections = false;                                   ///< GltfWriteOptions::collections
  bool tiles = false;                                         ///< 3D Tiles in a folder, whatever its name
  bool compress = true;                                       ///< TilesWriteOptions::compress
  bool levels = false;                                        ///< SlcWriteOptions::levels
  const importers::ImportReport* report = nullptr;            ///< SlcWriteOptions::report
  std::function<bool(double)> progress = {};                  ///< as ImportOptions::progress
};

/// Report of a written file, in any format.
struct WrittenModel {
  /// Triangles that stand for primitives.
  struct Tessellated {
    std::uint64_t triangles = 0, vertices = 0;
    double largest_chord_error = 0.0;
  };
  ItemCounts items{};
  std::uint64_t left_out = 0, bytes = 0;
  std::optional<Tessellated> triangles = {};   ///< none in RVM, which keeps primitives
  std::optional<std::uint64_t> analytic = {};  ///< of glTF
  std::optional<importers::TilesWriteReport> tiles = {};
};

/// Writes what lies below `top`, whole or not at all; all of the scene where the format is a scene cache. The name must
/// pass check_output().
core::Expected<WrittenModel> write_model(const core::Scene& scene, core::NodeId top, const std::string& output,
                                         const WriteOptions& options);

/// One line for people: "plant.obj: 990 of 1000 items, 2345 bytes, …". `items`: that were to be written.
std::string words_of(const WrittenModel& written, const std::string& output, std::uint64_t items);

}  // namespace sightline::apps
