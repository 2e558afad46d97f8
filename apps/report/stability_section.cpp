// How the model's numbers lie within the ranges that the primitives are tested in, and how far drawn depths are from
// those in double precision.
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "sightline/apps/common/statistics.h"
#include "sightline/apps/report/report.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::apps {
namespace {

using core::dmat3;
using core::dvec3;
using core::Kind;

// --- ranges ----------------------------------------------------------------------------------------------------------

struct Range {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;

  void add(double value) {
    if (!(value > 0.0) || !std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  bool empty() const { return most == 0.0; }
};

/// Magnitudes that decide how hard an intersection is. Bounds: what sightline-stability tests
/// (docs/reference/accuracy.md).
struct ModelRanges {
  Range coordinate, size, slenderness, ring, slope, sweep, eye_distance;
  std::uint64_t flat = 0, skipped = 0;
};

/// Sides of the primitive's own box, in the world's metres.
dvec3 sides_of(const core::Primitive& primitive, const core::Affine& world_from_item) {
  const core::AabbD box = core::bounds(primitive, core::Affine{});
  const dmat3& m = world_from_item.linear;
  return (box.max - box.min) * dvec3(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
}

void add_shape(const core::Primitive& primitive, ModelRanges& ranges) {
  if (const auto* torus = std::get_if<core::CircularTorus>(&primitive)) {
    ranges.ring.add(std::abs(double(torus->major_radius) / torus->tube_radius));
    ranges.sweep.add(core::sweep_angle(torus->angle));
  } else if (const auto* hoop = std::get_if<core::RectangularTorus>(&primitive)) {
    ranges.sweep.add(core::sweep_angle(hoop->angle));
  } else if (const auto* snout = std::get_if<core::Snout>(&primitive)) {
    ranges.slope.add(std::abs((double(snout->bottom_radius) - snout->top_radius) / snout->height));
  }
}

ModelRanges ranges_of(const Report& report) {
  constexpr double kFlat = 1e-7;  // of the size: drawn that thick
  ModelRanges ranges;
  const core::AabbD bounds = report.scene().bounds(report.scene().root(), ~std::uint32_t{0});
  if (!bounds.empty())
    for (int axis = 0; axis < 3; ++axis)
      ranges.coordinate.add(std::max(std::abs(bounds.min[axis]), std::abs(bounds.max[axis])));
  const core::Snapshot& snapshot = report.snapshot();
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    const Kind kind = snapshot.kind(slot);
    if (snapshot.vacant(slot) || int(kind) >= core::kPrimitiveKindCount || kind == Kind::kLine) continue;
    const core::Primitive primitive = snapshot.primitive(slot);
    const core::Affine world_from_item = snapshot.world_from_item(slot);
    const dvec3 sides = sides_of(primitive, world_from_item);
    const double most = std::max({sides.x, sides.y, sides.z}), least = std::min({sides.x, sides.y, sides.z});
    if (!(most > 0.0) || !std::isfinite(most)) {
      ++ranges.skipped;
      continue;
    }
    ranges.size.add(most);
    ranges.flat += least < kFlat * most;
    if (least > 0.0) ranges.slenderness.add(most / least);
    for (const ReportView& place : report.views())
      ranges.eye_distance.add(glm::length(place.view.eye() - world_from_item.origin) / (0.5 * most));
    add_shape(primitive, ranges);
  }
  return ranges;
}

void add_ranges(const Report& report, Section& section) {
  struct Tested {
    const char *name, *key;
    const Range& range;
    double least, most;
  };
  const ModelRanges ranges = ranges_of(report);
  constexpr double kNone = 0.0;
  const Tested tested[] = {
      {"coordinates, m from the origin", "coordinate", ranges.coordinate, kNone, 1e7},
      {"longest side of an item, m", "size", ranges.size, kNone, 1e18},
      {"longest to shortest side of an item", "slenderness", ranges.slenderness, 1.0, 1e6},
      {"circular torus, radius of ring to tube", "ring", ranges.ring, 0.5, 1e5},
      {"snout, slope of its side (tangent)", "slope", ranges.slope, 1e-6, 1e6},
      {"tori, angle of sweep, radians", "sweep", ranges.sweep, 1e-4, core::kFullTurn},
      {"distance from the eye, in half longest sides", "eye_distance", ranges.eye_distance, kNone, 1e7},
  };
  Rows rows;
  for (const Tested& t : tested) {
    if (t.range.empty()) continue;
    const bool within = t.range.least >= t.least && t.range.most <= t.most;
    rows.push_back({t.name, number(t.range.least), number(t.range.most),
                    (t.least > kNone ? number(t.least) : std::string("0")) + " to " + number(t.most),
                    number(t.range.most / t.most), within ? "yes" : "NO"});
    section.results["ranges"][t.key] = {{"least", t.range.least}, {"most", t.range.most}, {"within", within}};
  }
  section.html.table(
      {"quantity", "least", "greatest", "tested range", "greatest / limit", "within"}, rows,
      {"Numbers of the model's primitives beside the ranges in which their intersections are tested "
       "(docs/reference/accuracy.md); values of 0 left out. " +
           grouped(ranges.flat) +
           " items are thinner than 1e-7 of their longest side: boxes, dishes and pyramids among them are drawn that "
           "thick. " +
           grouped(ranges.skipped) + " have no size.",
       "sightline-stability\n" + report.section_command("stability")});
  section.results["flat"] = ranges.flat;
}

// --- depths ----------------------------------------------------------------------------------------------------------

/// Errors of drawn depths of one kind.
struct DepthErrors {
  std::vector<double> relative;
  double metres = 0.0;       ///< the largest
  std::uint64_t misses = 0;  ///< pixels where the ray in double meets the item nowhere in front of the eye
};

/// The ray through a pixel's centre: the parameter is the distance along the view axis. For perspective views.
core::Ray pixel_ray(const core::View& view, std::size_t x, std::size_t y, int width, int height) {
  const core::dmat4& clip = view.clip_from_eye();
  const double u = 2.0 * (double(x) + 0.5) / width - 1.0, v = 1.0 - 2.0 * (double(y) + 0.5) / height;
  const dvec3 eye((u + clip[2][0]) / clip[0][0], (v + clip[2][1]) / clip[1][1], -1.0);
  return {view.eye(), glm::transpose(dmat3(view.eye_from_world())) * eye};
}

/// The first crossing in front of the eye, in double. Ends that a neighbour covers are open, as in the image.
std::optional<double> reference_depth(const Report& report, core::ItemId item, const core::Ray& ray) {
  const core::Affine world_from_item = report.scene().state(item).world_from_item;
  const dmat3 item_from_world = glm::inverse(world_from_item.linear);
  const core::Ray local{item_from_world * (ray.origin - world_from_item.origin), item_from_world * ray.direction};
  const gpuprims::Ends covered = engine::EngineParts::joints(report.engine()).covered(item);
  const gpuprims::Hits hits =
      gpuprims::intersect(report.scene().primitive(item), local,
                          {(covered & gpuprims::kBottomEnd) == 0, (covered & gpuprims::kTopEnd) == 0});
  for (int i = 0; i < hits.count; ++i)
    if (hits.hit[std::size_t(i)].t > 0.0) return hits.hit[std::size_t(i)].t;
  return std::nullopt;
}

std::map<Kind, DepthErrors> measure_depths(const Report& report, const SectionProgress& progress) {
  constexpr std::size_t kPixelsPerView = 100'000;
  std::map<Kind, DepthErrors> errors;
  double done = 0.0;
  for (const ReportView& place : report.views()) {
    need(report.engine().frame(place.view));
    const auto ids = need(report.engine().read_ids());
    const auto depth = need(report.engine().read_depth(place.view));
    // A step without a common factor with the width, so that pixels of all columns are taken.
    std::size_t step = std::max<std::size_t>(1, ids.ids.size() / kPixelsPerView);
    while (std::gcd(step, std::size_t(report.width())) != 1) ++step;
    for (std::size_t i = 0; i < ids.ids.size(); i += step) {
      if (ids.ids[i] == 0) continue;
      const core::ItemId item{ids.ids[i] - 1};
      const Kind kind = report.scene().kind(item);
      if (int(kind) >= core::kPrimitiveKindCount || kind == Kind::kLine) continue;
      const std::size_t width = std::size_t(report.width());
      const auto t =
          reference_depth(report, item, pixel_ray(place.view, i % width, i / width, report.width(), report.height()));
      DepthErrors& of_kind = errors[kind];
      if (!t) {
        ++of_kind.misses;
        continue;
      }
      const double error = std::abs(double(depth.metres[i]) - *t);
      of_kind.relative.push_back(error / *t);
      of_kind.metres = std::max(of_kind.metres, error);
    }
    progress((done += 1.0) / double(report.views().size()));
  }
  return errors;
}

void add_depths(const Report& report, const SectionProgress& progress, Section& section) {
  const auto errors = measure_depths(report, progress);
  Rows rows;
  std::vector<double> all;
  const auto add = [&](const std::string& name, const std::vector<double>& relative, double metres,
                       std::uint64_t misses) {
    rows.push_back({name, grouped(relative.size() + misses), number(median(relative)),
                    number(percentile(relative, 0.99)), number(percentile(relative, 1.0)), number(1e3 * metres),
                    grouped(misses)});
    section.results["depth"][name] = {
        {"pixels", relative.size() + misses}, {"median", median(relative)}, {"p99", percentile(relative, 0.99)},
        {"max", percentile(relative, 1.0)},   {"max_metres", metres},       {"misses", misses}};
  };
  double metres = 0.0;
  std::uint64_t misses = 0;
  for (const auto& [kind, of_kind] : errors) {
    add(kind_words(kind), of_kind.relative, of_kind.metres, of_kind.misses);
    all.insert(all.end(), of_kind.relative.begin(), of_kind.relative.end());
    metres = std::max(metres, of_kind.metres);
    misses += of_kind.misses;
  }
  if (rows.empty()) {
    section.html.paragraph("left out: drawn depths, since no sampled pixel shows a primitive.");
    return;
  }
  add("all", all, metres, misses);
  section.html.table(
      {"kind", "pixels", "median", "99th percentile", "largest", "largest, mm", "ray misses"}, rows,
      {"Relative errors of drawn depths: float shaders, float records and depth buffer against the first crossing of "
       "the pixel's ray with the same item in double, over a sample of the pixels of " +
           std::to_string(report.views().size()) +
           " views. A ray that misses passes just beside an item's edge that the image shows. Large errors stand "
           "where a ray grazes a surface: another crossing of the same item is then the first.",
       report.section_command("stability")});
  section.headline = "depths differ from double precision by " + number(percentile(all, 0.99)) +
                     " at the 99th percentile of " + grouped(all.size()) + " pixels.";
}

}  // namespace

Section stability_section(const Report& report, const SectionProgress& progress) {
  Section section;
  const auto& items = report.model().report.items;
  std::uint64_t solids = 0;
  for (int k = 0; k < core::kPrimitiveKindCount; ++k) solids += Kind(k) == Kind::kLine ? 0 : items[std::size_t(k)];
  if (solids == 0) {
    section.left_out = "the model has no primitives";
    return section;
  }
  add_ranges(report, section);
  add_depths(report, progress, section);
  return section;
}

}  // namespace sightline::apps
