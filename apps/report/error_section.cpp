// Error against run time: several ways to draw the model, compared with a reference and with one another.
#include <algorithm>
#include <cmath>

#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/svg_canvas.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/apps/report/report.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::apps {
namespace {

/// A way to draw the model.
struct Variant {
  std::string label;
  std::shared_ptr<core::Scene> scene;
  engine::EngineConfig config;
  int reduced = 1;  ///< drawn that many times smaller, and enlarged
};

/// The reference that images are compared with. A pixel's item is wrong when the reference shows it at no sample of the
/// pixel.
struct Reference {
  image::Image colour;
  std::vector<std::uint64_t> seen;  ///< pixel << 32 | id, sorted

  bool shows(std::size_t pixel, std::uint32_t id) const {
    return std::binary_search(seen.begin(), seen.end(), std::uint64_t(pixel) << 32 | id);
  }
};
using MakeReference = core::Expected<Reference> (*)(const Report&, const core::View&);

/// Means over all views.
struct VariantFigures {
  std::string label;
  double ms = 0.0, flip_mean = 0.0, flip_p99 = 0.0;
  double wrong_ids = 0.0;            ///< share of all pixels
  std::vector<image::Image> images;  ///< by view
  std::vector<double> flips;         ///< mean FLIP by view
  bool on_front = false;             ///< no other variant is faster without being more wrong
};

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
core::Expected<core::View> shifted(const core::View& view, double x, double y, int width, int height) {
  core::dmat4 clip_from_eye = view.clip_from_eye();
  for (int column = 0; column < 4; ++column) {
    clip_from_eye[column][0] += 2.0 * x / width * clip_from_eye[column][3];
    clip_from_eye[column][1] += 2.0 * y / height * clip_from_eye[column][3];
  }
  return core::View::from_matrices(view.eye_from_world(), clip_from_eye, view.clip_depth());
}

/// One sample at each pixel's centre, as drawn by default.
core::Expected<Reference> plain(const Report& report, const core::View& view) {
  if (auto frame = report.engine().frame(view); !frame) return tl::unexpected(frame.error());
  auto colour = report.engine().read_colour();
  if (!colour) return tl::unexpected(colour.error());
  const auto ids = report.engine().read_ids();
  if (!ids) return tl::unexpected(ids.error());
  Reference reference{std::move(*colour), {}};
  for (std::size_t i = 0; i < ids->ids.size(); ++i) reference.seen.push_back(std::uint64_t(i) << 32 | ids->ids[i]);
  return reference;
}

constexpr int kGrid = 8;  // samples of the reference per pixel and axis

/// Averages the stored colours of 8 x 8 images whose samples lie on a regular grid in each pixel. The items seen are
/// those at these samples and at the pixel's centre, which is none of them.
core::Expected<Reference> supersampled(const Report& report, const core::View& view) {
  const std::size_t pixels = std::size_t(report.width()) * std::size_t(report.height());
  std::vector<std::uint32_t> sums(3 * pixels);
  auto reference = plain(report, view);
  if (!reference) return reference;
  std::vector<std::uint32_t> last(pixels, ~0u);
  for (int sample = 0; sample < kGrid * kGrid; ++sample) {
    const auto offset = [](int i) { return (i + 0.5) / kGrid - 0.5; };
    const auto moved = shifted(view, offset(sample % kGrid), offset(sample / kGrid), report.width(), report.height());
    if (!moved) return tl::unexpected(moved.error());
    if (auto frame = report.engine().frame(*moved); !frame) return tl::unexpected(frame.error());
    const auto colour = report.engine().read_colour();
    if (!colour) return tl::unexpected(colour.error());
    const auto ids = report.engine().read_ids();
    if (!ids) return tl::unexpected(ids.error());
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += colour->pixels[i];
    for (std::size_t i = 0; i < pixels; ++i)
      if (ids->ids[i] != std::exchange(last[i], ids->ids[i]))
        reference->seen.push_back(std::uint64_t(i) << 32 | ids->ids[i]);
  }
  constexpr std::uint32_t kSamples = kGrid * kGrid;
  for (std::size_t i = 0; i < sums.size(); ++i)
    reference->colour.pixels[i] = std::uint8_t((sums[i] + kSamples / 2) / kSamples);
  core::sort_unique(reference->seen);
  return reference;
}

core::Expected<void> add_errors(const Reference& reference, const Variant& variant, DrawnImage image, double share,
                                VariantFigures& figures) {
  if (variant.reduced > 1) {
    image.colour = enlarged(image.colour, reference.colour.width, reference.colour.height);
    image.ids = enlarged(image.ids, reference.colour.width, reference.colour.height);
  }
  const auto metrics = image::image_metrics(reference.colour, image.colour);
  if (!metrics) return tl::unexpected(metrics.error());
  figures.flips.push_back(metrics->flip_mean);
  figures.flip_mean += share * metrics->flip_mean;
  figures.flip_p99 += share * metrics->flip_p99;
  std::uint64_t wrong = 0;
  for (std::size_t i = 0; i < image.ids.ids.size(); ++i) wrong += !reference.shows(i, image.ids.ids[i]);
  figures.wrong_ids += share * double(wrong) / double(image.ids.ids.size());
  figures.images.push_back(std::move(image.colour));
  return {};
}

void mark_front(std::vector<VariantFigures>& variants) {
  for (VariantFigures& v : variants)
    v.on_front = std::none_of(variants.begin(), variants.end(), [&](const VariantFigures& other) {
      return other.ms <= v.ms && other.flip_mean <= v.flip_mean && (other.ms < v.ms || other.flip_mean < v.flip_mean);
    });
}

/// One for each of the report's views.
core::Expected<std::vector<Reference>> make_references(const Report& report, MakeReference make) {
  std::vector<Reference> references;
  for (const ReportView& place : report.views()) {
    auto reference = make(report, place.view);
    if (!reference) return tl::unexpected(reference.error());
    references.push_back(std::move(*reference));
  }
  return references;
}

/// Draws all variants from the report's views, and compares each image with the view's reference.
core::Expected<std::vector<VariantFigures>> error_against_time(const Report& report,
                                                               const std::vector<Variant>& variants,
                                                               const std::vector<Reference>& references,
                                                               const SectionProgress& progress) {
  constexpr int kPasses = 3;
  std::vector<VariantFigures> figures;
  std::vector<DrawnVariant> drawn;
  for (const Variant& variant : variants) {
    engine::EngineConfig config = variant.config;
    config.width /= variant.reduced;
    config.height /= variant.reduced;
    auto made = DrawnVariant::create(variant.scene, config);
    if (!made) return tl::unexpected(made.error());
    drawn.push_back(std::move(*made));
    figures.push_back({});
    figures.back().label = variant.label;
  }
  const double share = 1.0 / double(report.views().size());
  for (std::size_t v = 0; v < references.size(); ++v) {
    const core::View& view = report.views()[v].view;
    const auto times = time_in_turns(drawn, view, kPasses);
    if (!times) return tl::unexpected(times.error());
    for (std::size_t i = 0; i < variants.size(); ++i) {
      figures[i].ms += share * (*times)[i];
      if (auto ms = drawn[i].draw(view); !ms) return tl::unexpected(ms.error());
      auto image = drawn[i].image(view);
      if (!image) return tl::unexpected(image.error());
      auto done = add_errors(references[v], variants[i], std::move(*image), share, figures[i]);
      if (!done) return tl::unexpected(done.error());
    }
    progress(double(v + 1) * share);
  }
  mark_front(figures);
  return figures;
}

// --- how a comparison is shown ---------------------------------------------------------------------------------------

struct Explanation {
  std::string title, text, command;
  std::size_t pictured;  ///< the variant whose image is shown beside the reference
};

std::string pareto_plot(const std::string& title, const std::vector<VariantFigures>& variants) {
  PanelSeries front{"no other is faster and less wrong", {}, PanelSeries::Style::kPoints};
  PanelSeries rest{"another is", {}, PanelSeries::Style::kPoints}, line{"", {}, PanelSeries::Style::kDashes};
  for (const VariantFigures& v : variants) {
    (v.on_front ? front : rest).points.push_back({v.ms, v.flip_mean, v.label});
    if (v.on_front) line.points.push_back({v.ms, v.flip_mean, ""});
  }
  std::sort(line.points.begin(), line.points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
  std::vector<PanelSeries> series{std::move(line), std::move(front)};
  if (!rest.points.empty()) series.push_back(std::move(rest));
  PanelPlot plot{title, "ms a frame", "FLIP, mean", {{"", std::move(series)}}};
  plot.large = true;
  return svg_panels(plot);
}

core::Expected<void> show(const Report& report, const std::vector<VariantFigures>& variants,
                          const std::vector<Reference>& references, const Explanation& words, const std::string& key,
                          Section& section) {
  std::vector<std::vector<std::string>> rows;
  for (const VariantFigures& v : variants) {
    rows.push_back({v.label, number(v.ms), number(v.flip_mean), number(v.flip_p99), percent(v.wrong_ids),
                    v.on_front ? "yes" : "no"});
    section.figures[key].push_back({{"label", v.label},
                                    {"ms", v.ms},
                                    {"flip", {{"mean", v.flip_mean}, {"p99", v.flip_p99}}},
                                    {"wrong_ids", v.wrong_ids},
                                    {"on_front", v.on_front}});
  }
  section.html.heading(words.title);
  section.html.paragraph(words.text);
  section.html.table(
      {"drawn as", "ms a frame", "FLIP, mean", "FLIP, 99th percentile", "pixels with a wrong item", "on the front"},
      rows,
      {"Means over " + std::to_string(report.views().size()) +
           " views. Times: median of three frames of a view at rest, each waited for, all in turns. On "
           "the front: no other is faster without being more wrong.",
       words.command});
  section.html.plot(pareto_plot(words.title, variants),
                    {"Error against time. The dashed line joins the front; a point at 0 has no error.", words.command});
  const VariantFigures& pictured = variants[words.pictured];
  const auto view =
      std::size_t(std::max_element(pictured.flips.begin(), pictured.flips.end()) - pictured.flips.begin());
  const std::array images{
      LabelledImage{"reference, " + report.views()[view].name, references[view].colour},
      LabelledImage{pictured.label, pictured.images[view]},
      LabelledImage{kDifferenceLabel, differences_on_white(references[view].colour, pictured.images[view])}};
  return section.html.images(
      images, {"The reference and one of the variants, in the view where they differ most.", words.command});
}

// --- comparisons -----------------------------------------------------------------------------------------------------

std::string length_words(double metres) {
  return metres < 1.0 ? short_number(1e3 * metres) + " mm" : short_number(metres) + " m";
}

/// Half the median over all primitives of their box's smallest side, metres: about the radius of the usual pipe. 0
/// without primitives.
double usual_radius(const core::Snapshot& snapshot) {
  std::vector<double> sides;
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    if (snapshot.vacant(slot) || int(snapshot.kind(slot)) >= core::kPrimitiveKindCount) continue;
    const core::Aabb box = snapshot.bounds().box(slot);
    const core::dvec3 size = core::dvec3(box.max) - core::dvec3(box.min);
    const double side = std::min({size.x, size.y, size.z});
    if (snapshot.kind(slot) != core::Kind::kLine && side > 0.0) sides.push_back(side);
  }
  return 0.5 * median(std::move(sides));
}

double one_digit(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)));
  return std::round(value / unit) * unit;
}

