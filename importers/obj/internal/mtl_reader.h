// Internal to the reader of OBJ: material libraries (MTL).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/obj/internal/statement_lines.h"

namespace sightline::importers::obj {

/// The diffuse colour of a material that states none, as the format's description has it.
inline constexpr float kDefaultDiffuse = 0.8f;

/// A material, as far as the reader keeps it.
struct LibraryMaterial {
  std::string name;  // decoded
  std::optional<core::vec3> diffuse;
  std::optional<double> dissolve, transparency;
  std::string texture;  // arguments of map_Kd; empty when there is none
};

/// The materials of all libraries that a model names. Of equal names the first counts.
class MaterialLibraries {
 public:
  MaterialLibraries(ImportJob& job, const std::filesystem::path& model) : job_(job), model_(model) {}

  /// Reads the files that a mtllib statement names: its arguments are one name with spaces, or several names. Each file
  /// is read once, no matter how often and by which names it is asked for.
  void open(std::string_view arguments, const StatementLines& at);
  /// Null when no library has it.
  const LibraryMaterial* find(std::string_view name) const;
  const std::filesystem::path& model() const { return model_; }

 private:
  struct Reading;
  /// Reads all of these, or none and returns false. `guess`: also those with similar names, with a warning.
  bool open_all(const std::vector<std::string>& names, bool guess, const StatementLines& at);
  void read(const std::filesystem::path& path, const StatementLines& at);
  void keep(LibraryMaterial& material);

  ImportJob& job_;
  const std::filesystem::path& model_;
  std::set<std::string> asked_;
  std::set<std::filesystem::path> known_;
  std::vector<LibraryMaterial> materials_;
  std::map<std::string, std::size_t, std::less<>> place_of_name_;
};

}  // namespace sightline::importers::obj
