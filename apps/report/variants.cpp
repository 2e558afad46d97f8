#include "sightline/apps/report/variants.h"

#include <algorithm>
#include <cmath>

#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/core/image_rays.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/raytrace/whitted.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::apps {
namespace {

/// Bilinear between the centres of the small image's pixels.
image::Image enlarged(const image::Image& small, int width, int height) {
  image::Image out{width, height, std::vector<std::uint8_t>(3 * std::size_t(width) * std::size_t(height))};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = std::clamp((x + 0.5) * small.width / width - 0.5, 0.0, small.width - 1.0);
      const double v = std::clamp((y + 0.5) * small.height / height - 0.5, 0.0, small.height - 1.0);
      const int x0 = int(u), y0 = int(v), x1 = std::min(x0 + 1, small.width - 1),
                y1 = std::min(y0 + 1, small.height - 1);
      const auto value = [&](int px, int py, int c) {
        return double(
            small.pixels[3 * (std::size_t(py) * std::size_t(small.width) + std::size_t(px)) + std::size_t(c)]);
      };
      for (int c = 0; c < 3; ++c) {
        const double top = glm::mix(value(x0, y0, c), value(x1, y0, c), u - x0);
        const double bottom = glm::mix(value(x0, y1, c), value(x1, y1, c), u - x0);
        out.pixels[3 * (std::size_t(y) * std::size_t(width) + std::size_t(x)) + std::size_t(c)] =
            std::uint8_t(std::lround(glm::mix(top, bottom, v - y0)));
      }
    }
  return out;
}

