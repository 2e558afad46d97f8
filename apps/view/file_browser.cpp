#include "sightline/apps/view/file_browser.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <system_error>
#include <utility>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;

using Purpose = FileRequest::Purpose;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The digits at `at`, without zeros before them; `at` moves behind them.
std::string_view number_at(std::string_view text, std::size_t& at) {
  while (at < text.size() && text[at] == '0') ++at;
  const std::size_t begin = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return text.substr(begin, at - begin);
}

/// Below 0, 0 or above 0, as a comes before, with or behind b.
int natural_order(std::string_view a, std::string_view b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string_view x = number_at(a, i), y = number_at(b, j);
      if (x.size() != y.size()) return x.size() < y.size() ? -1 : 1;
      if (const int order = x.compare(y); order != 0) return order;
      continue;
    }
    const auto x = static_cast<unsigned char>(core::lower_case(a[i++])),
               y = static_cast<unsigned char>(core::lower_case(b[j++]));
    if (x != y) return x < y ? -1 : 1;
  }
  return int(i < a.size()) - int(j < b.size());
}

bool begins_with(std::string_view text, std::string_view beginning) {
  return text.size() >= beginning.size() &&
         std::equal(beginning.begin(), beginning.end(), text.begin(),
                    [](char a, char b) { return core::lower_case(a) == core::lower_case(b); });
}

std::optional<fs::path> home() {
  const fs::path folder = core::platform::home_folder();
  return folder.empty() ? std::nullopt : std::optional(folder);
}

bool is_folder(const fs::path& path) {
  std::error_code none;
  return fs::is_directory(path, none);
}

/// Absolute, without ".", ".." and a separator at the end.
fs::path tidy(const fs::path& path) {
  std::error_code none;
  fs::path whole = fs::absolute(path, none).lexically_normal();
  return whole.has_filename() || !whole.has_relative_path() ? whole : whole.parent_path();
}

std::string name_of_folder(const fs::path& folder) {
  return folder.has_filename() ? folder.filename().string() : folder.string();
}

std::vector<FileFormat> filters_of(const FileRequest& request) {
  if (request.formats.empty() || request.purpose == Purpose::kSave) return request.formats;
  std::vector<FileFormat> filters = request.formats;
  if (filters.size() > 1) {
    FileFormat all{request.all, {}};
    for (const FileFormat& format : request.formats)
      all.extensions.insert(all.extensions.end(), format.extensions.begin(), format.extensions.end());
    filters.insert(filters.begin(), std::move(all));
  }
  filters.push_back({"All files", {}});
  return filters;
}

std::optional<std::vector<fs::path>> one(const fs::path& path) {
  return std::vector<fs::path>{path};
}

const FileFormat* format_of(const FileRequest& request, const fs::path& file) {
  const auto found = std::find_if(request.formats.begin(), request.formats.end(),
                                  [&](const FileFormat& format) { return format.has(file); });
  return found == request.formats.end() ? nullptr : &*found;
}

}  // namespace

core::Expected<std::vector<FolderEntry>> read_folder(const fs::path& folder) {
  std::error_code error;
  std::vector<FolderEntry> entries;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code none;
    entries.push_back({at->path().filename().string(), at->is_directory(none)});
  }
  if (error) return core::fail(folder.string() + ": cannot be read: " + error.message());
  return entries;
}

bool natural_less(std::string_view a, std::string_view b) {
  const int order = natural_order(a, b);
  return order != 0 ? order < 0 : a < b;
}

fs::path typed_path(const std::string& typed, const fs::path& folder) {
  const auto own = home();
  if (own && (typed == "~" || typed.starts_with("~/")))
    return (*own / typed.substr(std::min<std::size_t>(2, typed.size()))).lexically_normal();
  return (folder / typed).lexically_normal();
}

std::vector<Place> places(std::span<const std::string> open, std::span<const std::string> recent) {
  std::vector<Place> all;
  const auto add = [&](const fs::path& folder, const std::string& name) {
    const auto same = [&](const Place& place) { return place.folder == folder; };
    if (std::none_of(all.begin(), all.end(), same) && is_folder(folder)) all.push_back({name, folder});
  };
  if (const auto own = home()) add(tidy(*own), "Home");
  for (const auto& files : {open, recent})
    for (const std::string& file : files)
      if (const fs::path folder = tidy(file).parent_path(); !folder.empty()) add(folder, name_of_folder(folder));
  return all;
}

