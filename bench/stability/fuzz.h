// Random parameters, sane and insane, through the shaders: nothing that is no number may leave them, bounds must
// contain what is hit, and who hits must be who hits in double.
#pragma once

#include "sightline/bench/stability/glsl_rays.h"

namespace sightline::bench {

struct FuzzFigures {
  core::Kind kind = core::Kind::kCylinder;
  std::int64_t sets = 0;              ///< of parameters, one ray each
  std::int64_t finite = 0;            ///< sets whose parameters are all finite
  std::int64_t hits = 0;              ///< of the shader
  std::int64_t not_finite = 0;        ///< crossings by the shader or in double whose t or normal is no number
  std::int64_t outside = 0;           ///< sets with crossings outside core::bounds
  std::int64_t disagree = 0;          ///< sane sets where the shader hits and the reference does not, or the reverse
  std::int64_t in_band = 0;           ///< the same within the band
  std::int64_t thin = 0;              ///< the same of solids that are too thin, or flat
  std::vector<std::string> examples;  ///< of what is wrong: parameters and ray, at most ten

  bool ok() const { return not_finite + outside + disagree == 0; }
};

/// Disagreement counts where no ray parallel to it within this band, in sizes of the solid, answers otherwise; and
/// where none of the solid's lengths is less than kFuzzThin of the largest: thinner ones have few digits of a float
/// left, and none below a tenth of that.
inline constexpr double kFuzzBand = 2e-6, kFuzzThin = 1e-6;

/// `sets` random sets of one kind: most with lengths from 1e-6 to 1e6 within a few decades of each other, others
/// anywhere in that range, a fifth with zeros, negatives, denormals, huge ones, infinities and NaN among them.
/// Agreement is asked of sets whose parameters are all 0 or within 1e-6 ... 1e6; first of gpuprims::intersect<double>,
/// and where that differs, of the reference in 113 bits.
core::Expected<FuzzFigures> fuzz(GlslRays& shaders, core::Kind kind, std::int64_t sets, std::uint64_t seed);

}  // namespace sightline::bench