/// The nearest pixel's.
image::IdImage enlarged(const image::IdImage& small, int width, int height) {
  image::IdImage out{width, height, {}};
  out.ids.reserve(std::size_t(width) * std::size_t(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      out.ids.push_back(small.ids[std::size_t(y * small.height / height) * std::size_t(small.width) +
                                  std::size_t(x * small.width / width)]);
  return out;
}

/// The view whose pixel centres lie (x, y) pixels off.
core::View shifted(const core::View& view, double x, double y, int width, int height) {
  core::dmat4 clip_from_eye = view.clip_from_eye();
  for (int column = 0; column < 4; ++column) {
    clip_from_eye[column][0] += 2.0 * x / width * clip_from_eye[column][3];
    clip_from_eye[column][1] += 2.0 * y / height * clip_from_eye[column][3];
  }
  return need(core::View::from_matrices(view.eye_from_world(), clip_from_eye, view.clip_depth()));
}

// --- references ------------------------------------------------------------------------------------------------------

constexpr int kGrid = 4;  // rays per pixel and axis

raytrace::WhittedImage traced(const Report& report, const core::View& view) {
  return need(raytrace::render_whitted(*report.tracer(), view, report.width(), report.height()));
}

/// What the rays through the pixels' centres hit.
std::vector<Reference::Point> trace_points(const Report& report, const core::View& view) {
  const auto rays = need(core::ImageRays::create(view, report.width(), report.height()));
  std::vector<core::Ray> all;
  for (int y = 0; y < report.height(); ++y)
    for (int x = 0; x < report.width(); ++x) all.push_back(rays.through(x + 0.5, y + 0.5));
  std::vector<raytrace::Hit> hits(all.size());
  need(report.tracer()->nearest(all, hits, raytrace::filter_of(view)));
  const core::dvec3 forward = -glm::transpose(core::dmat3(view.eye_from_world()))[2];
  std::vector<Reference::Point> points(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (hits[i].slot == core::kNone) continue;
    const double per_depth = 1.0 / glm::dot(all[i].direction, forward);  // of the way along the ray
    points[i] = {to_index(hits[i].item) + 1, glm::dot(hits[i].point - view.eye(), forward),
                 per_depth * std::abs(glm::dot(all[i].direction, hits[i].normal))};
  }
  return points;
}

/// Means of the stored colours of 4 x 4 images whose rays lie on a regular grid in each pixel, as an engine's own
/// samples are averaged; and all items that they show.
void trace_smooth(const Report& report, const core::View& view, Reference& reference) {
  const std::size_t pixels = reference.points.size();
  std::vector<std::uint32_t> sums(3 * pixels), last(pixels, ~0u);
  const auto see = [&](std::size_t pixel, std::uint32_t id) {
    if (id != std::exchange(last[pixel], id)) reference.seen.push_back(std::uint64_t(pixel) << 32 | id);
  };
  for (std::size_t i = 0; i < pixels; ++i) see(i, reference.points[i].id);
  for (int sample = 0; sample < kGrid * kGrid; ++sample) {
    const auto offset = [](int i) { return (i + 0.5) / kGrid - 0.5; };
    const auto moved = shifted(view, offset(sample % kGrid), offset(sample / kGrid), report.width(), report.height());
    const auto image = traced(report, moved);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += image.rgb[i];
    for (std::size_t i = 0; i < pixels; ++i) see(i, image.ids[i]);
  }
  constexpr std::uint32_t kSamples = kGrid * kGrid;
  reference.smooth = {report.width(), report.height(), std::vector<std::uint8_t>(sums.size())};
  for (std::size_t i = 0; i < sums.size(); ++i)
    reference.smooth.pixels[i] = std::uint8_t((sums[i] + kSamples / 2) / kSamples);
  core::sort_unique(reference.seen);
}

// --- errors ----------------------------------------------------------------------------------------------------------

bool is_surface_variant(Variant::Group group) {
  return group == Variant::Group::kExact || group == Variant::Group::kTriangles || group == Variant::Group::kLevels;
}

/// Compares pixel by pixel with what rays hit. Rays do not see lines: pixels that show one are left out.
class PixelErrors {
 public:
  PixelErrors(const core::Scene& scene, const Reference& reference, const DrawnImage& image)
      : scene_(scene), reference_(reference), image_(image) {}

  std::size_t pixels() const { return reference_.points.size(); }

  /// Appends the distances of the drawn points from the true surfaces; returns the number of pixels that show another
  /// item.
  std::uint64_t measure_surfaces(std::vector<double>& distances) const {
    std::uint64_t wrong = 0;
    for (std::size_t i = 0; i < pixels(); ++i) {
      const Reference::Point& point = reference_.points[i];
      if (is_line(i)) continue;
      if (image_.ids.ids[i] != point.id && !is_tie(i))
        ++wrong;
      else if (point.id != 0)
        distances.push_back(point.slope * std::abs(double(image_.depth.metres[i]) - point.depth));
    }
    return wrong;
  }

  /// The number of pixels that show an item which none of the 16 rays hits.
  std::uint64_t count_wrong() const {
    std::uint64_t wrong = 0;
    for (std::size_t i = 0; i < pixels(); ++i)
      wrong += !is_line(i) && !reference_.shows(i, image_.ids.ids[i]) && !is_tie(i);
    return wrong;
  }

 private:
  bool is_line(std::size_t i) const {
    const std::uint32_t id = image_.ids.ids[i];
    return id != 0 && scene_.kind(core::ItemId{id - 1}) == core::Kind::kLine;
  }
  /// Faces of several items lie in one plane there, and any of them may be drawn.
  bool is_tie(std::size_t i) const {
    constexpr double kSameDepth = 1e-5;  // relative; float depths of touching faces differ by some 1e-7
    if (image_.depth.metres.empty() || image_.ids.ids[i] == 0 || reference_.points[i].id == 0) return false;
    const double depth = reference_.points[i].depth;
    return std::abs(double(image_.depth.metres[i]) - depth) <= kSameDepth * depth;
  }

  const core::Scene& scene_;
  const Reference& reference_;
  const DrawnImage& image_;
};

/// Adds one view's errors. `share`: of the view, in means.
void add_errors(const Variant& variant, const Reference& reference, DrawnImage image, double share,
                std::vector<double>& distances, VariantResults& results) {
  if (variant.reduced > 1) {
    image.colour = enlarged(image.colour, reference.colour.width, reference.colour.height);
    image.ids = enlarged(image.ids, reference.colour.width, reference.colour.height);
    image.depth.metres.clear();
  }
  const PixelErrors errors(*variant.scene, reference, image);
  const double pixels = double(errors.pixels());
  if (is_surface_variant(variant.group)) {
    const double wrong = double(errors.measure_surfaces(distances)) / pixels;
    results.wrong_pixels += share * wrong;
    results.differences.push_back(wrong);
  }
  if (variant.group != Variant::Group::kTriangles) {
    const auto metrics = need(image::image_metrics(reference.smooth, image.colour));
    results.flip_mean += share * metrics.flip_mean;
    results.flip_p99 += share * metrics.flip_p99;
    results.wrong_ids += share * double(errors.count_wrong()) / pixels;
    if (!is_surface_variant(variant.group)) results.differences.push_back(metrics.flip_mean);
  }
  results.images.push_back(std::move(image.colour));
}

/// Milliseconds of each: the median of three, or where all together take more than half a second one.
std::vector<double> times_of(std::vector<DrawnVariant>& drawn, const core::View& view) {
  constexpr double kLong = 500.0;
  auto times = need(time_in_turns(drawn, view, 1));
  double all = 0.0;
  for (const double ms : times) all += ms;
  return all > kLong ? times : need(time_in_turns(drawn, view, 3));
}

}  // namespace

bool Reference::shows(std::size_t pixel, std::uint32_t id) const {
  return std::binary_search(seen.begin(), seen.end(), std::uint64_t(pixel) << 32 | id);
}

std::vector<Reference> trace_references(const Report& report, const SectionProgress& progress) {
  std::vector<Reference> references;
  for (const ReportView& place : report.views()) {
    Reference reference;
    auto points = trace_points(report, place.view);
    reference.points = std::move(points);
    auto image = traced(report, place.view);
    reference.colour = {image.width, image.height, std::move(image.rgb)};
    trace_smooth(report, place.view, reference);
    references.push_back(std::move(reference));
    progress(double(references.size()) / double(report.views().size()));
  }
  return references;
}

std::vector<VariantResults> measure_variants(const Report& report, const std::vector<Variant>& variants,
                                             const std::vector<Reference>& references,
                                             const SectionProgress& progress) {
  std::vector<VariantResults> results;
  std::vector<DrawnVariant> drawn;
  for (const Variant& variant : variants) {
    engine::EngineConfig config = variant.config;
    config.width /= variant.reduced;
    config.height /= variant.reduced;
    drawn.push_back(need(DrawnVariant::create(variant.scene, config)));
    static_cast<VariantKind&>(results.emplace_back()) = variant;
    progress(0.5 * double(drawn.size()) / double(variants.size()));
  }
  const double share = 1.0 / double(references.size());
  std::vector<std::vector<double>> distances(variants.size());
  for (std::size_t v = 0; v < references.size(); ++v) {
    const core::View& view = report.views()[v].view;
    const auto times = times_of(drawn, view);
    for (std::size_t i = 0; i < variants.size(); ++i) {
      results[i].ms += share * times[i];
      // The image is that of the last pass.
      add_errors(variants[i], references[v], need(drawn[i].image(view)), share, distances[i], results[i]);
    }
    progress(0.5 + 0.5 * double(v + 1) * share);
  }
  for (std::size_t i = 0; i < variants.size(); ++i) {
    results[i].error_median = median(distances[i]);
    results[i].error_p99 = percentile(std::move(distances[i]), 0.99);
    results[i].gpu_bytes = drawn[i].gpu_bytes();
  }
  return results;
}

}  // namespace sightline::apps
