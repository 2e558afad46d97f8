#include "sightline/apps/view/model_export.h"

#include <utility>

#include "sightline/apps/common/item_copier.h"
#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/common/write_model.h"

namespace sightline::apps {
namespace {

constexpr double kShareOfCopy = 0.3;  // of the progress, where there is a copy

std::vector<std::string> files_to_keep(const Session& session) {
  std::vector<std::string> all = files_read(session.files, session.model().report);
  if (session.changes()) all.push_back(session.changes()->file());
  return all;
}

/// Whether the scene has nothing but the job's items, where its files have them.
bool is_all(const ModelExport::Job& job) {
  const core::Scene& scene = *job.scene;
  const core::Affine& root = scene.transform(scene.root());
  return !job.items && root.linear == core::dmat3(1.0) && root.origin == core::dvec3(0.0) &&
         children_of(scene, scene.root()) == job.tops;
}

}  // namespace

core::Expected<ModelExport::Job> ModelExport::model(const Session& session, const std::string& file) {
  if (auto done = check_output(file, files_to_keep(session)); !done) return tl::unexpected(done.error());
  const importers::ImportReport& report = session.model().report;
  return Job{.scene = &session.scene(), .tops = report.nodes, .report = &report, .file = file};
}

core::Expected<ModelExport::Job> ModelExport::selection(const Session& session, const std::string& file) {
  auto job = model(session, file);
  if (!job) return job;
  job->items.emplace(session.scene().item_slots());
  for (const core::ItemId item : session.document.selection()) (*job->items)[to_index(item)] = true;
  return job;
}

ModelExport::ModelExport(Job job, std::function<void()> ready)
    : job_(std::move(job)), thread_([this, ready = std::move(ready)] {
        result_.emplace(write());
        done_ = true;
        ready();
      }) {}

ModelExport::~ModelExport() {
  cancel();
}

/// In the model's own frame, as all that the viewer tells of places.
core::Expected<std::string> ModelExport::write() {
  const auto progress_within = [this](double from, double to) {
    return [this, from, to](double share) {
      progress_ = from + share * (to - from);
      return !cancelled_;
    };
  };
  const auto write = [&](const core::Scene& scene, std::span<const core::NodeId> tops,
                         const importers::WriteOptions& options) -> core::Expected<std::string> {
    const auto written = importers::write_file(scene, node_to_write(scene, tops), job_.file, options);
    if (!written) return tl::unexpected(written.error());
    return words_of(*written, job_.file, scene.item_count());
  };
  if (is_all(job_))
    return write(*job_.scene, job_.tops, {.report = job_.report, .progress = progress_within(0.0, 1.0)});
  auto part =
      copy_of_part(*job_.scene, job_.tops, job_.items ? &*job_.items : nullptr, progress_within(0.0, kShareOfCopy));
  if (!part) return tl::unexpected(part.error());
  part->set_transform(part->root(), {});
  return write(*part, children_of(*part, part->root()), {.progress = progress_within(kShareOfCopy, 1.0)});
}

std::optional<core::Expected<std::string>> ModelExport::take() {
  if (!done_) return std::nullopt;
  return std::exchange(result_, std::nullopt);
}

}  // namespace sightline::apps
