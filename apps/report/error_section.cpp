// Error against frame time: exact surfaces beside triangles within tolerances, and what samples, small items and levels
// of detail change. The references are images by rays in double precision.
#include <algorithm>
#include <cmath>
#include <set>

#include "sightline/apps/common/svg_canvas.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/apps/report/answer.h"
#include "sightline/apps/report/report.h"
#include "sightline/apps/report/variants.h"

namespace sightline::apps {

namespace {

using Group = Variant::Group;
using Results = std::vector<VariantResults>;
using Style = PanelSeries::Style;

// --- the variants ----------------------------------------------------------------------------------------------------

std::uint64_t triangles_of(const core::Scene& scene) {
  std::uint64_t triangles = 0;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) >= core::kPrimitiveKindCount)
      triangles += scene.mesh(scene.mesh_of(item)).indices.size() / 3;
  return triangles;
}

/// Triangles of meshes, each counted once however many items share it.
std::uint64_t stored_triangles_of(const core::Scene& scene) {
  std::set<std::uint32_t> meshes;
  std::uint64_t triangles = 0;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) >= core::kPrimitiveKindCount)
      if (const core::MeshId mesh = scene.mesh_of(item); meshes.insert(mesh.index).second)
        triangles += scene.mesh(mesh).indices.size() / 3;
  return triangles;
}

/// About as many as tessellated_within() makes: from a sample of the items.
double expected_triangles(const core::Scene& scene, double metres) {
  constexpr std::size_t kSample = 300;
  std::vector<core::ItemId> items;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item) && int(scene.kind(item)) < core::kPrimitiveKindCount) items.push_back(item);
  const std::size_t step = std::max<std::size_t>(1, items.size() / kSample);
  core::Scene sample;
  for (std::size_t i = 0; i < items.size(); i += step)
    sample.add_primitive(sample.root(), scene.primitive(items[i]), scene.state(items[i]).world_from_item);
  return double(step) * double(triangles_of(tessellated_within(sample, metres)));
}

/// This is what the report compares, and why it leaves out what it does not.
struct Plan {
  std::vector<Variant> variants;
  std::uint64_t solids = 0, meshes = 0;             ///< items
  std::string triangles_left_out, levels_left_out;  ///< sentences; empty: nothing is
};

Variant& add(const Report& report, VariantKind kind, std::shared_ptr<core::Scene> scene, Plan& plan) {
  Variant& variant = plan.variants.emplace_back();
  static_cast<VariantKind&>(variant) = std::move(kind);
  variant.scene = std::move(scene);
  variant.config = report.engine_config();
  return variant;
}

void count_items(const core::Snapshot& snapshot, Plan& plan) {
  for (core::Slot slot = 0; slot < snapshot.size(); ++slot) {
    if (snapshot.vacant(slot) || snapshot.kind(slot) == core::Kind::kLine) continue;
    ++(int(snapshot.kind(slot)) < core::kPrimitiveKindCount ? plan.solids : plan.meshes);
  }
}

/// "some 190 million"
std::string about(double count) {
  return "some " + (count < 1e6 ? number(count) : short_number(1e-6 * count, 2) + " million");
}

/// Tolerances from coarse to fine, until their triangles would take too much time or memory.
void add_triangles(const Report& report, const std::shared_ptr<core::Scene>& scene, Plan& plan) {
  constexpr double kMostDrawn = 2e7;   // of all items and variants together, for time
  constexpr double kMostStored = 3e7;  // of all meshes and variants together, for memory: some 100 bytes each
  double drawn = 0.0, stored = 0.0, stored_share = 1.0;  // the last: of drawn ones in the variant before
  for (const double millimetres : {100.0, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1}) {
    const double tolerance = 1e-3 * millimetres, expected = expected_triangles(*scene, tolerance);
    if (drawn + expected > kMostDrawn || stored + stored_share * expected > kMostStored) {
      plan.triangles_left_out = "Triangles within " + length_words(tolerance) + (millimetres > 0.1 ? " and less" : "") +
                                " are left out: " + about(expected) + " of them, in meshes of " +
                                about(stored_share * expected) + ", would take too much time or memory.";
      return;
    }
    auto made = std::make_shared<core::Scene>(tessellated_within(*scene, tolerance));
    need(made->commit());
    const std::uint64_t triangles = triangles_of(*made), of_meshes = stored_triangles_of(*made);
    drawn += double(triangles);
    stored += double(of_meshes);
    stored_share = triangles > 0 ? double(of_meshes) / double(triangles) : 1.0;
    add(report, {Group::kTriangles, "triangles within " + length_words(tolerance), tolerance, triangles},
        std::move(made), plan);
  }
}