void FileBrowser::begin(FileRequest request, const fs::path& folder) {
  request_ = std::move(request);
  filters_ = filters_of(request_);
  const auto fits = std::find_if(filters_.begin(), filters_.end(),
                                 [&](const FileFormat& filter) { return filter.has(request_.name); });
  filter_ = request_.purpose == Purpose::kSave && fits != filters_.end() ? std::size_t(fits - filters_.begin()) : 0;
  typed_ = request_.name;
  typed_by_row_ = false;
  replaced_.reset();
  fs::path nearest = tidy(folder);
  while (!is_folder(nearest) && nearest.has_relative_path()) nearest = nearest.parent_path();
  enter(nearest);
}

void FileBrowser::enter(const fs::path& folder) {
  const bool keeps_name =
      request_.purpose == Purpose::kSave || (request_.purpose == Purpose::kFolder && !typed_by_row_);
  if (!keeps_name) typed_.clear();
  typed_by_row_ = false;
  folder_ = tidy(folder);
  list({});
  read();
}

void FileBrowser::go_up() {
  if (!folder_.has_relative_path()) return;
  const std::string left = folder_.filename().string();
  enter(folder_.parent_path());
  if (request_.purpose == Purpose::kFolder) return;
  for (std::size_t i = 0; i < row_count(); ++i)
    if (row(i).name == left) return choose(i, Choose::kAlone);
}

/// A file that only grows does not change its folder; its size is then that of before.
void FileBrowser::refresh() {
  std::error_code none;
  if (core::platform::write_time(folder_, none) != read_at_) read();
}

void FileBrowser::read() {
  std::error_code none;
  read_at_ = core::platform::write_time(folder_, none);
  auto entries = read_folder(folder_);
  error_ = entries ? "" : entries.error().message;
  list(std::move(entries).value_or(std::vector<FolderEntry>()));
}

bool FileBrowser::listed(const FolderEntry& entry) const {
  if (entry.name.starts_with('.') && !shows_hidden_) return false;
  if (entry.folder) return true;
  if (filters_.empty()) return false;
  return filters_[filter_].extensions.empty() || filters_[filter_].has(entry.name);
}

const FileState& FileBrowser::state_of_entry(std::size_t index) {
  auto& state = states_[index];
  if (!state) state = state_of(folder_ / entries_[index].name);
  return *state;
}

/// Entries that are chosen stay so.
void FileBrowser::list(std::vector<FolderEntry> entries) {
  std::set<std::string> chosen;
  for (std::size_t i = 0; i < row_count(); ++i)
    if (chosen_[i]) chosen.insert(row(i).name);
  const std::string at = cursor_ ? row(*cursor_).name : "";
  entries_ = std::move(entries);
  states_.assign(entries_.size(), std::nullopt);
  shows_hidden_ = typed_.starts_with('.');
  rows_.clear();
  for (std::size_t i = 0; i < entries_.size(); ++i)
    if (listed(entries_[i])) rows_.push_back(i);
  if (column_ != Column::kName)
    for (const std::size_t i : rows_) state_of_entry(i);
  std::sort(rows_.begin(), rows_.end(), [this](std::size_t i, std::size_t j) {
    const FolderEntry &a = entries_[i], &b = entries_[j];
    if (a.folder != b.folder) return a.folder;
    const FolderEntry &first = rising_ ? a : b, &second = rising_ ? b : a;
    if (column_ == Column::kName) return natural_less(first.name, second.name);
    const FileState &x = *states_[rising_ ? i : j], &y = *states_[rising_ ? j : i];
    if (column_ == Column::kSize && x.bytes != y.bytes) return x.bytes < y.bytes;
    if (column_ == Column::kDate && x.changed != y.changed) return x.changed < y.changed;
    return natural_less(a.name, b.name);
  });
  chosen_.assign(rows_.size(), false);
  cursor_.reset();
  for (std::size_t i = 0; i < row_count(); ++i) {
    chosen_[i] = chosen.contains(row(i).name);
    if (row(i).name == at) cursor_ = i;
  }
  anchor_ = cursor_;
}

std::vector<Place> FileBrowser::breadcrumb() const {
  std::vector<Place> parts;
  fs::path folder;
  for (const fs::path& part : folder_) {
    folder /= part;
    if (folder == folder_.root_name()) continue;  // not a folder without the separator behind it
    parts.push_back({name_of_folder(folder), folder});
  }
  return parts;
}

std::size_t FileBrowser::chosen_count() const {
  return std::size_t(std::count(chosen_.begin(), chosen_.end(), true));
}

void FileBrowser::choose(std::size_t index, Choose how) {
  if (index >= row_count()) return;
  if (request_.purpose != Purpose::kOpenSeveral) how = Choose::kAlone;
  error_.clear();
  cursor_ = index;
  if (how == Choose::kToggle) {
    chosen_[index] = !chosen_[index];
  } else {
    const std::size_t from = how == Choose::kRange ? anchor_.value_or(index) : index;
    chosen_.assign(row_count(), false);
    for (std::size_t i = std::min(from, index); i <= std::max(from, index); ++i) chosen_[i] = true;
  }
  if (how != Choose::kRange || !anchor_) anchor_ = index;
  take_name();
}