std::uint64_t triangles_of(const core::Scene& scene) {
  std::uint64_t triangles = 0;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) >= core::kPrimitiveKindCount)
      triangles += scene.mesh(scene.mesh_of(item)).indices.size() / 3;
  return triangles;
}

/// About as many as tessellated_within() makes: from a sample of the items.
double expected_triangles(const core::Scene& scene, double metres) {
  constexpr std::size_t kSample = 1000;
  std::vector<core::ItemId> items;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) < core::kPrimitiveKindCount) items.push_back(item);
  const std::size_t step = std::max<std::size_t>(1, items.size() / kSample);
  core::Scene sample;
  for (std::size_t i = 0; i < items.size(); i += step)
    sample.add_primitive(sample.root(), scene.primitive(items[i]), scene.state(items[i]).world_from_item);
  return double(step) * double(triangles_of(tessellated_within(sample, metres)));
}

core::Expected<void> compare_tessellations(const Report& report, const std::shared_ptr<core::Scene>& scene,
                                           const SectionProgress& progress, Section& section) {
  constexpr double kMostTriangles = 1e7;  // of all variants together
  const double radius = usual_radius(report.snapshot());
  if (radius <= 0.0) {
    section.html.paragraph("left out: ray-casting against triangles, since the model has no solid primitives.");
    return {};
  }
  std::vector<Variant> variants{{"ray-cast", scene, report.engine_config()}};
  std::string too_many;
  double made_so_far = 0.0;
  for (const double share : {0.3, 0.1, 0.03, 0.01, 0.003}) {
    const double tolerance = one_digit(share * radius), expected = expected_triangles(*scene, tolerance);
    if (made_so_far + expected > kMostTriangles) {
      too_many = " Triangles within " + length_words(tolerance) + " are left out: about " + number(expected) + ".";
      break;
    }
    auto made = std::make_shared<core::Scene>(tessellated_within(*scene, tolerance));
    if (auto done = made->commit(); !done) return tl::unexpected(done.error());
    made_so_far += expected;
    const std::string label = "triangles, " + length_words(tolerance) + " (" + count_words(triangles_of(*made)) + ")";
    variants.push_back({label, std::move(made), report.engine_config()});
  }
  if (variants.size() == 1) {
    section.html.paragraph("left out: ray-casting against triangles." + too_many);
    return {};
  }
  const auto references = make_references(report, plain);
  if (!references) return tl::unexpected(references.error());
  const auto figures = error_against_time(report, variants, *references, progress);
  if (!figures) return tl::unexpected(figures.error());
  section.headline = "ray-cast " + number(figures->front().ms) + " ms a frame, triangles " +
                     number(figures->back().ms) + " ms with a mean FLIP of " + number(figures->back().flip_mean) + ".";
  return show(report, *figures, *references,
              {"Primitives: ray-cast, and as triangles within a tolerance",
               "The model's primitives as triangles that lie within a tolerance of the true surface (number of "
               "triangles in brackets), drawn by the same engine. The reference is the ray-cast image, so ray-casting "
               "has no error here by definition; the section on stability compares it with double precision. The "
               "tolerances follow from half the usual thickness of an item, " +
                   length_words(radius) + "." + too_many,
               report.command("bench error-time", report.size_option()) + "\n" + report.section_command("error"), 1},
              "tessellation", section);
}

