// The first page: an image, what the model is, what it costs to fly through it, what is approximate, what is heavy.
#include <algorithm>
#include <set>

#include "sightline/apps/common/flight.h"
#include "sightline/apps/common/legend.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/style_options.h"
#include "sightline/apps/report/answer.h"
#include "sightline/apps/report/heavy_parts.h"
#include "sightline/apps/report/report.h"
#include "sightline/core/internal/platform/console.h"

namespace sightline::apps {
namespace {

constexpr std::size_t kHeavyParts = 5;
constexpr int kPasses = 3;  // of timed images at rest
constexpr int kImageSamples = 4;

std::string counted(std::uint64_t count, const std::string& one, const std::string& several) {
  return grouped(std::int64_t(count)) + " " + (count == 1 ? one : several);
}

/// "1,615 items in 96 parts: 1,600 primitives and 15 meshes of 8,864 triangles; 22.1 x 23.8 x 8.6 m"
std::string model_words(const Report& report) {
  const core::Scene& scene = report.scene();
  std::uint64_t primitives = 0, meshes = 0, triangles = 0;
  std::set<std::uint32_t> parts;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    if (!scene.contains_item(item)) continue;
    if (const core::NodeId part = core::part_of(scene, scene.node_of(item)); part.valid()) parts.insert(part.index);
    if (int(scene.kind(item)) < core::kPrimitiveKindCount) {
      ++primitives;
    } else {
      ++meshes;
      triangles += scene.mesh(scene.mesh_of(item)).indices.size() / 3;
    }
  }
  std::string words = counted(primitives + meshes, "item", "items");
  if (!parts.empty()) words += " in " + counted(parts.size(), "part", "parts");
  std::string kinds = primitives > 0 ? counted(primitives, "primitive", "primitives") : "";
  if (meshes > 0)
    kinds += (kinds.empty() ? "" : " and ") + counted(meshes, "mesh", "meshes") + " of " +
             counted(triangles, "triangle", "triangles");
  const core::AabbD bounds = scene.bounds(scene.root());
  words += ": " + kinds;
  if (bounds.empty()) return words + ".";
  const core::dvec3 size = bounds.size();
  return words + "; " + length_words(size.x) + " x " + length_words(size.y) + " x " + length_words(size.z) + ".";
}

/// What readers left out, or nothing.
std::vector<std::string> losses_of(const importers::ImportReport& imported) {
  std::vector<std::string> losses;
  const auto add = [&](std::uint64_t count, const char* one, const char* several) {
    if (count > 0) losses.push_back(counted(count, one, several));
  };
  add(imported.surfaces.failed_faces, "face could not be meshed", "faces could not be meshed");
  add(imported.surfaces.curves, "curve was not read", "curves were not read");
  add(imported.surfaces.annotations, "annotation was not read", "annotations were not read");
  add(imported.degenerate, "item has no volume", "items have no volume");
  add(imported.warnings.size(), "warning", "warnings");
  constexpr std::size_t kMostMessages = 3;
  for (std::size_t i = 0; i < std::min(kMostMessages, imported.warnings.size()); ++i)
    losses.push_back(imported.warnings[i].message);
  return losses;
}

void show_legend(const query::Colouring& colours, HtmlBody& html) {
  std::vector<Badge> badges;
  std::vector<std::vector<std::string>> rows;
  for (const query::ColourGroup& group : colours.groups) {
    badges.push_back({hex_of(group.colour), group.colour});
    rows.push_back({group.label, grouped(std::int64_t(group.items))});
  }
  html.table({colours.key, "items"}, rows, {"What the colours mean.", ""}, badges);
}

void show_image(const Report& report, Section& section) {
  engine::EngineConfig config = report.engine_config();
  config.drawing.looks = DrawnOptions{.looks = engine::Looks::standard()}.looks_of(report.scene());
  config.drawing.samples = std::min(kImageSamples, report.context().capabilities().max_samples);
  auto engine = need(engine::Engine::create(report.scene(), config));
  const std::string& key = report.options().colour_by;
  const query::Colouring colours = need(apply_colours(key, report.scene(), engine));
  const ReportView& place = report.views().front();
  need(engine.frame(place.view));
  const std::array images{LabelledImage{place.name, need(engine.read_colour())}};
  const std::string coloured = key.empty() ? "" : " --colour-by " + core::platform::shell_word(key);
  const std::string image = place.options + " " + report.size_option() + coloured + " --out image.png";
  need(section.html.images(images, {model_words(report), report.command("render", image)}, 1));
  if (colours.groups.empty()) return;
  show_legend(colours, section.html);
  section.results["colours"] = legend_json(colours);
}

void show_losses(const Report& report, Section& section) {
  const std::vector<std::string> losses = losses_of(report.model().report);
  section.html.paragraph(losses.empty() ? "Lost on import: nothing, and the readers have no warnings."
                                        : "Lost or odd on import:");
  section.html.list(losses);
  section.results["losses"] = losses;
}

double median_of(const Flight& flight, double (*value)(const engine::FrameReport&)) {
  return median(flight.collect(value));
}

/// What a flight costs, and where its time goes.
void show_flight(const Report& report, engine::Engine& engine, Section& section) {
  const Flight flight = need(fly(engine, report.tour(), {report.options().frames, report.aspect(), true},
                                 [](Flight&) -> core::Expected<void> { return {}; }));
  const std::vector<double> frames = flight.collect([](const engine::FrameReport& r) { return r.frame_ms; });
  const double frame = median(frames), cull = median_of(flight, [](const engine::FrameReport&r) { return r.cull_ms; }),
               submit = median_of(flight, [](const engine::FrameReport&r) { return r.draw_ms - r.wait_ms; });
  const double rest = std::max(0.0, frame - cull - submit);
  const bool software = report.context().capabilities().software;  // which draws while it is called
  const engine::MemoryReport memory = report.engine().memory();
  section.html.heading("What it costs to fly through it");
  section.html.table(
      {"", ""},
      {{"a frame of the tour, ms: median; slowest twentieth", number(frame) + "; " + number(percentile(frames, 0.95))},
       {"- culling", number(cull)},
       {software ? "- choosing what is drawn, and drawing" : "- choosing and submitting what is drawn", number(submit)},
       {software ? "- all else" : "- drawing, and all else", number(rest)},
       {"first image after, ms", number(report.times().first_image())},
       {"main memory; graphics memory",
        bytes_words(memory.scene + memory.snapshot + memory.bvh) + "; " + bytes_words(memory.gpu)}},
      {"Frames of " + report.options().size + " pixels, as by default, on " + report.context().renderer() + ".",
       report.command("replay", report.tour_option() + " " + report.size_option())});
  section.results["frame_ms"] = {
      {"median", frame}, {"p95", percentile(frames, 0.95)}, {"cull", cull}, {"submit", submit}, {"rest", rest}};
}

/// Milliseconds of an image at rest: the mean of two views.
double time_at_rest(const Report& report, engine::Engine& engine) {
  const auto views = std::span(report.views()).first(std::min<std::size_t>(2, report.views().size()));
  double sum = 0.0;
  for (const ReportView& place : views) {
    std::vector<double> passes;
    for (int pass = 0; pass <= kPasses; ++pass) {
      const double begin = now_ms();
      need(engine.frame(place.view));
      engine.finish();
      if (pass > 0) passes.push_back(now_ms() - begin);  // the first one learns what is hidden
    }
    sum += median(std::move(passes));
  }
  return sum / double(views.size());
}

void show_heavy_parts(const Report& report, engine::Engine& engine, const SectionProgress& progress, Section& section) {
  const core::Scene& scene = report.scene();
  const bool from_surfaces = report.model().report.surfaces.meshed_bodies > 0;
  const double whole = time_at_rest(report, engine);
  Rows rows;
  const std::vector<HeavyPart> parts = heavy_parts(scene, kHeavyParts);
  for (const HeavyPart& part : parts) {
    need(engine.hide(part.items));
    const double without = time_at_rest(report, engine);
    need(engine.show(part.items));
    const std::string path = scene.path(part.node), advice = advice_for(scene, part, from_surfaces);
    rows.push_back({path, percent(part.weight), grouped(std::int64_t(part.items.size())),
                    grouped(std::int64_t(part.triangles)), number(whole) + " → " + number(without), advice});
    section.results["heavy_parts"].push_back({{"node", path},
                                              {"weight", part.weight},
                                              {"items", part.items.size()},
                                              {"triangles", part.triangles},
                                              {"mesh_bytes", part.mesh_bytes},
                                              {"ms", whole},
                                              {"ms_without", without},
                                              {"advice", advice}});
    progress(0.5 + 0.5 * double(rows.size()) / double(parts.size()));
  }
  section.html.heading("The heaviest parts");
  section.html.text_table({"part", "share", "items", "triangles", "ms a frame → without it", "what makes it lighter"},
                          rows,
                          {"By triangles, a primitive counting as 12. Times are means of two views at rest; hiding a "
                           "part may show others that it hid.",
                           report.section_command("glance")});
}

void show_approximations(const Report& report, Section& section) {
  const importers::ImportReport& imported = report.model().report;
  std::vector<std::string> lines;
  if (imported.surfaces.deviation > 0.0)
    lines.push_back("Triangles lie up to " + length_words(imported.surfaces.deviation) +
                    " off the surfaces of their file (--chord-tolerance, --chord-angle).");
  const double moved = std::max(imported.surfaces.analytic_deviation, imported.recognition.largest_deviation);
  if (moved > 0.0) lines.push_back("Primitives lie up to " + length_words(moved) + " off what the files have.");
  if (imported.sharing_error > 0.0)
    lines.push_back("Meshes that share one are moved by up to " + length_words(imported.sharing_error) + ".");
  lines.push_back("Frames leave nothing out, unless told to by --budget-ms, --min-projected-area or --lod-error.");
  section.html.heading("What is approximate");
  section.html.list(lines);
  section.results["approximations"] = lines;
}

}  // namespace

Section glance_section(const Report& report, const SectionProgress& progress) {
  Section section;
  section.results["model"] = model_words(report);
  if (!report.empty()) show_image(report, section);
  show_losses(report, section);
  if (report.empty()) return section;
  progress(0.1);
  auto engine = need(engine::Engine::create(report.scene(), report.engine_config()));
  show_flight(report, engine, section);
  progress(0.5);
  show_approximations(report, section);
  show_heavy_parts(report, engine, progress, section);
  return section;
}

}  // namespace sightline::apps
