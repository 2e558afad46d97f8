#include "sightline/engine/internal/picking.h"

#include <system_error>
#include <utility>

#include "sightline/raytrace/tracer.h"

namespace sightline::engine {

core::Expected<void> make_tracer(Order& order) {
  if (order.tracer) return {};
  auto tracer = raytrace::Tracer::create(*order.snapshot);
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
    made_ = std::async(std::launch::async, [&snapshot] {
      auto tracer = raytrace::Tracer::create(snapshot);
      return tracer ? std::make_shared<raytrace::Tracer>(std::move(*tracer)) : nullptr;
    });
  } catch (const std::system_error&) {
  }
}

void BackgroundTracer::finish(Order& order) {
  if (made_.valid()) order.tracer = made_.get();
}

}  // namespace sightline::engine
