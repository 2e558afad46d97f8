// What engines tell, and what is told to them about images.
#pragma once

#include "sightline/bindings/python/convert.h"
#include "sightline/engine/engine.h"

namespace sightline::python {

/// culling::CullStates by item instead of slot, with boxes in the world.
struct ItemStates {
  std::vector<std::uint8_t> of_item;
  std::vector<std::int64_t> items;  // by state
  std::vector<double> boxes;        // six each
  std::vector<std::uint8_t> box_states;
  std::vector<std::uint32_t> box_items;
};
ItemStates states_by_item(const culling::CullStates& states, const core::Snapshot& snapshot, std::size_t items);

/// What a hybrid's controller has done so far.
struct ControllerReport {
  culling::ControllerState state = culling::ControllerState::kCpu;
  std::uint64_t frames = 0, switches = 0, probes = 0;
};

/// Fails without a size.
void check_target(const gl::ExternalTarget& target);

void bind_reports(py::module_& m);
void bind_targets(py::module_& m);

}  // namespace sightline::python
