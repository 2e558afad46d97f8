// Progress of long calls, told to a function of Python's.
#pragma once

#include <chrono>
#include <exception>
#include <functional>

#include "sightline/bindings/python/convert.h"

namespace sightline::python {

/// Calls a Python function, or none, with the share that is done. An exception in it, and Ctrl-C, cancel what runs.
class Progress {
 public:
  /// Fails unless it is callable or None.
  explicit Progress(const py::object& callback);

  /// Valid as long as this. To be called without the GIL.
  std::function<bool(double)> function() {
    return [this](double share) { return step(share); };
  }
  /// Throws what has stopped it.
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  bool step(double share);

  py::object callback_;
  std::exception_ptr thrown_;
  std::chrono::steady_clock::time_point looked_ = std::chrono::steady_clock::now();
};

}  // namespace sightline::python
