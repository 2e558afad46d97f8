#include "sightline/culling/hybrid/controller.h"

#include <algorithm>

namespace sightline::culling {
namespace {

std::variant<FrameCost, Policy2009> make_policy(const ControllerConfig& config) {
  if (config.policy == Policy::kFrameCost) return FrameCost(config.frame_cost);
  return Policy2009(config.policy_2009);
}

}  // namespace

Controller::Controller(const ControllerConfig& config) : policy_(make_policy(config)) {}

CullPath Controller::next() {
  ++frames_;
  return std::visit([](auto& policy) { return policy.next(); }, policy_);
}

void Controller::feed(const FrameSample& sample) {
  std::uint64_t& newest = newest_[sample.path == CullPath::kGpu];
  if (sample.frame >= frames_ || sample.frame < newest || sample.frame < measured_from_) return;
  if (frames_ - sample.frame > kOldestSample) return;
  newest = sample.frame + 1;
  std::visit([&](auto& policy) { policy.feed(sample); }, policy_);
}

void Controller::scene_changed(double items) {
  std::visit([=](auto& policy) { policy.scene_changed(items); }, policy_);
}

void Controller::paused() {
  measured_from_ = frames_ + 1;
}

void Controller::gpu_lost() {
  std::visit([](auto& policy) { policy.set_gpu(false); }, policy_);
}

void Controller::gpu_ready() {
  std::visit([](auto& policy) { policy.set_gpu(true); }, policy_);
}

std::uint64_t Controller::switches() const {
  return std::visit([](const auto& policy) { return policy.switches(); }, policy_);
}

std::uint64_t Controller::probes() const {
  return std::visit([](const auto& policy) { return policy.probes(); }, policy_);
}

ControllerState Controller::state() const {
  return std::visit([](const auto& policy) { return policy.state(); }, policy_);
}

}  // namespace sightline::culling
