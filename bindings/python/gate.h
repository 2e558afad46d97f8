// Who may use a C++ object while calls run without Python's lock (the GIL).
//
// Short calls hold the GIL from begin to end and need nothing else: pass() alone. Long calls release it. While one
// runs, the objects that it uses are entered, and all other calls on them wait.
#pragma once

#include <condition_variable>
#include <initializer_list>
#include <mutex>
#include <thread>

#include <pybind11/pybind11.h>

namespace sightline::python {

enum class Use { kRead, kWrite };

/// All functions need the GIL.
class Gate {
 public:
  /// Waits, without the GIL, until no long call is in the way. Throws Failure when that call waits for this very
  /// thread: in a callback.
  void pass(Use use);

 private:
  friend class LongCall;
  bool open(Use use) const { return use == Use::kRead ? users_ >= 0 : users_ == 0; }
  void enter(Use use);
  void leave();

  std::mutex mutex_;  // writers of users_ hold it beside the GIL, so that waiting needs it alone
  std::condition_variable freed_;
  int users_ = 0;  // long calls that read; -1: one that writes
  std::thread::id writer_;
};

struct GateUse {
  Gate& gate;
  Use use;
};

/// Enters all gates at once and releases the GIL; the end takes it back and leaves them.
class LongCall {
 public:
  explicit LongCall(GateUse first) : LongCall(first, first) {}
  LongCall(GateUse first, GateUse second);
  LongCall(const LongCall&) = delete;
  LongCall& operator=(const LongCall&) = delete;
  ~LongCall();

 private:
  GateUse first_, second_;
  PyThreadState* state_;
};

}  // namespace sightline::python
