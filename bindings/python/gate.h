// Who may use a C++ object while calls run without Python's lock (the GIL).
//
// Short calls hold the GIL from begin to end and need nothing else: pass() alone. Long calls release it. While one
// runs, the objects that it uses are entered, and all other calls on them wait. Whoever has to wait queues, and whoever
// comes later queues behind: a thread that calls without a pause lets each waiting call of others in between.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

#include <pybind11/pybind11.h>

namespace sightline::python {

enum class Use { kRead, kWrite };

/// All functions need the GIL.
class Gate {
 public:
  /// Waits, without the GIL, until no long call is in the way, and no call that came earlier. Throws Failure when that
  /// long call waits for this very thread: in a callback.
  void pass(Use use);

 private:
  friend class GateTurn;
  friend class LongCall;

  bool mine() const;  ///< whether a long call of this thread runs
  void enter(Use use);
  void leave();

  std::mutex mutex_;  // writers of what follows hold it beside the GIL, so that waiting needs it alone
  std::condition_variable changed_;
  std::vector<std::thread::id> users_;  // of long calls
  bool written_ = false;                // their only one writes
  std::list<Use> queue_;                // calls that wait, in the order in which they came
};

/// A call's place in the queue of a gate. It is taken at once and given up at the end.
class GateTurn {
 public:
  GateTurn(Gate& gate, Use use);
  ~GateTurn();
  GateTurn(const GateTurn&) = delete;
  GateTurn& operator=(const GateTurn&) = delete;

  void wait();
  bool open() const;

 private:
  Gate& gate_;
  const Use use_;
  // In a callback of a long call, for whose end those in the queue may wait: such a call does not wait for them.
  const bool nested_;
  std::list<Use>::iterator place_;
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
  void enter();

  GateUse first_, second_;
  PyThreadState* state_;
};

}  // namespace sightline::python