core::Expected<void> compare_samples(const Report& report, const std::shared_ptr<core::Scene>& scene,
                                     const std::vector<Reference>& references, const SectionProgress& progress,
                                     Section& section) {
  std::vector<Variant> variants{{"half the resolution, enlarged", scene, report.engine_config(), 2},
                                {"1 sample", scene, report.engine_config()}};
  for (const int samples : {2, 4, 8}) {
    if (samples > report.context().capabilities().max_samples) break;
    variants.push_back({std::to_string(samples) + " samples", scene, report.engine_config()});
    variants.back().config.drawing.samples = samples;
  }
  const auto figures = error_against_time(report, variants, references, progress);
  if (!figures) return tl::unexpected(figures.error());
  const VariantFigures &one = (*figures)[1], &most = figures->back();
  section.headline += (section.headline.empty() ? "" : " ") + one.label + " " + number(one.ms) + " ms, FLIP " +
                      number(one.flip_mean) + "; " + most.label + " " + number(most.ms) + " ms, " +
                      number(most.flip_mean) + ".";
  return show(report, *figures, references,
              {"Samples per pixel",
               "The reference averages 64 samples per pixel, a grid of 8 x 8 made by moving the image by parts of a "
               "pixel. Its colours are averaged as they are stored, as the engine's own samples are. A pixel's item is "
               "wrong when none of the 64 samples shows it, nor the pixel's centre.",
               report.section_command("error"), 1},
              "samples", section);
}

