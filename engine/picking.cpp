#include "sightline/engine/internal/picking.h"

#include <chrono>
#include <system_error>
#include <utility>

#include "sightline/raytrace/tracer.h"

namespace sightline::engine {

core::Expected<void> make_tracer(Order& order, const std::stop_token& stop) {
  if (order.tracer) return {};
  auto tracer = raytrace::Tracer::create(*order.snapshot, 0, stop);
  if (!tracer) return tl::unexpected(tracer.error());
  order.tracer = std::make_shared<raytrace::Tracer>(std::move(*tracer));
  return {};
}

void follow_tracer(Order& order, std::span<const core::Slot> touched) {
  if (order.tracer && !order.tracer->update(touched)) order.tracer.reset();
}

std::size_t tracer_bytes(const Order& order) {
  return order.tracer ? order.tracer->memory().total() : 0;
}

void BackgroundTracer::begin(const Order& order) {
  if (order.tracer || made_.valid()) return;
  const core::Snapshot& snapshot = *order.snapshot;
  try {
    stop_ = {};
    made_ = std::async(std::launch::async, [&snapshot, stop = stop_.get_token()] {
      auto tracer = raytrace::Tracer::create(snapshot, 0, stop);
      return tracer ? std::make_shared<raytrace::Tracer>(std::move(*tracer)) : nullptr;
    });
  } catch (const std::system_error&) {
  }
}

void BackgroundTracer::finish(Order& order) {
  if (made_.valid()) order.tracer = made_.get();
}

bool BackgroundTracer::ready() const {
  return !made_.valid() || made_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void BackgroundTracer::interrupt(Order& order) {
  stopped_ = !ready() && stops_ < kMostStops;
  if (stopped_) {
    ++stops_;
    stop_.request_stop();
  }
  finish(order);
}

void BackgroundTracer::follow(const Order& order) {
  if (std::exchange(stopped_, false)) begin(order);
}

}  // namespace sightline::engine
