// The sentence that a report begins with: what exact surfaces cost and are worth beside triangles.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sightline::apps {

/// A way to draw the model's surfaces, as measured.
struct SurfaceCost {
  double tolerance = 0.0;  ///< metres, of triangles
  double ms = 0.0;         ///< a frame
  double error = 0.0;      ///< metres from the true surface
};

struct AnswerResults {
  std::uint64_t solids = 1, meshes = 0;  ///< items that are drawn as exact surfaces, and as the triangles that they are
  /// Metres between surfaces that files state (STEP, IGES, BREP) and what stands for them: triangles, and primitives.
  double mesh_deviation = 0.0, solid_deviation = 0.0;
  SurfaceCost exact;                   ///< as drawn by default
  std::vector<SurfaceCost> triangles;  ///< coarsest first; may be empty
};

/// One sentence, for whatever came out.
std::string answer_sentence(const AnswerResults& results);

/// "30 mm", "1.2 m", "under 0.001 mm".
std::string length_words(double metres);

}  // namespace sightline::apps
