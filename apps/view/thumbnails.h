// Small images of models that were open, kept as PNG files from run to run. No window.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "sightline/apps/view/file_states.h"
#include "sightline/core/error.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

/// A file's name is a hash of the model's canonical path, then one of the size and time of the model that it shows.
/// Several viewers may share the folder: a file appears whole or not at all.
class Thumbnails {
 public:
  static constexpr int kWidth = 256;  ///< pixels
  static constexpr std::size_t kMost = 64;

  /// Keeps none.
  Thumbnails() = default;
  explicit Thumbnails(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// sightline/thumbnails in the user's folder of caches; empty where there is none.
  static std::filesystem::path default_place();

  /// Whether one should be made of a model as it is now.
  bool lacks(const std::string& model, const FileState& now) const;
  /// In place of older ones of the model. Where there are more than kMost, the oldest are removed.
  core::Expected<void> keep(const std::string& model, const FileState& now, const image::Image& image) const;
  /// The one of a model, also of an earlier version.
  std::optional<image::Image> read(const std::string& model) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace sightline::apps
