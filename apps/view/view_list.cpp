#include "sightline/apps/view/view_list.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <random>
#include <utility>

#include "sightline/apps/viewpoints/bcf.h"
#include "sightline/core/internal/atomic_file.h"

namespace sightline::apps {
namespace {

constexpr std::uintmax_t kMostListBytes = std::uintmax_t(256) << 20;

core::Expected<std::string> read_bytes(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) return core::fail(file.string() + ": cannot be read: " + error.message());
  if (size > kMostListBytes)
    return core::fail(file.string() + ": expected at most 256 MiB, found " + std::to_string(size) + " bytes");
  std::ifstream in(file, std::ios::binary);
  std::string bytes(size, '\0');
  if (!in.read(bytes.data(), std::streamsize(size))) return core::fail(file.string() + ": cannot be read");
  return bytes;
}

}  // namespace

std::string new_guid() {
  std::random_device random;
  std::string guid;
  for (int i = 0; i < 32; ++i) {
    if (i == 8 || i == 12 || i == 16 || i == 20) guid += '-';
    const unsigned digit = i == 12 ? 4u : i == 16 ? 8u + random() % 4 : random() % 16;  // version 4: random
    guid += "0123456789abcdef"[digit];
  }
  return guid;
}

std::string ViewList::free_name() const {
  for (std::size_t i = views_.size() + 1;; ++i) {
    std::string name = "View " + std::to_string(i);
    if (std::none_of(views_.begin(), views_.end(), [&](const Viewpoint& view) { return view.name == name; }))
      return name;
  }
}

void ViewList::add(Viewpoint view, const std::string& name) {
  view.name = name.empty() ? free_name() : name;
  view.guid = new_guid();
  view.date = date_now();
  view.author = author_name();
  views_.push_back(std::move(view));
  current_ = views_.size() - 1;
}

void ViewList::update_current(Viewpoint seen) {
  Viewpoint& view = views_[current_];
  for (const auto text : {&Viewpoint::name, &Viewpoint::comment, &Viewpoint::author, &Viewpoint::guid, &Viewpoint::date,
                          &Viewpoint::status, &Viewpoint::type})
    seen.*text = std::move(view.*text);
  seen.origin = std::move(view.origin);
  view = std::move(seen);
}

core::Expected<std::size_t> ViewList::find(const std::string& which) const {
  if (which.empty()) return current() ? core::Expected<std::size_t>(current_) : core::fail("show a view first");
  for (std::size_t i = 0; i < views_.size(); ++i)
    if (views_[i].name == which) return i;
  std::size_t number = 0;
  const char* end = which.data() + which.size();
  const auto read = std::from_chars(which.data(), end, number);
  if (read.ec == std::errc() && read.ptr == end && number >= 1 && number <= views_.size()) return number - 1;
  return core::fail("there is no view \"" + which + "\" among " + std::to_string(views_.size()));
}

void ViewList::remove(std::size_t index) {
  views_.erase(views_.begin() + std::ptrdiff_t(index));
  if (current_ == index)
    current_ = kNoView;
  else if (current_ != kNoView && current_ > index)
    --current_;
}

void ViewList::move_current(int by) {
  const std::size_t to = current_ + std::size_t(by);
  if (!current() || to >= views_.size()) return;
  std::swap(views_[current_], views_[to]);
  current_ = to;
}

void ViewList::merge(std::vector<Viewpoint> views) {
  for (Viewpoint& view : views) {
    if (view.name.empty()) view.name = free_name();
    const auto same = std::find_if(views_.begin(), views_.end(),
                                   [&](const Viewpoint& v) { return !view.guid.empty() && v.guid == view.guid; });
    if (view.guid.empty()) view.guid = new_guid();
    saved_.insert(format_viewpoint(view));
    if (same != views_.end())
      *same = std::move(view);
    else
      views_.push_back(std::move(view));
  }
}

void ViewList::mark_saved() {
  saved_.clear();
  for (const Viewpoint& view : views_) saved_.insert(format_viewpoint(view));
}

std::size_t ViewList::unsaved() const {
  return std::size_t(std::count_if(views_.begin(), views_.end(),
                                   [&](const Viewpoint& view) { return !saved_.contains(format_viewpoint(view)); }));
}

bool is_bcf(const std::filesystem::path& file) {
  return bcf_format().has(file);
}

std::vector<FileFormat> view_formats() {
#ifdef SIGHTLINE_HAS_BCF
  return {bcf_format(), json_format()};
#else
  return {json_format()};
#endif
}

core::Expected<ViewFile> read_views(const std::filesystem::path& file) {
  const auto bytes = read_bytes(file);
  if (!bytes) return tl::unexpected(bytes.error());
  if (is_bcf(file)) return parse_bcf(*bytes, file.string());
  auto views = parse_viewpoints(*bytes, file.string());
  if (!views) return tl::unexpected(views.error());
  return ViewFile{std::move(*views), 0};
}

core::Expected<void> write_views(const std::filesystem::path& file, std::span<const Viewpoint> views) {
  const auto bytes = is_bcf(file) ? format_bcf(views) : core::Expected<std::string>(format_viewpoints(views));
  if (!bytes) return core::fail(file.string() + ": " + bytes.error().message);
  return core::write_file(file, {std::as_bytes(std::span(*bytes))});
}

}  // namespace sightline::apps
