// What a dialog that asks for files shows and answers: a folder's entries, those that are chosen, and the name that is
// typed. No window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/apps/common/file_formats.h"
#include "sightline/apps/view/file_states.h"
#include "sightline/core/error.h"

namespace sightline::apps {

struct FolderEntry {
  std::string name;
  bool folder = false;
};

/// What a folder holds, in no order. Fails in one line.
core::Expected<std::vector<FolderEntry>> read_folder(const std::filesystem::path& folder);

/// Whether a comes before b as people count: "a2" before "a10", capitals beside small letters.
bool natural_less(std::string_view a, std::string_view b);

/// As a path of `folder` unless it is absolute; "~" is the user's folder.
std::filesystem::path typed_path(const std::string& typed, const std::filesystem::path& folder);

/// A folder to go to at once.
struct Place {
  std::string name;
  std::filesystem::path folder;
  friend bool operator==(const Place&, const Place&) = default;
};
/// The user's folder, then those of the files that are open and of recent ones; each once, and only what is there.
std::vector<Place> places(std::span<const std::string> open, std::span<const std::string> recent);

/// What is asked for.
struct FileRequest {
  enum class Purpose {
    kOpen,         ///< a file that is there
    kOpenSeveral,  ///< or more of one folder
    kSave,         ///< a file that is there or not
    kFolder,       ///< a folder that is there or not
  };
  Purpose purpose = Purpose::kOpen;
  std::string all;                  ///< name of all formats together, such as "All models"; empty where files are saved
  std::vector<FileFormat> formats;  ///< none for folders
  std::string name = {};            ///< proposed
};

class FileBrowser {
 public:
  enum class Column { kName, kSize, kDate };
  enum class Choose {
    kAlone,   ///< instead of what was chosen
    kToggle,  ///< beside it
    kRange,   ///< all from the one that was chosen last
  };

  /// Asks anew, in that folder, or the nearest one above it that is there.
  void begin(FileRequest request, const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  void enter(const std::filesystem::path& folder);
  void go_up();
  /// Reads the folder again if its entries have come, gone or changed names since.
  void refresh();
  /// The folders from the root to this one.
  std::vector<Place> breadcrumb() const;

  std::size_t row_count() const { return rows_.size(); }
  const FolderEntry& row(std::size_t index) const { return entries_[rows_[index]]; }
  /// Size and date of a row, asked for by the first call: that takes far longer than to list a large folder.
  const FileState& state(std::size_t index) { return state_of_entry(rows_[index]); }
  bool chosen(std::size_t index) const { return chosen_[index]; }
  std::size_t chosen_count() const;
  std::optional<std::size_t> cursor() const { return cursor_; }  ///< the row that keys start from
  void choose(std::size_t index, Choose how);
  /// Moves the cursor down, or up where `rows` is below 0.
  void move(int rows, bool range);
  /// Folders stay before files.
  void sort(Column column, bool rising);

  /// "All models", the formats, "All files", with extensions.
  const std::vector<FileFormat>& filters() const { return filters_; }
  std::size_t filter() const { return filter_; }
  /// The typed name of a file that is saved gets the filter's extension in place of another one of the request's.
  void set_filter(std::size_t index);

  const std::string& typed() const { return typed_; }
  /// By the user. Moves the cursor to the first entry that begins so.
  void type(const std::string& text);
  /// Whether that text is a row's name and not the user's.
  bool typed_by_row() const { return typed_by_row_; }

  /// The answer, once there is one: what is typed, else what is chosen. A folder is entered instead.
  std::optional<std::vector<std::filesystem::path>> accept();
  /// The file that is there already and would be replaced: answered by replace() or keep().
  const std::optional<std::filesystem::path>& asks_to_replace() const { return replaced_; }
  std::vector<std::filesystem::path> replace();
  void keep() { replaced_.reset(); }

  /// Why there is no answer, or nothing to list; empty: nothing is wrong.
  const std::string& error() const { return error_; }
  void say(std::string error) { error_ = std::move(error); }

 private:
  using Paths = std::optional<std::vector<std::filesystem::path>>;
  void read();
  void list(std::vector<FolderEntry> entries);
  void take_name();
  Paths accept(std::filesystem::path path);
  Paths accept_chosen();
  bool listed(const FolderEntry& entry) const;
  const FileState& state_of_entry(std::size_t index);
  std::optional<std::size_t> row_beginning_with(const std::string& text) const;

  FileRequest request_;
  std::filesystem::path folder_;
  std::int64_t read_at_ = 0;  // the folder's own time when it was read
  std::vector<FolderEntry> entries_;
  std::vector<std::optional<FileState>> states_;  // of entries_, those that were asked for
  std::vector<std::size_t> rows_;                 // of entries_, in the order of the list
  std::vector<bool> chosen_;                      // rows
  std::optional<std::size_t> cursor_, anchor_;
  Column column_ = Column::kName;
  bool rising_ = true;
  std::vector<FileFormat> filters_;
  std::size_t filter_ = 0;
  std::string typed_;
  bool typed_by_row_ = false, shows_hidden_ = false;
  std::optional<std::filesystem::path> replaced_;
  std::string error_;
};

}  // namespace sightline::apps
