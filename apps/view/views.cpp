#include <filesystem>
#include <utility>

#include "sightline/apps/common/output.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/image_marks.h"
#include "sightline/apps/view/small_image.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

std::string count_of_views(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " view" : " views");
}

constexpr int kSnapshotWidth = 320, kMarkedWidth = 640;  // pixels; words need more

/// What is seen and shown now, with an image of it and its marks.
core::Expected<Viewpoint> seen_now(const Workspace& work) {
  Session& session = *work.session;
  Viewpoint seen = session.viewpoint();
  if (auto drawn = session.image.draw(); !drawn) return tl::unexpected(drawn.error());
  const auto image = session.image.read(true);
  if (!image) return tl::unexpected(image.error());
  const Painter marks = image_marks(work);
  image::Image small = shrunk(*image, marks ? kMarkedWidth : kSnapshotWidth);
  if (const auto view = session.image.view(); marks && view) marks(*view, {small.width, small.height}).paint(small);
  if (small.width > 0 && small.height > 0)
    if (auto png = image::encode_png(small, image::PngSize::kSmall)) seen.snapshot = std::move(*png);
  return seen;
}

core::Expected<Viewpoint*> current(ViewList& views) {
  Viewpoint* view = views.current();
  return view ? core::Expected<Viewpoint*>(view) : core::fail("show a view first");
}

}  // namespace

Done add_view(Workspace& work, const std::string& name) {
  auto seen = seen_now(work);
  if (!seen) return tl::unexpected(seen.error());
  work.views.add(std::move(*seen), name);
  work.shown.tab = "Views";
  return {};
}

Done show_view(const std::string& which, Session& session, ViewList& views, Messages& messages) {
  const auto index = views.find(which);
  if (!index) return tl::unexpected(index.error());
  const Viewpoint& view = views.all()[*index];
  const auto missing = session.show(view);
  if (!missing) return tl::unexpected(missing.error());
  views.set_current(*index);
  if (*missing > 0)
    messages.tell(std::to_string(*missing) + " parts of this view are not in the model", true);
  else
    messages.tell(view.name);
  return {};
}

Done update_view(Workspace& work, const std::string&) {
  if (auto view = current(work.views); !view) return tl::unexpected(view.error());
  auto seen = seen_now(work);
  if (!seen) return tl::unexpected(seen.error());
  work.views.update_current(std::move(*seen));
  return {};
}

Done rename_view(const std::string& name, ViewList& views) {
  const auto view = current(views);
  if (!view) return tl::unexpected(view.error());
  if (name.empty()) return core::fail("a view needs a name");
  (*view)->name = name;
  return {};
}

template <std::string Viewpoint::*kText>
static Done set_text(const std::string& text, ViewList& views) {
  return current(views).map([&](Viewpoint* view) { view->*kText = text; });
}

Done comment_view(const std::string& text, ViewList& views) {
  return set_text<&Viewpoint::comment>(text, views);
}

Done set_view_status(const std::string& text, ViewList& views) {
  return set_text<&Viewpoint::status>(text, views);
}

Done set_view_type(const std::string& text, ViewList& views) {
  return set_text<&Viewpoint::type>(text, views);
}

Done delete_view(const std::string& which, ViewList& views) {
  const auto index = views.find(which);
  if (!index) return tl::unexpected(index.error());
  views.remove(*index);
  return {};
}

Done save_views(const std::string& file, ViewList& views, Shown& shown, Messages& messages) {
  if (file.empty()) return shown.dialog = Dialog::kSaveViews, Done();
  auto done = write_views(file, views.all());
  if (!done) return done;
  views.mark_saved();
  messages.tell(count_of_views(views.size()) + " saved in " + file);
  return {};
}

Done load_views(const std::string& file, ViewList& views, Shown& shown, Messages& messages) {
  if (file.empty()) return shown.dialog = Dialog::kReadViews, Done();
  auto read = read_views(file);
  if (!read) return tl::unexpected(read.error());
  messages.tell(count_of_views(read->views.size()) + " read from " + file +
                (read->left_out > 0 ? ", " + std::to_string(read->left_out) + " without a camera left out" : ""));
  views.merge(std::move(read->views));
  shown.tab = "Views";
  return {};
}

Done save_view(const std::string& file, Session& session, Messages& messages) {
  const std::string name = file.empty() ? free_name("view", ".json") : file;
  auto done = write_text(name, format_viewpoint(session.viewpoint()));
  if (done) messages.tell("view: " + name);
  return done;
}

Done load_view(const std::string& file, Session& session, ViewList& views, Shown& shown, Messages& messages) {
  const auto read = read_views(file);
  if (!read) return tl::unexpected(read.error());
  if (is_bcf(file) || read->views.size() != 1) return load_views(file, views, shown, messages);
  const auto missing = session.show(read->views.front());
  return missing ? Done() : tl::unexpected(missing.error());
}

std::string free_name(const std::string& stem, const std::string& extension) {
  for (int i = 1;; ++i)
    if (std::string name = stem + "-" + std::to_string(i) + extension; !std::filesystem::exists(name)) return name;
}

}  // namespace sightline::apps