/// A folder leaves the name of what is saved as it is.
void FileBrowser::take_name() {
  typed_by_row_ = true;
  const auto first = std::find(chosen_.begin(), chosen_.end(), true);
  if (chosen_count() != 1) return typed_.clear();
  const FolderEntry& entry = row(std::size_t(first - chosen_.begin()));
  if (!entry.folder || request_.purpose != Purpose::kSave) typed_ = entry.name;
}

void FileBrowser::move(int rows, bool range) {
  if (row_count() == 0) return;
  const auto last = std::ptrdiff_t(row_count()) - 1;
  const std::ptrdiff_t from = cursor_ ? std::ptrdiff_t(*cursor_) : rows > 0 ? -1 : last + 1;
  choose(std::size_t(std::clamp(from + rows, std::ptrdiff_t(0), last)), range ? Choose::kRange : Choose::kAlone);
}

void FileBrowser::sort(Column column, bool rising) {
  if (column == column_ && rising == rising_) return;
  column_ = column;
  rising_ = rising;
  list(entries_);
}

void FileBrowser::set_filter(std::size_t index) {
  if (index >= filters_.size()) return;
  filter_ = index;
  if (request_.purpose == Purpose::kSave && format_of(request_, typed_) && !filters_[index].has(typed_))
    typed_ = fs::path(typed_).replace_extension(filters_[index].extensions.front()).string();
  list(entries_);
}

void FileBrowser::type(const std::string& text) {
  typed_ = text;
  typed_by_row_ = false;
  error_.clear();
  if (shows_hidden_ != text.starts_with('.')) list(entries_);
  chosen_.assign(row_count(), false);
  cursor_ = anchor_ = row_beginning_with(text);
}

std::optional<std::size_t> FileBrowser::row_beginning_with(const std::string& text) const {
  for (std::size_t i = 0; i < row_count() && !text.empty(); ++i)
    if (begins_with(row(i).name, text)) return i;
  return std::nullopt;
}

FileBrowser::Paths FileBrowser::accept() {
  error_.clear();
  if (typed_by_row_ && chosen_count() > 0) return accept_chosen();
  if (!typed_.empty()) return accept(typed_path(typed_, folder_));
  return request_.purpose == Purpose::kFolder ? one(folder_) : std::nullopt;
}

/// Accepts what is chosen; among several entries folders do not count.
FileBrowser::Paths FileBrowser::accept_chosen() {
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < row_count(); ++i)
    if (chosen_[i] && !row(i).folder) files.push_back(folder_ / row(i).name);
  const auto first = std::size_t(std::find(chosen_.begin(), chosen_.end(), true) - chosen_.begin());
  if (files.empty() || request_.purpose == Purpose::kSave) return accept(folder_ / row(first).name);
  return files;
}

FileBrowser::Paths FileBrowser::accept(fs::path path) {
  std::error_code none;
  const bool named_as_folder = !path.has_filename();
  if (is_folder(path) && (named_as_folder || request_.purpose != Purpose::kFolder)) {
    if (!typed_by_row_) typed_ = request_.name;
    return enter(path), std::nullopt;
  }
  switch (request_.purpose) {
    case Purpose::kOpen:
    case Purpose::kOpenSeveral:
      if (fs::exists(path, none)) return one(path);
      if (const auto row = row_beginning_with(typed_)) return choose(*row, Choose::kAlone), accept_chosen();
      error_ = path.string() + (named_as_folder ? ": no such folder" : ": no such file");
      return std::nullopt;
    case Purpose::kSave:
      if (named_as_folder || !is_folder(path.parent_path())) {
        error_ = path.parent_path().string() + ": no such folder";
        return std::nullopt;
      }
      if (!format_of(request_, path)) path += filters_[filter_].extensions.front();
      if (!fs::exists(path, none)) return one(path);
      if (fs::is_regular_file(path, none))
        replaced_ = path;
      else
        error_ = path.string() + ": is no file that could be replaced";
      return std::nullopt;
    case Purpose::kFolder:
      if (!fs::exists(path, none)) return one(tidy(path));
      if (is_folder(path)) return one(path);
      error_ = path.string() + ": is a file, expected a folder";
      return std::nullopt;
  }
  return std::nullopt;
}

std::vector<fs::path> FileBrowser::replace() {
  return {*std::exchange(replaced_, std::nullopt)};
}

}  // namespace sightline::apps