core::Expected<void> compare_contributions(const Report& report, const std::shared_ptr<core::Scene>& scene,
                                           const std::vector<Reference>& references, const SectionProgress& progress,
                                           Section& section) {
  std::vector<Variant> variants;
  for (const float pixels : {0.0f, 0.25f, 1.0f, 4.0f, 16.0f}) {
    const std::string label = pixels > 0.0f ? "without items below " + number(pixels) + " px" : "all items";
    variants.push_back({label, scene, report.engine_config()});
    variants.back().config.culling.culler = engine::CullerChoice::kCpu;
    variants.back().config.losses.min_projected_area = pixels;
  }
  const auto figures = error_against_time(report, variants, references, progress);
  if (!figures) return tl::unexpected(figures.error());
  std::string commands;
  for (const char* pixels : {"0", "0.25", "1", "4", "16"})
    commands += report.command(
                    "replay", std::string("--culler cpu --min-projected-area ") + pixels + " " + report.size_option()) +
                "\n";
  return show(report, *figures, references,
              {"Contribution: items that are small in the image left out",
               "Items whose bounding box covers fewer pixels of the image are not drawn. The reference is the one "
               "above, 64 samples per pixel of everything: one sample per pixel is itself wrong where items are small.",
               commands + report.section_command("error"), 3},
              "contribution", section);
}

