#include "sightline/apps/view/loader.h"

#include <utility>

namespace sightline::apps {

Loader::Loader(const ModelOptions& options, std::function<void()> ready, Work work)
    : options_(options), thread_([this, ready = std::move(ready), work = std::move(work)] { run(ready, work); }) {}

Loader::~Loader() {
  cancel();
}

void Loader::run(const std::function<void()>& ready, const Work& work) {
  result_.emplace(read(work));
  done_ = true;
  ready();
}

core::Expected<Model> Loader::read(const Work& work) {
  const auto progress_within = [this](double from, double to) {
    return [this, from, to](double share) {
      progress_ = from + share * (to - from);
      return !cancelled_;
    };
  };
  const double share_of_reading = work ? 0.5 : 1.0;
  ModelOptions reading = options_;
  reading.quiet = true;
  reading.import.progress = progress_within(0.0, share_of_reading);
  auto model = load_model(reading);
  read_at_ = std::chrono::steady_clock::now();
  if (!model) return model;
  if (auto committed = model->scene->commit(); !committed) return tl::unexpected(committed.error());
  if (!work) return model;
  if (auto done = work(*model, progress_within(share_of_reading, 1.0)); !done) return tl::unexpected(done.error());
  return model;
}

std::optional<core::Expected<Model>> Loader::take() {
  if (!done_) return std::nullopt;
  return std::exchange(result_, std::nullopt);
}

}  // namespace sightline::apps
