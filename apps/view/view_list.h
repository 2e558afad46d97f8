// The viewer's list of viewpoints, and its files.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "sightline/apps/common/file_formats.h"
#include "sightline/apps/viewpoints/viewpoint.h"
#include "sightline/core/error.h"

namespace sightline::apps {

class ViewList {
 public:
  const std::vector<Viewpoint>& all() const { return views_; }
  std::size_t size() const { return views_.size(); }
  Viewpoint* current() { return current_ < views_.size() ? &views_[current_] : nullptr; }
  const Viewpoint* current() const { return current_ < views_.size() ? &views_[current_] : nullptr; }
  /// Its index, or -1.
  int current_index() const { return current_ < views_.size() ? int(current_) : -1; }

  /// Becomes the current one. Gets a GUID, the date of today, an author and, where it has none, a name.
  void add(Viewpoint view, const std::string& name);
  /// Shows something else from now on; name, comment, GUID and what else is the view's own stay.
  void update_current(Viewpoint seen);
  /// By its name, else by its number from 1; the current one where `which` is empty. It does not become current.
  core::Expected<std::size_t> find(const std::string& which) const;
  void set_current(std::size_t index) { current_ = index; }
  void remove(std::size_t index);
  /// The current one changes places with the one before (-1) or behind it (1), if there is one.
  void move_current(int by);
  /// Adds views of a file. One with the GUID of a view of the list takes its place.
  void merge(std::vector<Viewpoint> views);

  /// A file has all views as they are now.
  void mark_saved();
  /// How many views are as no file has them.
  std::size_t unsaved() const;

 private:
  static constexpr std::size_t kNoView = std::size_t(-1);

  std::string free_name() const;

  std::vector<Viewpoint> views_;
  std::unordered_set<std::string> saved_;  // views that some file has, as text
  std::size_t current_ = kNoView;
};

std::string new_guid();

/// BCF (bcf.h) or JSON (viewpoint.h), by the extension: .bcf and .bcfzip are BCF. At most 256 MiB.
core::Expected<ViewFile> read_views(const std::filesystem::path& file);
core::Expected<void> write_views(const std::filesystem::path& file, std::span<const Viewpoint> views);
bool is_bcf(const std::filesystem::path& file);
std::vector<FileFormat> view_formats();  ///< that this build reads and writes

}  // namespace sightline::apps
