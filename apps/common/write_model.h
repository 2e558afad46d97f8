// Where tools write models (importers/write_file.h), and what they say of it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/importers/import.h"
#include "sightline/importers/write_file.h"

namespace sightline::apps {

using ItemCounts = std::array<std::uint64_t, core::kKindCount>;
std::uint64_t total(const ItemCounts& items);

/// Fails unless models can be written under that name, and where it, or the file that its format has beside it, is one
/// of those that were or will be read: it would be lost.
core::Expected<void> check_output(const std::string& output, std::span<const std::string> read);
/// Fails where a folder of 3D Tiles cannot be written under that name without losing one of those files: it replaces
/// what is there.
core::Expected<void> check_tiles_folder(const std::string& folder, std::span<const std::string> read);
/// The files of a model, and those that they name.
std::vector<std::string> files_read(std::span<const std::string> files, const importers::ImportReport& report);

/// One file is written as itself; several become the groups of one. `tops`: the nodes of the files.
core::NodeId node_to_write(const core::Scene& scene, std::span<const core::NodeId> tops);

/// One line for people: "plant.obj: 990 of 1000 items, 2345 bytes, …". `items`: that were to be written.
std::string words_of(const importers::WriteReport& written, const std::string& output, std::uint64_t items);

}  // namespace sightline::apps
