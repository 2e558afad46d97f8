#include "sightline/gl/workarounds.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

namespace sightline::gl {
namespace {

constexpr std::array<std::string_view, kDriverCheckCount> kCheckNames = {"clip-control",   "conservative-depth",
                                                                         "base-vertex",    "transform-feedback",
                                                                         "indirect-count", "samples",
                                                                         "storage-blocks", "precise",
                                                                         "timer",          "geometry-stage"};

constexpr std::array<WorkaroundFacts, kWorkaroundCount> kFacts = {{
    {Workaround::kPlainDepth, DriverCheck::kConservativeDepth, "plain-depth",
     "early depth tests reject fragments of ray-cast solids that write a lesser depth",
     "fragments write any depth, and hidden ones are cast, too", "github.com/UniStuttgart-VISUS/megamol/issues/303"},
    {Workaround::kAddBaseVertex, DriverCheck::kBaseVertex, "add-base-vertex",
     "gl_VertexID of indexed draws does not count from the base vertex", "shaders add gl_BaseVertexARB",
     "ANGLE: vertex_ID_does_not_include_base_vertex"},
    {Workaround::kNoFeedback, DriverCheck::kFeedback, "no-feedback",
     "transform feedback misplaces scalars, or counts a stream that is not written wrongly",
     "the GPU culler uses compute shaders only",
     "github.com/Ryujinx/Ryujinx/issues/3832; github.com/GPUOpen-Drivers/llpc/pull/2672"},
    {Workaround::kNoIndirectCount, DriverCheck::kIndirectCount, "no-indirect-count",
     "draw counts are not read from a buffer", "unused draw commands draw nothing", "GL_ARB_indirect_parameters"},
    {Workaround::kFourSamples, DriverCheck::kSamples, "four-samples", "images of more than four samples are wrong",
     "contexts offer at most four", "ANGLE: limit_max_MSAA_samples_to_4"},
    {Workaround::kSmallBlocks, DriverCheck::kStorageBlocks, "small-blocks",
     "shaders cannot write all of the storage that the context offers", "storage blocks have at most 128 MiB",
     "GL_MAX_SHADER_STORAGE_BLOCK_SIZE"},
    {Workaround::kNoTimer, DriverCheck::kTimer, "no-timer", "timer queries have no bits or stand still",
     "GPU work is not timed; the hybrid compares whole frames", "GL_ARB_timer_query: QUERY_COUNTER_BITS may be 0"},
    {Workaround::kNoGeometryStage, DriverCheck::kGeometryStage, "no-geometry-stage",
     "a geometry stage that makes triangles of points is slow",
     "ray-cast solids are drawn as triangles, whose vertices each set up the whole solid",
     "github.com/MRtrix3/mrtrix3/issues/3209"},
}};

std::string all_names() {
  std::string names;
  for (const WorkaroundFacts& facts : kFacts) names += fmt::format("{}{}", names.empty() ? "" : ", ", facts.name);
  return names;
}

}  // namespace

std::string_view name_of(DriverCheck check) {
  return kCheckNames[std::size_t(check)];
}

std::span<const WorkaroundFacts> workaround_facts() {
  return kFacts;
}

core::Expected<WorkaroundSwitches> WorkaroundSwitches::parse(std::string_view text) {
  WorkaroundSwitches switches;
  while (!text.empty()) {
    const std::string_view one = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), one.size() + 1));
    const std::size_t equals = one.find('=');
    const std::string_view name = one.substr(0, equals), value = equals == one.npos ? "" : one.substr(equals + 1);
    const auto found =
        std::find_if(kFacts.begin(), kFacts.end(), [&](const auto& facts) { return facts.name == name; });
    if (found == kFacts.end() || (value != "on" && value != "off"))
      return core::fail(
          fmt::format("GL workarounds: expected NAME=on or NAME=off, NAME one of {}; found \"{}\"", all_names(), one));
    switches.named.set(found->workaround, true);
    switches.on.set(found->workaround, value == "on");
  }
  return switches;
}

WorkaroundSwitches WorkaroundSwitches::with(const WorkaroundSwitches& more) const {
  WorkaroundSwitches both = *this;
  for (const WorkaroundFacts& facts : kFacts)
    if (more.named[facts.workaround]) {
      both.named.set(facts.workaround, true);
      both.on.set(facts.workaround, more.on[facts.workaround]);
    }
  return both;
}

Workarounds choose_workarounds(const DriverTest& test, const WorkaroundSwitches& switches) {
  Workarounds chosen;
  for (const WorkaroundFacts& facts : kFacts)
    chosen.set(facts.workaround, switches.named[facts.workaround] ? switches.on[facts.workaround]
                                                                  : test[facts.check] == CheckResult::kFailed);
  // What adds the base vertex where the driver has added it, too, draws other items.
  if (test[DriverCheck::kBaseVertex] == CheckResult::kPassed) chosen.set(Workaround::kAddBaseVertex, false);
  return chosen;
}

}  // namespace sightline::gl
