// Runs random parameters, sane and insane, through the shaders. No result may be NaN or infinite, bounds must contain
// every hit, and the shader must hit exactly where double does.
#pragma once

#include "sightline/apps/bench/stability/glsl_rays.h"

namespace sightline::bench {

struct FuzzCounts {
  core::Kind kind = core::Kind::kCylinder;
  std::int64_t sets = 0;              ///< sets of parameters, one ray each
  std::int64_t finite = 0;            ///< sets whose parameters are all finite
  std::int64_t hits = 0;              ///< hits of the shader
  std::int64_t not_finite = 0;        ///< crossings by the shader or in double with a t or normal that is not finite
  std::int64_t outside = 0;           ///< sets with crossings outside core::bounds
  std::int64_t disagree = 0;          ///< sane sets where the shader hits and the reference does not, or the reverse
  std::int64_t in_band = 0;           ///< the same, but within the band
  std::int64_t thin = 0;              ///< the same, but of solids that are too thin, or flat
  std::vector<std::string> examples;  ///< of wrong results: parameters and ray, at most ten

  bool ok() const { return not_finite + outside + disagree == 0; }
};

/// A disagreement counts if no parallel ray within this band, in sizes of the solid, gives another result, and if no
/// length of the solid is less than kFuzzThin times the largest. Of thinner solids few digits of a float are left, and
/// none below a tenth of that.
inline constexpr double kFuzzBand = 2e-6, kFuzzThin = 1e-6;

/// Tries `sets` random sets of one kind. Most have lengths from 1e-6 to 1e6 within a few decades of each other, others
/// anywhere in that range. A fifth contains zeros, negatives, denormals, huge numbers, infinities and NaN. Agreement is
/// required for sets whose parameters are all 0 or within 1e-6 ... 1e6: first with gpuprims::intersect, and if
/// that differs, with the reference in 113 bits.
core::Expected<FuzzCounts> fuzz(GlslRays& shaders, core::Kind kind, std::int64_t sets, std::uint64_t seed);

}  // namespace sightline::bench
