#include "sightline/apps/view/thumbnails.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <vector>

#include "sightline/apps/view/small_image.h"
#include "sightline/core/internal/atomic_file.h"
#include "sightline/core/internal/hash.h"
#include "sightline/gl/internal/program_cache.h"

namespace sightline::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".png";

/// As 16 digits.
std::string hash(std::string_view bytes) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(core::fnv1a(bytes)));
  return text;
}

std::string name_of_model(const std::string& model) {
  std::error_code none;
  const fs::path place = fs::weakly_canonical(model, none);
  return hash(none ? model : place.string()) + "-";
}

std::string name_of_version(const FileState& state) {
  return hash(std::to_string(state.bytes) + " " + std::to_string(state.changed.time_since_epoch().count()));
}

struct Kept {
  fs::path file;
  fs::file_time_type made;
};

/// Thumbnails whose names begin so, the newest first. What is not a thumbnail is not among them.
std::vector<Kept> kept(const fs::path& folder, const std::string& beginning) {
  std::vector<Kept> found;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    const std::size_t length = name_of_model("").size() + name_of_version({}).size() + kEnding.size();
    std::error_code none;
    if (name.size() == length && name.starts_with(beginning) && name.ends_with(kEnding))
      found.push_back({at->path(), at->last_write_time(none)});
  }
  std::sort(found.begin(), found.end(), [](const Kept& a, const Kept& b) { return a.made > b.made; });
  return found;
}

}  // namespace

fs::path Thumbnails::default_place() {
  const fs::path caches = gl::ProgramCache::default_folder();
  return caches.empty() ? caches : caches / "thumbnails";
}

bool Thumbnails::lacks(const std::string& model, const FileState& now) const {
  std::error_code none;
  return !folder_.empty() && now.there &&
         !fs::exists(folder_ / (name_of_model(model) + name_of_version(now) + std::string(kEnding)), none);
}

core::Expected<void> Thumbnails::keep(const std::string& model, const FileState& now, const image::Image& image) const {
  const auto png = image::encode_png(shrunk(image, kWidth), image::PngSize::kSmall);
  if (!png) return tl::unexpected(png.error());
  std::error_code none;
  if (fs::create_directories(folder_, none)) fs::permissions(folder_, fs::perms::owner_all, none);
  const fs::path file = folder_ / (name_of_model(model) + name_of_version(now) + std::string(kEnding));
  if (auto done = core::write_file(file, {std::as_bytes(std::span(*png))}); !done) return done;
  for (const Kept& older : kept(folder_, name_of_model(model)))
    if (older.file != file) fs::remove(older.file, none);
  const std::vector<Kept> all = kept(folder_, "");
  for (std::size_t i = kMost; i < all.size(); ++i) fs::remove(all[i].file, none);
  return {};
}

std::optional<image::Image> Thumbnails::read(const std::string& model) const {
  const std::vector<Kept> found = kept(folder_, name_of_model(model));
  if (folder_.empty() || found.empty()) return std::nullopt;
  auto image = image::read_png(found.front().file);
  return image ? std::optional(std::move(*image)) : std::nullopt;
}

}  // namespace sightline::apps
