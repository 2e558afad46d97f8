#include "sightline/raytrace/whitted.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "sightline/core/image_rays.h"
#include "sightline/core/internal/openmp.h"
#include "sightline/gpuprims/internal/studio_black.h"
#include "sightline/raytrace/exact_visibility.h"
#include "sightline/raytrace/internal/supersampling.h"
#include "sightline/raytrace/internal/surface.h"

namespace sightline::raytrace {
namespace {

using core::dvec3;
using core::Ray;

constexpr int kTilePixels = 16;              // pixels
constexpr double kLeastShare = 1.0 / 512.0;  // of a pixel's light; less is not followed

core::Expected<void> check(const WhittedOptions& options) {
  if (options.samples <= 0 || options.max_depth <= 0)
    return core::fail("whitted: samples and max_depth must be above 0");
  if (options.edge_threshold && !(*options.edge_threshold >= 0.0))
    return core::fail("whitted: edge_threshold must be at least 0");
  const auto bad_optics = [](const Optics& o) {
    return !(o.reflectivity >= 0.0f && o.reflectivity <= 1.0f && o.refractive_index > 0.0f &&
             std::isfinite(o.refractive_index));
  };
  if (bad_optics(options.optics) ||
      std::any_of(options.material_optics.begin(), options.material_optics.end(), bad_optics))
    return core::fail("whitted: reflectivity must be 0 to 1, refractive_index above 0");
  for (const Light& light : options.lights)
    if (!core::is_finite(light.at) || (light.sun && light.at == dvec3(0.0)) || !core::is_finite(dvec3(light.colour)) ||
        std::min({light.colour.x, light.colour.y, light.colour.z}) < 0.0f)
      return core::fail("whitted: lights must be finite, directions not 0, and colours at least 0");
  return {};
}

/// What a ray sees. Colours are sRGB, as the renderer's shaders reckon (render/shaders/shading.glsl).
class Shader {
 public:
  Shader(const Tracer& tracer, const core::View& view, const WhittedOptions& options)
      : tracer_(tracer), options_(options), filter_(filter_of(view)), lights_(options.lights) {
    if (lights_.empty()) lights_.push_back(head_light(view));
    all_opaque_ = all_opaque(tracer.snapshot().materials());
  }

  core::Expected<void> nearest(std::span<const Ray> rays, std::span<Hit> hits) const {
    return tracer_.nearest(rays, hits, filter_);
  }
  /// What rays from the eye see whose nearest hits are known.
  void colours(std::span<const Ray> rays, std::span<const Hit> hits, std::span<core::vec3> out) const {
    const auto shadows = options_.shadows && all_opaque_ ? shadows_of(rays, hits) : std::unique_ptr<bool[]>();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Hit* const hit = hits[i].slot != core::kNone ? &hits[i] : nullptr;
      out[i] = core::vec3(colour(rays[i], hit, 1.0, 0, shadows ? &shadows[i * lights_.size()] : nullptr));
    }
  }

 private:
  /// A point of a surface, as seen along a ray.
  struct Surface {
    dvec3 normal;   ///< of the surface, towards the viewer
    dvec3 shading;  ///< the normal that it is lit by, towards the viewer
    bool entered;   ///< seen from outside
    double margin;  ///< the ray may start this far off and be sure to be on either side
    glm::vec4 material{0.0f};
    Optics optics;
  };

  std::optional<Hit> nearest(const Ray& ray) const { return tracer_.nearest(ray, filter_).value_or(std::nullopt); }

