#include "sightline/engine/internal/picking.h"

#include <chrono>
#include <system_error>
#include <utility>

#include "sightline/raytrace/tracer.h"

namespace sightline::engine {

core::Expected<void> make_tracer(SceneVersion& version, const std::stop_token& stop) {
  if (version.tracer) return {};
  auto tracer = raytrace::Tracer::create(*version.snapshot, 0, stop);
  if (!tracer) return tl::unexpected(tracer.error());
  version.tracer = std::make_shared<raytrace::Tracer>(std::move(*tracer));
  return {};
}

void follow_tracer(SceneVersion& version, std::span<const core::Slot> touched) {
  if (version.tracer && !version.tracer->update(touched)) version.tracer.reset();
}

std::size_t tracer_bytes(const SceneVersion& version) {
  return version.tracer ? version.tracer->memory().total() : 0;
}

void BackgroundTracer::begin(const SceneVersion& version) {
  if (version.tracer || made_.valid() || failed_) return;
  const core::Snapshot& snapshot = *version.snapshot;
  try {
    stop_ = {};
    made_ = std::async(std::launch::async, [&snapshot, stop = stop_.get_token()] {
      auto tracer = raytrace::Tracer::create(snapshot, 0, stop);
      return tracer ? std::make_shared<raytrace::Tracer>(std::move(*tracer)) : nullptr;
    });
  } catch (const std::system_error&) {
  }
}

void BackgroundTracer::finish(SceneVersion& version) {
  if (!made_.valid()) return;
  version.tracer = made_.get();
  failed_ = !version.tracer;
}

bool BackgroundTracer::ready() const {
  return !made_.valid() || made_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void BackgroundTracer::interrupt(SceneVersion& version) {
  stopped_ = !ready() && stops_ < kMostStops;
  if (stopped_) {
    ++stops_;
    stop_.request_stop();
  }
  finish(version);
  failed_ = false;
}

void BackgroundTracer::follow(const SceneVersion& version) {
  if (std::exchange(stopped_, false)) begin(version);
}

}  // namespace sightline::engine
