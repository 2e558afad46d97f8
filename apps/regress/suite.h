// Suites of regression images: which views of which models are drawn, and how far they may differ from references
// (docs/guide/regress.md). A view of a model is a task: it needs no other one, so tasks can be drawn in any order, by
// anybody.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/common/model.h"
#include "sightline/core/view.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// Largest differences from the reference that pass; what has no limit is not looked at.
struct Limits {
  std::optional<double> max, mean;   ///< of a channel, 0 … 255
  std::optional<double> flip;        ///< mean FLIP, 0 … 1
  std::optional<std::uint64_t> ids;  ///< pixels that show another item

  bool any() const { return max || mean || flip || ids; }
};

struct SuiteModel {
  std::string name;
  ModelOptions options;
};

struct Task {
  std::string name;                ///< MODEL/VIEW
  std::size_t model = 0;           ///< in Suite::models
  std::optional<core::View> view;  ///< none: of the whole model
  std::array<int, 2> size{};
  int samples = 1;
  bool standard_looks = false;  ///< engine::Looks::standard(), with samples that are images of their own
  std::string colour_by;        ///< a key of query::colour_by(); empty: the model's own colours
  bool allow_empty = false;     ///< the view's sections may leave nothing
  Limits limits;
  std::string key;  ///< equal where the same is to be drawn; limits do not count, nor what files hold
};

struct Suite {
  std::string name;
  std::filesystem::path references;  ///< folder with MODEL/VIEW.png, and MODEL/VIEW.ids.png where ids have a limit
  std::vector<SuiteModel> models;
  std::vector<Task> tasks;  ///< by model
  std::string drawn_by;     ///< in words, where it is chosen

  std::filesystem::path reference(const Task& task) const { return references / (task.name + ".png"); }
  std::filesystem::path id_reference(const Task& task) const { return references / (task.name + ".ids.png"); }
  /// Equal while the same draws, and no file of the task, models, references and this program, was written to, by size
  /// and time.
  std::string files_key(const Task& task) const;
};

/// `instead`: limits that are used in place of the suite's, for ids where there is one. Errors name the file and the
/// place in it.
core::Expected<Suite> read_suite(const std::filesystem::path& file, const Limits& instead);

core::Expected<std::string> read_bytes(const std::filesystem::path& file);

json::Value limits_json(const Limits& limits);

/// Whether a name fits a pattern, in which * stands for any characters and ? for one.
bool fits(std::string_view name, std::string_view pattern);

}  // namespace sightline::apps
