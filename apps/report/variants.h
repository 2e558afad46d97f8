// Ways to draw the model, timed in turns from the report's views, and compared with images by rays in double precision.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sightline/apps/report/report.h"
#include "sightline/core/scene.h"

namespace sightline::apps {

/// The kind of a way to draw the model.
struct VariantKind {
  enum class Group { kExact, kTriangles, kSamples, kContribution, kLevels };
  Group group = Group::kExact;
  std::string label;
  double tolerance = 0.0;       ///< metres, of triangles in place of primitives
  std::uint64_t triangles = 0;  ///< of all items
};

struct Variant : VariantKind {
  std::shared_ptr<core::Scene> scene;
  engine::EngineConfig config;
  int reduced = 1;  ///< drawn that many times smaller, and enlarged
};

/// What rays in double precision see from a view.
struct Reference {
  /// What the ray through a pixel's centre hits first.
  struct Point {
    std::uint32_t id = 0;  ///< item + 1; 0: nothing
    double depth = 0.0;    ///< metres along the view axis
    double slope = 0.0;    ///< distance from the surface's tangent plane, over a small difference of depth
  };
  image::Image colour;              ///< one ray a pixel, through its centre
  std::vector<Point> points;        ///< by pixel
  image::Image smooth;              ///< 16 rays a pixel
  std::vector<std::uint64_t> seen;  ///< pixel << 32 | id of what these hit, and the centre's, sorted

  bool shows(std::size_t pixel, std::uint32_t id) const;
};

/// Results of all views together.
struct VariantResults : VariantKind {
  std::size_t gpu_bytes = 0;
  double ms = 0.0;  ///< a frame, mean of the views
  // Against one ray through each pixel's centre:
  double error_median = 0.0, error_p99 = 0.0;  ///< metres from the true surface, over pixels that show the same item
  double wrong_pixels = 0.0;                   ///< share of all pixels that show another item
  // Against 16 rays a pixel; not of triangles in place of primitives:
  double flip_mean = 0.0, flip_p99 = 0.0;
  double wrong_ids = 0.0;            ///< share of all pixels, whose item none of the rays hits
  std::vector<image::Image> images;  ///< by view
  std::vector<double> differences;   ///< by view: share of wrong pixels, or of triangles the mean error
};

/// One for each of the report's views. The report must have a tracer.
std::vector<Reference> trace_references(const Report& report, const SectionProgress& progress);

/// Draws all variants in turns, so that other load of the machine affects all equally, and compares them.
std::vector<VariantResults> measure_variants(const Report& report, const std::vector<Variant>& variants,
                                             const std::vector<Reference>& references, const SectionProgress& progress);

}  // namespace sightline::apps