  Surface surface_at(const Hit& hit, const dvec3& direction) const {
    const core::Snapshot& snapshot = tracer_.snapshot();
    Surface s;
    s.entered = glm::dot(hit.normal, direction) < 0.0;
    s.normal = s.entered ? hit.normal : -hit.normal;
    s.shading = shading_normal(snapshot, hit, direction);
    s.margin = 100.0 * kSolidError * (glm::length(hit.point) + hit.t);
    if (hit.triangle != core::kNone) {
      const core::Aabb box = snapshot.bounds().box(hit.slot);
      const double size = glm::length(dvec3(box.max) - dvec3(box.min));
      s.margin += 2.0 * kMeshError * (glm::length(hit.point - snapshot.world_from_item(hit.slot).origin) + 2.0 * size);
    }
    const std::uint32_t material = snapshot.material(hit.slot);
    s.material = material_of(snapshot, hit.slot);
    s.optics = material < options_.material_optics.size() ? options_.material_optics[material] : options_.optics;
    return s;
  }

  /// Share of a light that arrives at the ray's origin.
  double arriving(Ray ray) const {
    if (all_opaque_) return tracer_.any(ray, filter_).value_or(false) ? 0.0 : 1.0;
    double share = 1.0;
    for (auto hit = nearest(ray); hit; hit = nearest(ray)) {
      const Surface s = surface_at(*hit, ray.direction);
      share *= 1.0 - std::min(1.0, double(s.material.a));
      if (share < kLeastShare) return 0.0;
      ray.origin = hit->point - s.margin * s.normal;
      ray.t_max -= hit->t;
    }
    return share;
  }

  /// Light that reaches a point of a surface, unless something hides it.
  struct Incident {
    Ray ray;  ///< towards the light
    double cosine;
  };
  /// False: the surface is turned away.
  static bool incident(const Surface& s, const dvec3& point, const Light& light, Incident& out) {
    const dvec3 to = light.sun ? light.at : light.at - point;
    const double length = glm::length(to);
    if (!(length > 0.0)) return false;
    out.ray = {point + s.margin * s.normal, to / length};
    if (!light.sun) out.ray.t_max = length;
    out.cosine = glm::dot(s.shading, out.ray.direction);
    return out.cosine > 0.0;
  }

  /// Whether each light is hidden from each hit. Rays towards one light are traced together.
  std::unique_ptr<bool[]> shadows_of(std::span<const Ray> rays, std::span<const Hit> hits) const {
    const std::size_t lights = lights_.size();
    auto hidden = std::make_unique<bool[]>(rays.size() * lights), hit = std::make_unique<bool[]>(rays.size());
    std::vector<Ray> towards;
    std::vector<std::size_t> places;
    for (std::size_t light = 0; light < lights; ++light) {
      towards.clear(), places.clear();
      for (std::size_t i = 0; i < rays.size(); ++i) {
        Incident in;
        if (hits[i].slot == core::kNone ||
            !incident(surface_at(hits[i], rays[i].direction), hits[i].point, lights_[light], in))
          continue;
        towards.push_back(in.ray);
        places.push_back(i * lights + light);
      }
      if (!tracer_.any(towards, {hit.get(), towards.size()}, filter_))  // one of them is no ray
        for (std::size_t i = 0; i < towards.size(); ++i) hit[i] = tracer_.any(towards[i], filter_).value_or(false);
      for (std::size_t i = 0; i < places.size(); ++i) hidden[places[i]] = hit[i];
    }
    return hidden;
  }

  /// `hidden`: whether each light is, where that is known.
  dvec3 lit(const Surface& s, const dvec3& point, const dvec3& to_viewer, const bool* hidden) const {
    const dvec3 colour(gpuprims::lit_colour(core::vec3(s.material), options_.studio ? gpuprims::kStudioBlack : 0.0f));
    dvec3 sum = colour * (0.30 + 0.25 * (0.5 + 0.5 * s.shading.z));
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      const Light& light = lights_[i];
      Incident in;
      if (!incident(s, point, light, in)) continue;
      const dvec3& along = in.ray.direction;
      const double cosine = in.cosine;
      const double share = !options_.shadows ? 1.0 : hidden ? (hidden[i] ? 0.0 : 1.0) : arriving(in.ray);
      if (share == 0.0) continue;
      // With the light at the eye this is the renderer's gloss, a power of the same cosine.
      const double gloss = std::pow(std::max(0.0, glm::dot(s.shading, glm::normalize(along + to_viewer))), 24.0);
      sum += share * dvec3(light.colour) * (0.50 * cosine * colour + 0.12 * gloss);
    }
    return glm::min(sum, dvec3(1.0));
  }

