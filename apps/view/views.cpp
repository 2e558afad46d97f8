#include "sightline/apps/view/views.h"

#include <utility>

#include "sightline/apps/view/small_image.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

std::string count_of_views(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " view" : " views");
}

using Done = core::Expected<void>;

constexpr int kSnapshotWidth = 320;

/// What is seen and shown now, with an image of it.
core::Expected<Viewpoint> seen_now(Viewer& viewer) {
  Session& session = *viewer.session();
  Viewpoint seen = session.viewpoint();
  if (auto drawn = session.draw(); !drawn) return tl::unexpected(drawn.error());
  const auto image = session.image(true);
  if (!image) return tl::unexpected(image.error());
  const image::Image small = shrunk(*image, kSnapshotWidth);
  if (small.width > 0 && small.height > 0)
    if (auto png = image::encode_png(small, image::PngSize::kSmall)) seen.snapshot = std::move(*png);
  return seen;
}

core::Expected<Viewpoint*> current(Viewer& viewer) {
  Viewpoint* view = viewer.views().current();
  return view ? core::Expected<Viewpoint*>(view) : core::fail("show a view first");
}

}  // namespace

core::Expected<void> add_view(Viewer& viewer, const std::string& name) {
  auto seen = seen_now(viewer);
  if (!seen) return tl::unexpected(seen.error());
  viewer.views().add(std::move(*seen), name);
  viewer.shown.tab = "Views";
  return {};
}

core::Expected<void> show_view(Viewer& viewer, const std::string& which) {
  const auto index = viewer.views().find(which);
  if (!index) return tl::unexpected(index.error());
  const Viewpoint& view = viewer.views().all()[*index];
  const auto missing = viewer.session()->show(view);
  if (!missing) return tl::unexpected(missing.error());
  viewer.views().set_current(*index);
  if (*missing > 0)
    viewer.tell(std::to_string(*missing) + " parts of this view are not in the model", true);
  else
    viewer.tell(view.name);
  return {};
}

core::Expected<void> update_view(Viewer& viewer, const std::string&) {
  if (auto view = current(viewer); !view) return tl::unexpected(view.error());
  auto seen = seen_now(viewer);
  if (!seen) return tl::unexpected(seen.error());
  viewer.views().update_current(std::move(*seen));
  return {};
}

core::Expected<void> rename_view(Viewer& viewer, const std::string& name) {
  const auto view = current(viewer);
  if (!view) return tl::unexpected(view.error());
  if (name.empty()) return core::fail("a view needs a name");
  (*view)->name = name;
  return {};
}

core::Expected<void> comment_view(Viewer& viewer, const std::string& text) {
  const auto view = current(viewer);
  if (!view) return tl::unexpected(view.error());
  (*view)->comment = text;
  return {};
}

core::Expected<void> delete_view(Viewer& viewer, const std::string& which) {
  const auto index = viewer.views().find(which);
  if (!index) return tl::unexpected(index.error());
  viewer.views().remove(*index);
  return {};
}

core::Expected<void> save_views(Viewer& viewer, const std::string& file) {
  if (file.empty()) return viewer.shown.dialog = Dialog::kSaveViews, Done();
  auto done = write_views(file, viewer.views().all());
  if (!done) return done;
  viewer.views().mark_saved();
  viewer.tell(count_of_views(viewer.views().size()) + " saved in " + file);
  return {};
}

core::Expected<void> load_views(Viewer& viewer, const std::string& file) {
  if (file.empty()) return viewer.shown.dialog = Dialog::kReadViews, Done();
  auto read = read_views(file);
  if (!read) return tl::unexpected(read.error());
  viewer.tell(count_of_views(read->views.size()) + " read from " + file +
              (read->left_out > 0 ? ", " + std::to_string(read->left_out) + " without a camera left out" : ""));
  viewer.views().merge(std::move(read->views));
  viewer.shown.tab = "Views";
  return {};
}

}  // namespace sightline::apps
