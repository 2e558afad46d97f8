#include "sightline/bindings/python/gate.h"

#include "sightline/bindings/python/convert.h"

namespace sightline::python {

void Gate::pass(Use use) {
  while (!open(use)) {
    if (users_ < 0 && writer_ == std::this_thread::get_id())
      fail("the scene is in use by the call that called back: it may be used again after that call");
    const pybind11::gil_scoped_release released;
    std::unique_lock lock(mutex_);
    freed_.wait(lock, [&] { return open(use); });
  }
}

void Gate::enter(Use use) {
  const std::lock_guard lock(mutex_);
  if (use == Use::kRead) {
    ++users_;
  } else {
    users_ = -1;
    writer_ = std::this_thread::get_id();
  }
}

void Gate::leave() {
  {
    const std::lock_guard lock(mutex_);
    users_ = users_ < 0 ? 0 : users_ - 1;
  }
  freed_.notify_all();
}

LongCall::LongCall(GateUse first, GateUse second) : first_(first), second_(second) {
  do {
    first_.gate.pass(first_.use);
    second_.gate.pass(second_.use);
  } while (!first_.gate.open(first_.use));  // pass() may have waited for the second meanwhile
  first_.gate.enter(first_.use);
  if (&second_.gate != &first_.gate) second_.gate.enter(second_.use);
  state_ = PyEval_SaveThread();
}

LongCall::~LongCall() {
  PyEval_RestoreThread(state_);
  if (&second_.gate != &first_.gate) second_.gate.leave();
  first_.gate.leave();
}

}  // namespace sightline::python