  /// `share`: of the pixel's light.
  dvec3 colour(const Ray& ray, double share, int depth) const {
    if (share < kLeastShare || depth == options_.max_depth) return dvec3(options_.background);
    const auto hit = nearest(ray);
    return colour(ray, hit ? &*hit : nullptr, share, depth, nullptr);
  }

  dvec3 colour(const Ray& ray, const Hit* hit, double share, int depth, const bool* hidden) const {
    if (!hit) return dvec3(options_.background);
    const Surface s = surface_at(*hit, ray.direction);
    const double alpha = std::clamp(double(s.material.a), 0.0, 1.0);
    const double cosine = std::min(1.0, -glm::dot(s.normal, ray.direction));
    double mirrored = s.optics.reflectivity;
    if (mirrored > 0.0) mirrored += (1.0 - mirrored) * std::pow(1.0 - cosine, 5.0);

    const dvec3 reflected = ray.direction + 2.0 * cosine * s.normal;
    dvec3 body = lit(s, hit->point, -ray.direction, hidden);
    if (alpha < 1.0) {
      const double index = s.optics.refractive_index, eta = s.entered ? 1.0 / index : index;
      const dvec3 through =
          index == 1.0 ? ray.direction : glm::refract(ray.direction, s.normal, eta);  // 0: total reflection
      const bool passes = through != dvec3(0.0);
      const Ray on{hit->point + (passes ? -s.margin : s.margin) * s.normal, passes ? through : reflected};
      body = glm::mix(colour(on, share * (1.0 - mirrored) * (1.0 - alpha), depth + 1), body, alpha);
    }
    if (mirrored == 0.0) return body;
    const Ray off{hit->point + s.margin * s.normal, reflected};
    return glm::mix(body, colour(off, share * mirrored, depth + 1), mirrored);
  }

  const Tracer& tracer_;
  const WhittedOptions& options_;
  RayFilter filter_;
  std::vector<Light> lights_;
  bool all_opaque_ = true;
};

/// An image in the making.
class Renderer {
 public:
  Renderer(const Tracer& tracer, const core::View& view, const core::ImageRays& rays, int width, int height,
           const WhittedOptions& options)
      : view_(view), options_(options), shader_(tracer, view, options), rays_(rays) {
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    image_ = {width, height, std::vector<std::uint8_t>(3 * pixels), std::vector<std::uint32_t>(pixels),
              std::vector<float>(pixels, std::numeric_limits<float>::infinity())};
    sums_.resize(pixels);
    counts_.resize(pixels);
  }

  core::Expected<WhittedImage> run() {
    const int samples = options_.samples;
    const std::vector<core::dvec2> places = sample_positions(samples);
    if (!options_.edge_threshold) {
      for (int sample = 0; sample < samples; ++sample)
        if (!pass(places[std::size_t(sample)], {}, sample, samples)) return core::fail("cancelled");
    } else {
      if (!pass(core::dvec2(0.5), {}, 0, samples + 1)) return core::fail("cancelled");
      const auto edges = mark_edges(sums_, image_.width, image_.height, *options_.edge_threshold);
      for (std::size_t i = 0; i < edges.size(); ++i)
        if (edges[i]) counts_[i] = 0;  // the samples of an edge replace the one that found it
      for (int sample = 0; sample < samples; ++sample)
        if (!pass(places[std::size_t(sample)], edges, sample + 1, samples + 1)) return core::fail("cancelled");
    }
    quantise();
    return std::move(image_);
  }