void add_levels(const Report& report, const std::shared_ptr<core::Scene>& scene, Plan& plan) {
  constexpr std::uint64_t kFewTriangles = 100'000;
  if (const std::uint64_t triangles = triangles_of(*scene); triangles < kFewTriangles) {
    plan.levels_left_out = "left out: levels of detail, since the model's meshes have " + grouped(triangles) +
                           " triangles, fewer than " + grouped(kFewTriangles) + ".";
    return;
  }
  for (const double pixels : {0.25, 0.5, 1.0, 4.0, 16.0}) {
    add(report, {Group::kLevels, "meshes within " + number(pixels) + " px"}, scene, plan).config.losses.lod_error =
        pixels;
  }
}

Plan make_plan(const Report& report) {
  const std::shared_ptr<core::Scene> scene = report.shared_scene();
  Plan plan;
  count_items(report.snapshot(), plan);
  const std::string drawn = plan.solids == 0   ? "meshes"
                            : plan.meshes == 0 ? "exact surfaces"
                                               : "exact surfaces and meshes";
  add(report, {Group::kExact, drawn + ", as by default"}, scene, plan);
  if (plan.solids > 0) add_triangles(report, scene, plan);
  add(report, {Group::kSamples, "half the resolution, enlarged"}, scene, plan).reduced = 2;
  for (const int samples : {4, 8}) {
    if (samples > report.context().capabilities().max_samples) break;
    add(report, {Group::kSamples, std::to_string(samples) + " samples a pixel"}, scene, plan).config.drawing.samples =
        samples;
  }
  for (const float pixels : {0.25f, 1.0f, 4.0f, 16.0f}) {
    add(report, {Group::kContribution, "without items below " + number(pixels) + " px"}, scene, plan)
        .config.losses.min_projected_area = pixels;
  }
  add_levels(report, scene, plan);
  return plan;
}

/// The variants of a group, and the default before them.
Results of_group(const Results& all, Group group) {
  Results some;
  for (const VariantResults& v : all)
    if (v.group == group || v.group == Group::kExact) some.push_back(v);
  return some;
}

std::string measured_words(const Report& report) {
  return "Means of " + std::to_string(report.views().size()) +
         " views, those of the images section; a frame's time is that of a view at rest, waited for, all variants in "
         "turns: "
         "the median of three, or of slow models one.";
}

const char* colour_of(Group group) {
  constexpr const char* kColours[] = {colours::kExact, colours::kTriangles, colours::kSamples, colours::kContribution,
                                      colours::kLevels};
  return kColours[int(group)];
}

// --- exact surfaces beside triangles ---------------------------------------------------------------------------------

SurfaceCost cost_of(const VariantResults& v) {
  return {v.tolerance, v.ms, v.error_p99};
}

AnswerResults answer_of(const Report& report, const Results& all, const Plan& plan) {
  const importers::ImportReport& imported = report.model().report;
  AnswerResults answer{plan.solids,
                       plan.meshes,
                       imported.surfaces.deviation,
                       std::max(imported.surfaces.analytic_deviation, imported.recognition.largest_deviation),
                       cost_of(all.front()),
                       {}};
  for (const VariantResults& v : all)
    if (v.group == Group::kTriangles) answer.triangles.push_back(cost_of(v));
  return answer;
}

std::string surface_plot(const Results& all) {
  PanelSeries exact{all.front().label, {}, Style::kPoints, colours::kExact};
  PanelSeries triangles{"triangles within a tolerance", {}, Style::kPointsAndLine, colours::kTriangles};
  PanelSeries levels{"meshes within so many pixels", {}, Style::kPointsAndLine, colours::kLevels};
  for (const VariantResults& v : all) {
    const double millimetres = 1e3 * v.error_p99;
    if (v.group == Group::kExact) exact.points.push_back({v.ms, millimetres, "as by default", v.label});
    if (v.group == Group::kTriangles)
      triangles.points.push_back({v.ms, millimetres, length_words(v.tolerance), v.label});
    if (v.group == Group::kLevels)
      levels.points.push_back({v.ms, millimetres, v.label.substr(v.label.find("within ") + 7), v.label});
  }
  std::vector<PanelSeries> series{std::move(exact)};
  for (PanelSeries* more : {&triangles, &levels})
    if (!more->points.empty()) series.push_back(std::move(*more));
  PanelPlot plot{"How far off the surfaces are that a frame shows, and what the frame costs",
                 "ms a frame",
                 "mm from the true surface, which 99 % of the pixels keep",
                 {{"", std::move(series)}}};
  plot.large = true;
  return svg_panels(plot);
}