core::Expected<void> compare_levels(const Report& report, const std::shared_ptr<core::Scene>& scene,
                                    const std::vector<Reference>& references, const SectionProgress& progress,
                                    Section& section) {
  constexpr std::uint64_t kFewTriangles = 100'000;
  if (const std::uint64_t triangles = triangles_of(*scene); triangles < kFewTriangles) {
    section.html.paragraph("left out: levels of detail, since the model's meshes have " + count_words(triangles) +
                           " triangles, fewer than " + count_words(kFewTriangles) + ".");
    return {};
  }
  std::vector<Variant> variants;
  std::string commands;
  for (const double pixels : {0.0, 0.25, 0.5, 1.0, 4.0, 16.0}) {
    variants.push_back({pixels > 0.0 ? "within " + number(pixels) + " px" : "in full", scene, report.engine_config()});
    variants.back().config.culling.culler = engine::CullerChoice::kCpu;
    variants.back().config.losses.lod_error = pixels;
    commands +=
        report.command("replay", "--culler cpu --lod-error " + number(pixels) + " " + report.size_option()) + "\n";
  }
  const auto figures = error_against_time(report, variants, references, progress);
  if (!figures) return tl::unexpected(figures.error());
  section.headline += " Meshes in full " + number(figures->front().ms) + " ms, within half a pixel " +
                      number((*figures)[2].ms) + " ms.";
  return show(report, *figures, references,
              {"Levels of detail: meshes as coarse as a number of pixels allows",
               "What is drawn of a mesh lies within so many pixels of its surface, which is proved for every group of "
               "triangles. The reference is the one above, 64 samples per pixel of everything: one sample per pixel "
               "is itself wrong where triangles are small.",
               commands + report.section_command("error"), 3},
              "levels", section);
}

}  // namespace

core::Expected<Section> error_section(const Report& report, const SectionProgress& progress) {
  Section section;
  if (report.empty()) {
    section.left_out = kNothing;
    return section;
  }
  const std::shared_ptr<core::Scene> scene(&report.scene(), [](core::Scene*) {});  // the report owns it
  section.html.paragraph(
      "FLIP is a measure of the difference that a viewer sees who flips between two images: 0 for equal ones, 1 at "
      "most (render/image/image_metrics.h).");
  const auto part = [&](int step) { return [&progress, step](double share) { progress((step + share) / 4.0); }; };
  if (auto done = compare_tessellations(report, scene, part(0), section); !done) return tl::unexpected(done.error());
  const auto references = make_references(report, supersampled);
  if (!references) return tl::unexpected(references.error());
  auto done = compare_samples(report, scene, *references, part(1), section);
  if (done) done = compare_contributions(report, scene, *references, part(2), section);
  if (done) done = compare_levels(report, scene, *references, part(3), section);
  if (!done) return tl::unexpected(done.error());
  return section;
}

}  // namespace sightline::apps
