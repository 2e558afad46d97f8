// Error against run time of the forms of a primitive: triangles with a number of segments, the engine's ray-cast GLSL,
// and the C++ intersections in double. Measures one kind at a time (measure_kind), and whole models (measure_model).
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/bench/error_time/samples.h"
#include "sightline/apps/common/drawn_variant.h"
#include "sightline/core/scene.h"
#include "sightline/core/view.h"
#include "sightline/gl/context.h"

namespace sightline::bench {

struct Form {
  enum class Method { kTriangles, kGlsl, kDouble };
  Method method = Method::kTriangles;
  int segments = 0;  ///< of triangles, per full circle; 0 where the number does not matter

  bool on_cpu() const { return method == Method::kDouble; }
};

/// "24 segments", "triangles", "GLSL", "C++ double".
std::string name_of(const Form& form);

/// Called with the share of the work done, 0 … 1.
using Report = std::function<void(double)>;

// --- one kind --------------------------------------------------------------------------------------------------------

struct KindConfig {
  int width = 640, height = 480;  ///< of the timed frames, pixels
  int samples = 3;                ///< samples per pixel and axis for errors
  int passes = 7;                 ///< number of timed passes; their median counts
  std::uint32_t seed = 1;
  std::vector<int> segments;
};

/// Items of one size: `columns` x `rows` of them in each of `images` images, none in front of another.
struct FieldSize {
  double pixels;  ///< diameter of an item's bounding ball
  int columns, rows, images;
};

struct KindFigures {
  Form form;
  SampleErrors errors;          ///< against C++ double, over all images
  double ms = 0.0;              ///< per frame; on the CPU, time of its rays on one thread
  double ns_per_ray = 0.0;      ///< on the CPU only
  double bytes_per_item = 0.0;  ///< on the GPU: records, or records and triangles; 0 on the CPU
};

struct KindResult {
  core::Kind kind;
  FieldSize size;
  double rays = 0.0;            ///< per frame, within the items' bounding balls
  double empty_frame_ms = 0.0;  ///< of a frame without items
  std::vector<KindFigures> forms;
};

/// Nine kinds: all but lines, facet groups and meshes.
std::span<const core::Kind> measured_kinds();

/// Measures random items of a kind (the seed gives shape and orientation) in perspective. The context must be current.
core::Expected<KindResult> measure_kind(const gl::Context& context, core::Kind kind, const FieldSize& size,
                                        const KindConfig& config, const Report& report = {});

// --- whole models ----------------------------------------------------------------------------------------------------

struct NamedView {
  std::string name;
  core::View view;
};

struct ModelConfig {
  int width = 1280, height = 720;
  int passes = 5;
  int reference_segments = 512;
  std::vector<int> segments;
};

struct ModelFigures {
  Form form;
  double ms = 0.0;            ///< per frame, culling included
  std::size_t gpu_bytes = 0;  ///< without the image
  /// Against the triangles of the reference, and against the ray-cast image.
  apps::ImageErrors to_triangles, to_ray_cast;
};

struct ModelResult {
  std::string view;
  std::vector<ModelFigures> forms;  ///< the last is the reference itself, timed once
};

/// Draws the scene in every form from every view. The scene must be committed.
core::Expected<std::vector<ModelResult>> measure_model(gl::Context& context, const core::Scene& scene,
                                                       std::span<const NamedView> views, const ModelConfig& config,
                                                       const Report& report = {});

}  // namespace sightline::bench
