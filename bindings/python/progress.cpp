#include "sightline/bindings/python/progress.h"

namespace sightline::python {

Progress::Progress(const py::object& callback) : callback_(callback) {
  if (!callback_.is_none() && !PyCallable_Check(callback_.ptr())) fail("progress: expected a function or None");
}

bool Progress::step(double share) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kPause = std::chrono::milliseconds(20);  // between looks for Ctrl-C, which need the GIL
  const auto now = Clock::now();
  if (callback_.is_none() && now - looked_ < kPause) return true;
  looked_ = now;
  const py::gil_scoped_acquire locked;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    return callback_.is_none() || !callback_(share).is(py::bool_(false));
  } catch (...) {
    thrown_ = std::current_exception();
    return false;
  }
}

}  // namespace sightline::python
