#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/view/actions.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::apps {

Done save_session(Workspace& work, const std::string& file) {
  if (file.empty()) return work.shown.dialog = Dialog::kSaveSession, Done();
  if (!session_format().has(core::platform::path_of(file)))
    return core::fail(file + ": expected a name that ends in .sightline");
  const auto saved = work.to_save();
  if (!saved) return core::fail("open a model first");
  if (auto done = write_session(*saved, core::platform::path_of(file)); !done) return done;
  work.views.mark_saved();
  work.session_file = file;
  work.shown.add_recent(file);
  work.messages.tell("session: " + file);
  return {};
}

Done append_model(Workspace& work, const std::string& file) {
  if (file.empty()) return work.shown.dialog = Dialog::kAppend, Done();
  return append_models(work, {file});
}

Done append_models(Workspace& work, const std::vector<std::string>& files) {
  auto saved = work.to_save();
  if (!saved) return core::fail("open a model first");
  saved->file = work.session_file;
  saved->reading.recognise = work.shown.recognise;
  for (const std::string& file : files) {
    saved->files.push_back(file);
    saved->appended += !importers::is_attribute_file(file);
  }
  work.open(std::move(*saved));
  if (work.shown.dialog == Dialog::kAppend) work.shown.dialog = Dialog::kNone;
  return {};
}

Done show_returning(Workspace& work) {
  const SavedSession saved = *std::exchange(work.returning, std::nullopt);
  work.session_file = saved.file;
  if (!saved.file.empty()) work.shown.add_recent(saved.file);
  work.views = ViewList();
  work.views.merge(saved.views);
  if (saved.current >= 0 && std::size_t(saved.current) < work.views.size())
    work.views.set_current(std::size_t(saved.current));
  work.views.mark_saved();
  const auto missing = work.session->show(saved.now);
  if (!missing) return tl::unexpected(missing.error());
  Session& session = *work.session;
  const std::vector<core::NodeId>& nodes = session.model().report.nodes;
  const std::vector<core::NodeId> fresh(nodes.end() - std::ptrdiff_t(std::min(saved.appended, nodes.size())),
                                        nodes.end());
  if (auto done = session.document.show(items_below(session.scene(), fresh)); !done) return done;
  if (!saved.older.empty())
    if (auto done = compare_with(work, saved.older); !done) return done;
  if (*missing > 0) work.messages.tell(std::to_string(*missing) + " parts of the session are no longer there", true);
  return {};
}

}  // namespace sightline::apps
