// A graphics card that does not exist: stands between a context's function table and a software rasteriser, which draws
// the images, and answers fences, queries and the clock by a model of a card.
#pragma once

#include <string>

#include "sightline/gl/context.h"
#include "sightline/gl/functions.h"

namespace sightline::tests {

/// What a card takes, in seconds. The GPU works in order, beside the CPU.
struct CardModel {
  std::string name;
  double draw = 1e-6;          ///< each command of a draw, and each dispatch
  double triangle = 0.5e-9;    ///< 2 G triangles a second
  double point = 3e-9;         ///< that a geometry shader writes to a buffer
  double work_group = 0.3e-6;  ///< of the compute culler: some 2,000 items
  double readback = 5e-3;      ///< from the end of the work until the CPU has what it reads
  double byte = 0.1e-9;        ///< read back
  double notice = 20e-6;       ///< from the end of the work until a fence or a query tells the CPU
  double call = 0.1e-6;        ///< of the CPU, for a call of GL
  bool timers = true;          ///< whether timestamps count
  bool shows = true;           ///< false: draws by indirect commands take their time and leave no image
};

/// While it lives, the context says that it is hardware, and all times of the library are those of a virtual clock,
/// which calls of GL, waits and cpu_works() advance: the same calls take the same time on any machine, however busy.
/// The work of a draw follows from its indirect commands, which are read back from the rasteriser. One at a time; no
/// thread but the context's may tell the time.
class SimulatedGpu {
 public:
  SimulatedGpu(const gl::Context& context, CardModel model);
  SimulatedGpu(const SimulatedGpu&) = delete;
  SimulatedGpu& operator=(const SimulatedGpu&) = delete;
  ~SimulatedGpu();

  /// Seconds on the virtual clock.
  static double now();
  /// The CPU does something that takes so long.
  static void cpu_works(double seconds);
  /// How long the CPU takes between two looks at the clock, at least.
  static void set_clock_step(double seconds);

  /// Time that the CPU has spent waiting, in seconds, and what the GPU has worked.
  struct Account {
    double fences = 0.0;     ///< for fences
    double finishes = 0.0;   ///< for all work to end
    double readbacks = 0.0;  ///< for images, buffers and results of queries
    double busy = 0.0;       ///< of the GPU
    double triangles = 0.0;  ///< drawn
    double draws = 0.0;      ///< commands of draws

    Account operator-(const Account& o) const {
      return {fences - o.fences, finishes - o.finishes,   readbacks - o.readbacks,
              busy - o.busy,     triangles - o.triangles, draws - o.draws};
    }
  };
  static const Account& account();

 private:
  gl::Functions& table_;
  gl::Capabilities& capabilities_;
  bool software_, pinned_memory_;
};

}  // namespace sightline::tests
