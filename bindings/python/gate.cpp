#include "sightline/bindings/python/gate.h"

#include <algorithm>
#include <optional>

#include "sightline/bindings/python/convert.h"

namespace sightline::python {
namespace {

thread_local int long_calls = 0;  // of this thread; above 0 within callbacks

}  // namespace

bool Gate::mine() const {
  return std::find(users_.begin(), users_.end(), std::this_thread::get_id()) != users_.end();
}

void Gate::pass(Use use) {
  if (queue_.empty() && !written_ && (use == Use::kRead || users_.empty())) return;
  GateTurn(*this, use).wait();
}

void Gate::enter(Use use) {
  const std::lock_guard lock(mutex_);
  users_.push_back(std::this_thread::get_id());
  written_ = use == Use::kWrite;
}

void Gate::leave() {
  {
    const std::lock_guard lock(mutex_);
    users_.erase(std::find(users_.begin(), users_.end(), std::this_thread::get_id()));
    written_ = false;
  }
  changed_.notify_all();
}

GateTurn::GateTurn(Gate& gate, Use use) : gate_(gate), use_(use), nested_(long_calls > 0) {
  if (gate.mine() && (gate.written_ || use == Use::kWrite))
    fail("the scene is in use by the call that called back: it may be used again after that call");
  const std::lock_guard lock(gate.mutex_);
  place_ = gate.queue_.insert(gate.queue_.end(), use);
}

GateTurn::~GateTurn() {
  {
    const std::lock_guard lock(gate_.mutex_);
    gate_.queue_.erase(place_);
  }
  gate_.changed_.notify_all();
}

bool GateTurn::open() const {
  if (gate_.written_ || (use_ == Use::kWrite && !gate_.users_.empty())) return false;
  if (nested_) return true;
  return std::none_of(gate_.queue_.cbegin(), std::list<Use>::const_iterator(place_),
                      [&](Use earlier) { return use_ == Use::kWrite || earlier == Use::kWrite; });
}

void GateTurn::wait() {
  while (!open()) {
    const pybind11::gil_scoped_release released;
    std::unique_lock lock(gate_.mutex_);
    gate_.changed_.wait(lock, [&] { return open(); });
  }
}

/// Both places are taken before either is waited for: in all gates the same call comes first.
LongCall::LongCall(GateUse first, GateUse second) : first_(first), second_(second) {
  enter();
  ++long_calls;
  state_ = PyEval_SaveThread();
}

void LongCall::enter() {
  GateTurn turn(first_.gate, first_.use);
  std::optional<GateTurn> other;
  if (&second_.gate != &first_.gate) other.emplace(second_.gate, second_.use);
  do {
    turn.wait();
    if (other) other->wait();
  } while (!turn.open());  // a callback's call may have come between
  first_.gate.enter(first_.use);
  if (other) second_.gate.enter(second_.use);
}

LongCall::~LongCall() {
  PyEval_RestoreThread(state_);
  --long_calls;
  if (&second_.gate != &first_.gate) second_.gate.leave();
  first_.gate.leave();
}

}  // namespace sightline::python
