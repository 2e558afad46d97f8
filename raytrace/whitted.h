// Reference images by rays (T. Whitted, "An improved illumination model for shaded display", 1980): as the renderer
// shades, exact at every sample, and on request with lights, shadows, mirrors and refraction.
//
//   auto image = raytrace::render_whitted(*tracer, view, 1280, 720, {.samples = 16, .edge_threshold = 0.1});
//   if (image) write(image->rgb);
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// Lights the side of a surface that the viewer sees, if the light is on that side. It does not fade with distance.
struct Light {
  core::dvec3 at{0.0};      ///< in the world; of a sun the direction to it, of any length but 0
  bool sun = false;         ///< infinitely far away
  core::vec3 colour{1.0f};  ///< at least 0; 1 is as bright as the head-light
};
/// The renderer's light of gpuprims::Lighting::kHeadLight: at the eye, or behind it in orthographic views.
SIGHTLINE_API Light head_light(const core::View& view);

/// How surfaces reflect and refract. Their colour and alpha are the material's.
struct Optics {
  /// Share of the light that is mirrored at normal incidence, 0 … 1. Unless 0, it rises to 1 at grazing incidence (C.
  /// Schlick, "An inexpensive BRDF model for physically-based rendering", 1994).
  float reflectivity = 0.0f;
  float refractive_index = 1.0f;  ///< of the inside of transparent solids, above 0
};

struct WhittedImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;   ///< sRGB, 3 bytes per pixel, rows top to bottom; the mean of the pixel's samples
  std::vector<std::uint32_t> ids;  ///< item + 1 that the pixel's first sample shows, 0 for background
  std::vector<float> depths;       ///< of the first sample, metres along the view axis; infinity for background
  std::uint64_t samples = 0;       ///< rays from the eye
};

struct WhittedOptions {
  /// Per pixel, above 0, where sample_positions() has them (exact_visibility.h). So the first of several need not be in
  /// the middle of the pixel.
  int samples = 1;
  /// With it only pixels at edges get `samples`. All others get one, in the middle, which is the first sample of every
  /// pixel. Edges are where the gradient of any channel exceeds this; see mark_edges() (internal/supersampling.h). At
  /// least 0; the gradient is at most 1, so 1 finds no edges.
  std::optional<double> edge_threshold = {};

  std::vector<Light> lights = {};            ///< any number; none: head_light()
  bool studio = false;                       ///< black shows shapes as with gpuprims::Lighting::kStudio
  bool shadows = false;                      ///< transparent items let their share of the light through
  Optics optics = {};                        ///< of all materials
  std::vector<Optics> material_optics = {};  ///< by material index, instead; materials beyond its end have `optics`
  int max_depth = 16;  ///< surfaces that a path of light may meet, above 0; beyond them it shows the background
  core::vec3 background{0.86f, 0.88f, 0.91f};  ///< sRGB, the renderer's

  int threads = 0;  ///< 0: all that OpenMP offers; the image does not depend on them
  /// Called on the calling thread with the share of the work that is done, 0 to 1. False cancels: then rendering fails
  /// with "cancelled" as its message.
  std::function<bool(double)> progress = {};
  /// Called on the calling thread with the image so far, after each sample of all pixels but the last.
  std::function<void(const WhittedImage&)> preview = {};
};

/// Renders the items of the tracer's snapshot as `view` shows them, its layers and section planes included, with filled
/// cuts; lines are not seen. Opaque surfaces look as the renderer draws them. Transparent ones show what is
/// behind them by their alpha, as the renderer's dithering does in the mean. Several threads may render at once. Fails
/// as core::image_ray() does, for options out of range, and when cancelled.
SIGHTLINE_API core::Expected<WhittedImage> render_whitted(const Tracer& tracer, const core::View& view, int width,
                                                          int height, const WhittedOptions& options = {});

}  // namespace sightline::raytrace
