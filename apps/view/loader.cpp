#include "sightline/apps/view/loader.h"

#include <utility>

namespace sightline::apps {

Loader::Loader(const ModelOptions& options, std::function<void()> ready)
    : options_(options), thread_([this, ready = std::move(ready)] { run(ready); }) {}

Loader::~Loader() {
  cancel();
}

void Loader::run(const std::function<void()>& ready) {
  ModelOptions reading = options_;
  reading.quiet = true;
  reading.import.progress = [this](double share) {
    progress_ = share;
    return !cancelled_;
  };
  auto model = load_model(reading);
  if (model)
    if (auto committed = model->scene->commit(); !committed) model = tl::unexpected(committed.error());
  result_.emplace(std::move(model));
  done_ = true;
  ready();
}

std::optional<core::Expected<Model>> Loader::take() {
  if (!done_) return std::nullopt;
  return std::exchange(result_, std::nullopt);
}

}  // namespace sightline::apps