/// Sentences on the surface that errors are measured from, how they are measured, and what is left out.
std::string measure_words(const Report& report, const Plan& plan) {
  std::string words;
  if (plan.meshes > 0) {
    const double off = report.model().report.surfaces.deviation;
    words = "The true surface of a mesh is its triangles" +
            (off > 0.0 ? ", which lie up to " + length_words(off) + " off the surfaces of their file. " : ". ");
  }
  words += measured_words(report);
  return plan.triangles_left_out.empty() ? words : words + " " + plan.triangles_left_out;
}

void open_page(const Report& report, const Results& all, const Plan& plan, Section& section) {
  const std::string answer = answer_sentence(answer_of(report, all, plan));
  section.results["answer"] = answer;
  section.opening.paragraph(answer);
  section.html.plot(
      surface_plot(all),
      {"Down and left is better. Names beside the points are tolerances. The true surface is what a ray through the "
       "pixel's centre hits first in double precision; distances of 99 % of the pixels are below the figure. " +
           measure_words(report, plan),
       report.section_command("error")});
}

void show_surfaces(const Report& report, const std::vector<Reference>& references, const Results& all, const Plan& plan,
                   Section& section) {
  section.html.heading("Surfaces: exact, and as triangles within a tolerance");
  if (plan.solids == 0)
    section.html.paragraph("left out: triangles in place of primitives, since the model has no solid primitives.");
  Rows rows;
  const VariantResults *exact = &all.front(), *pictured = exact;
  for (const VariantResults& v : all) {
    if (v.group == Group::kSamples || v.group == Group::kContribution) continue;
    rows.push_back({v.label, v.group == Group::kTriangles ? grouped(v.triangles) : "", number(v.ms),
                    number(v.ms / exact->ms), number(1e3 * v.error_median), number(1e3 * v.error_p99),
                    percent(v.wrong_pixels), bytes_words(v.gpu_bytes)});
    section.results["surfaces"].push_back({{"label", v.label},
                                           {"tolerance_m", v.tolerance},
                                           {"triangles", v.triangles},
                                           {"ms", v.ms},
                                           {"error_m", {{"median", v.error_median}, {"p99", v.error_p99}}},
                                           {"wrong_pixels", v.wrong_pixels},
                                           {"gpu_bytes", v.gpu_bytes}});
    if (v.group == Group::kTriangles && (v.tolerance >= 0.03 * 0.999 || pictured == exact)) pictured = &v;
  }
  section.html.table(
      {"drawn as", "triangles", "ms a frame", "times as long", "mm off, median", "mm off, 99 %",
       "pixels with another item", "GPU memory"},
      rows,
      {"The model's primitives as the engine draws them, and as triangles that lie within a tolerance of "
       "the surface, by the same engine. Off: the distance of the drawn point from the true surface, "
       "where the pixel shows the same item as the ray through its centre in double precision "
       "(raytrace/tracer.h); another item at the same depth counts as the same. Rays do not see lines, "
       "nor what is behind transparent items. " +
           measure_words(report, plan),
       report.section_command("error")});
  const auto view = std::size_t(std::max_element(pictured->differences.begin(), pictured->differences.end()) -
                                pictured->differences.begin());
  const std::array images{
      LabelledImage{"by rays in double precision, " + report.views()[view].name, references[view].colour},
      LabelledImage{exact->label, exact->images[view]},
      LabelledImage{"difference of the two, four times amplified; white: none",
                    differences_on_white(references[view].colour, exact->images[view])},
      LabelledImage{"difference of rays and " + pictured->label + ", likewise",
                    differences_on_white(references[view].colour, pictured->images[view])}};
  need(section.html.images(std::span(images).first(pictured == exact ? 3 : 4),
                           {"The view in which most pixels differ.", report.section_command("error")}));
}

// --- other choices ---------------------------------------------------------------------------------------------------

struct Explanation {
  Group group;
  const char *title, *text, *legend, *key;
  std::size_t pictured;  ///< the variant whose image is shown beside the reference; 0: the default
};
constexpr Explanation kSamplesWords{
    Group::kSamples,
    "Samples per pixel",
    "By default, a pixel shows what is at its centre. More samples smooth edges; fewer pixels save time.",
    "another number of samples",
    "samples",
    0};
constexpr Explanation kContributionWords{Group::kContribution,
                                         "Contribution: items that are small in the image left out",
                                         "Items whose bounding box covers fewer pixels of the image are not drawn.",
                                         "small items left out",
                                         "contribution",
                                         3};
