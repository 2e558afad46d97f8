// Faults of drivers that the library works around, and the self-test that finds them. One table lists all of them;
// nothing else in the library asks who made a driver.
//
// A workaround is on when the self-test's check for it has failed, or when the user says so: by
// ContextOptions::workarounds, or by the environment variable SIGHTLINE_GL_WORKAROUNDS, which counts for every context
// ("plain-depth=on,four-samples=off"). It may cost time, and never changes what an image shows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::gl {

/// What the self-test tries, in its order.
enum class DriverCheck : std::uint8_t {
  kClipControl,        ///< reversed zero-to-one depth arrives as it was computed
  kConservativeDepth,  ///< fragments that write a lesser depth than their triangle's are tested by what they write
  kBaseVertex,         ///< gl_VertexID of an indexed draw counts from its base vertex
  kFeedback,           ///< transform feedback writes a vector and a scalar in turn, and counts a stream it does not write
  kIndirectCount,      ///< a draw count is read from a buffer
  kSamples,            ///< as many samples as the context offers cover half a pixel by half
  kStorageBlocks,      ///< shaders write beyond the 128 MiB that GL 4.5 guarantees, where the context offers more
  kPreciseSums,        ///< the compiler keeps the order of sums that shaders declare `precise`
  kTimer,              ///< the timer counts
  kGeometryStage,      ///< a geometry stage makes proxies of points no slower than vertices alone do, by the timer
};
inline constexpr std::size_t kDriverCheckCount = 10;

enum class CheckResult : std::uint8_t {
  kNotRun,  ///< not yet, or the context does not offer what it is about
  kPassed,
  kFailed,
};

struct DriverTest {
  std::array<CheckResult, kDriverCheckCount> results{};
  double ms = 0.0;          ///< that it took; 0 before it has run
  bool remembered = false;  ///< read from the program cache, where an earlier run with the same driver left it

  CheckResult operator[](DriverCheck check) const { return results[std::size_t(check)]; }
};

/// "clip-control", "conservative-depth", …
SIGHTLINE_API std::string_view name_of(DriverCheck check);

enum class Workaround : std::uint8_t {
  kPlainDepth,
  kAddBaseVertex,
  kNoFeedback,
  kNoIndirectCount,
  kFourSamples,
  kSmallBlocks,
  kNoTimer,
  kNoGeometryStage,
};
inline constexpr std::size_t kWorkaroundCount = 8;

/// A row of the table.
struct WorkaroundFacts {
  Workaround workaround;
  DriverCheck check;        ///< whose failure turns it on
  std::string_view name;    ///< for switches: "plain-depth"
  std::string_view fault;   ///< of drivers
  std::string_view way;     ///< what is done instead
  std::string_view report;  ///< where the fault was described first
};

/// All, in the order of the enumeration.
SIGHTLINE_API std::span<const WorkaroundFacts> workaround_facts();

/// Which are on.
class Workarounds {
 public:
  bool operator[](Workaround which) const { return (bits_ >> unsigned(which) & 1u) != 0; }
  void set(Workaround which, bool on) {
    bits_ = on ? bits_ | 1u << unsigned(which) : bits_ & ~(1u << unsigned(which));
  }

 private:
  std::uint32_t bits_ = 0;
};

/// What a user wants, whatever the self-test says.
struct WorkaroundSwitches {
  Workarounds named, on;  ///< `on` counts where `named`

  /// Reads "NAME=on,NAME=off"; later ones count. Empty: no switch. Fails with the names that there are.
  SIGHTLINE_API static core::Expected<WorkaroundSwitches> parse(std::string_view text);
  /// These, and where `more` names one, that.
  WorkaroundSwitches with(const WorkaroundSwitches& more) const;
};

/// Those whose check has failed, or that are forced on, and that are not forced off. kAddBaseVertex corrects what it
/// finds, so it stays off where its check has passed.
Workarounds choose_workarounds(const DriverTest& test, const WorkaroundSwitches& switches);

}  // namespace sightline::gl