 private:
  /// Adds a sample at that place of the pixels that are marked, or of all without marks. False: cancelled.
  bool pass(const core::dvec2& at, const std::vector<std::uint8_t>& marks, int done, int passes) {
    const int columns = (image_.width + kTilePixels - 1) / kTilePixels,
              rows = (image_.height + kTilePixels - 1) / kTilePixels;
    std::atomic<int> tiles_done = 0;
    std::atomic<bool> cancelled = false;
#pragma omp parallel for schedule(dynamic, 1) num_threads(core::team_of(options_.threads))
    for (int tile = 0; tile < columns * rows; ++tile) {
      if (cancelled) continue;
      trace_tile(tile % columns * kTilePixels, tile / columns * kTilePixels, at, marks);
      const int tiles = ++tiles_done;
      if (!core::leads_team()) continue;
      const double share = (done + double(tiles) / (columns * rows)) / passes;
      if (options_.progress && !options_.progress(share)) cancelled = true;
    }
    if (cancelled) return false;
    if (options_.preview && done + 1 < passes) {
      quantise();
      options_.preview(image_);
    }
    return true;
  }

  void trace_tile(int left, int top, const core::dvec2& at, const std::vector<std::uint8_t>& marks) {
    std::vector<Ray> rays;
    std::vector<std::size_t> pixels;
    // By 4 x 4 pixels, which are traced together.
    for (int i = 0; i < kTilePixels * kTilePixels; ++i) {
      const int block = i / 16, x = left + block % 4 * 4 + i % 4, y = top + block / 4 * 4 + i / 4 % 4;
      if (x >= image_.width || y >= image_.height) continue;
      const std::size_t pixel = std::size_t(y) * std::size_t(image_.width) + std::size_t(x);
      if (!marks.empty() && !marks[pixel]) continue;
      rays.push_back(rays_.through(x + at.x, y + at.y));
      pixels.push_back(pixel);
    }
    std::vector<Hit> hits(rays.size());
    if (!shader_.nearest(rays, hits)) return;  // render_whitted() has tried the view
    std::vector<core::vec3> colours(rays.size());
    shader_.colours(rays, hits, colours);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const std::size_t pixel = pixels[i];
      const Hit* const hit = hits[i].slot != core::kNone ? &hits[i] : nullptr;
      const bool first = marks.empty() && counts_[pixel] == 0;
      sums_[pixel] = counts_[pixel] == 0 ? colours[i] : sums_[pixel] + colours[i];
      ++counts_[pixel];
      if (!hit || !first) continue;
      image_.ids[pixel] = to_index(hit->item) + 1;
      image_.depths[pixel] = float(-(view_.eye_from_world() * core::dvec4(hit->point, 1.0)).z);
    }
    taken_ += pixels.size();
  }

  void quantise() {
    image_.samples = taken_;
    for (std::size_t i = 0; i < sums_.size(); ++i)
      for (int channel = 0; channel < 3; ++channel) {
        const float mean = sums_[i][channel] / float(std::max(counts_[i], 1));
        image_.rgb[3 * i + std::size_t(channel)] = std::uint8_t(std::lround(255.0f * std::clamp(mean, 0.0f, 1.0f)));
      }
  }

  const core::View& view_;
  const WhittedOptions& options_;
  Shader shader_;
  const core::ImageRays& rays_;
  WhittedImage image_;
  std::vector<core::vec3> sums_;
  std::vector<int> counts_;  // samples in a sum
  std::atomic<std::uint64_t> taken_ = 0;
};

}  // namespace

Light head_light(const core::View& view) {
  if (!view.orthographic()) return {view.eye()};
  const core::dmat4 world_from_eye = glm::inverse(view.eye_from_world());
  return {dvec3(world_from_eye[2]), true};
}

core::Expected<WhittedImage> render_whitted(const Tracer& tracer, const core::View& view, int width, int height,
                                            const WhittedOptions& options) {
  if (auto good = check(options); !good) return tl::unexpected(good.error());
  const auto rays = core::ImageRays::create(view, width, height);
  if (!rays) return tl::unexpected(rays.error());
  return Renderer(tracer, view, *rays, width, height, options).run();
}

}  // namespace sightline::raytrace