constexpr Explanation kLevelsWords{
    Group::kLevels,
    "Levels of detail: meshes as coarse as a number of pixels allows",
    "What is drawn of a mesh lies within so many pixels of its surface, which is proved for every group of triangles.",
    "coarser meshes",
    "levels",
    3};

/// Whether no other is faster without being more wrong.
bool on_front(const VariantResults& v, const Results& all) {
  return std::none_of(all.begin(), all.end(), [&](const VariantResults& other) {
    return other.ms <= v.ms && other.flip_mean <= v.flip_mean && (other.ms < v.ms || other.flip_mean < v.flip_mean);
  });
}

std::string choice_plot(const Explanation& words, const Results& variants) {
  PanelSeries exact{variants.front().label, {}, Style::kPoints, colours::kExact};
  PanelSeries others{words.legend, {}, Style::kPoints, colour_of(words.group)};
  PanelSeries front{"nothing measured is both faster and less wrong", {}, Style::kDashes, "#999999"};
  for (const VariantResults& v : variants) {
    const bool is_exact = v.group == Group::kExact;
    (is_exact ? exact : others).points.push_back({v.ms, v.flip_mean, is_exact ? "as by default" : v.label, v.label});
    if (on_front(v, variants)) front.points.push_back({v.ms, v.flip_mean, ""});
  }
  std::sort(front.points.begin(), front.points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
  PanelPlot plot{words.title,
                 "ms a frame",
                 "visible difference (FLIP, mean), 0 to 1",
                 {{"", {std::move(front), std::move(exact), std::move(others)}}}};
  plot.large = true;
  return svg_panels(plot);
}

void show(const Report& report, const std::vector<Reference>& references, const Results& variants,
          const Explanation& words, Section& section) {
  Rows rows;
  for (const VariantResults& v : variants) {
    const bool front = on_front(v, variants);
    rows.push_back(
        {v.label, number(v.ms), number(v.flip_mean), number(v.flip_p99), percent(v.wrong_ids), front ? "yes" : "no"});
    section.results[words.key].push_back({{"label", v.label},
                                          {"ms", v.ms},
                                          {"flip", {{"mean", v.flip_mean}, {"p99", v.flip_p99}}},
                                          {"wrong_ids", v.wrong_ids},
                                          {"on_front", front}});
  }
  section.html.heading(words.title);
  section.html.paragraph(words.text);
  const std::string command = report.section_command("error");
  section.html.table(
      {"drawn as", "ms a frame", "FLIP, mean", "FLIP, 99th percentile", "pixels with a wrong item", "worth choosing"},
      rows, {measured_words(report) + " Worth choosing: none measured is both faster and less wrong.", command});
  section.html.plot(choice_plot(words, variants),
                    {"Visible difference against time; down and left is better.", command});
  const VariantResults& pictured = variants[words.pictured];
  const auto view = std::size_t(std::max_element(pictured.differences.begin(), pictured.differences.end()) -
                                pictured.differences.begin());
  const std::array images{
      LabelledImage{"16 rays a pixel, " + report.views()[view].name, references[view].smooth},
      LabelledImage{pictured.label, pictured.images[view]},
      LabelledImage{kDifferenceLabel, differences_on_white(references[view].smooth, pictured.images[view])}};
  need(section.html.images(images, {"The view in which they differ most.", command}));
}

void show_all(const Report& report, const std::vector<Reference>& references, const Results& all, const Plan& plan,
              Section& section) {
  open_page(report, all, plan, section);
  show_surfaces(report, references, all, plan, section);
  section.html.paragraph(
      "The images of the following variants are compared with the mean of 16 rays a pixel, in a grid of 4 x 4. FLIP is "
      "a measure of the difference that a viewer sees who flips between two images: 0 for equal ones, 1 at most "
      "(render/image/image_metrics.h). A pixel's item is wrong when none of these rays hits it, nor one through the "
      "pixel's centre.");
  show(report, references, of_group(all, Group::kSamples), kSamplesWords, section);
  show(report, references, of_group(all, Group::kContribution), kContributionWords, section);
  if (plan.levels_left_out.empty())
    show(report, references, of_group(all, Group::kLevels), kLevelsWords, section);
  else
    section.html.paragraph(plan.levels_left_out);
}

}  // namespace

Section error_section(const Report& report, const SectionProgress& progress) {
  Section section;
  const auto references = trace_references(report, [&](double share) { progress(0.2 * share); });
  const auto plan = make_plan(report);
  const auto all =
      measure_variants(report, plan.variants, references, [&](double share) { progress(0.3 + 0.7 * share); });
  show_all(report, references, all, plan, section);
  section.headline = std::to_string(all.size()) + " ways to draw the model, their times and errors.";
  return section;
}

}  // namespace sightline::apps
