// sightline-study recognise: error against time of the recognition of primitives in triangles
// (docs/guide/recognition.md).
//
// Each primitive of a model becomes a mesh, as in a file with an object for each: of a number of segments, or within a
// chord, with coordinates as floats or rounded as files with few decimals have them. What is recognised in each mesh,
// with each tolerance, is compared with the primitive that it was. An item in which nothing is recognised, or not all,
// counts with the error of its triangles. The times are of the recognition alone, without reading files, on one thread,
// and all tolerances take turns.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/statistics.h"
#include "sightline/apps/common/svg_canvas.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/parts/parts.h"
#include "sightline/study/parts/recognise/subjects.h"
#if SIGHTLINE_HAS_GL
#include "sightline/study/parts/recognise/images.h"
#endif

namespace sightline::bench::recognise_bench {
namespace {

using Json = json::Value;
using importers::RecognisedMesh;

struct Options {
  apps::ModelOptions model;
  std::uint64_t items = 5000;
  std::vector<int> segments;  // without chords either: kSegments and kChords
  std::vector<double> chords;
  std::vector<double> tolerances{0.0, 1e-5, 1e-4, 1e-3, 1e-2}, roundings{0.0, 1e-4, 1e-3};
  int passes = 3, images = 0;
#if SIGHTLINE_HAS_GL
  gl::ContextPlatform platform = {};
#endif
  std::string json, plot;
};

constexpr int kSegments[] = {8, 12, 24, 64};
constexpr double kChords[] = {0.01, 0.002};

void add_options(apps::CommandLine& line, Options& o) {
  apps::add_model_options(line, o.model);
  const apps::Option items = line.add("--items", o.items, "Without models: a generated plant of so many items")
                                 .in_range(1000, 10'000'000)
                                 .shows_default();
  line.option("MODEL").required(false).excludes(items).described_as("Models with analytic primitives");
  line.add("--segments", o.segments,
           "Of the triangles, per full circle; without this and --chords 8 12 24 64, and chords of 0.01 0.002")
      .in_range(3, 4096)
      .separated_by(',');
  line.add("--chords", o.chords, "Between the triangles and the surfaces, metres")
      .in_range(1e-6, 10.0)
      .separated_by(',');
  line.add("--tolerances", o.tolerances, "Of the recognition, metres; 0: what each mesh tells")
      .in_range(0.0, 10.0)
      .separated_by(',')
      .shows_default();
  line.add("--roundings", o.roundings, "Coordinates are multiples of these, metres; 0: floats")
      .in_range(0.0, 1.0)
      .separated_by(',')
      .shows_default();
  line.add("--passes", o.passes, "Of which the median time counts").in_range(1, 1000).shows_default();
  line.add("--plot", o.plot, "Write error against time as SVG to FILE");
#if SIGHTLINE_HAS_GL
  line.add("--images", o.images,
           "Frames of the tour in which triangles and what is recognised in them are compared with the primitives")
      .in_range(0, 10'000)
      .shows_default();
  apps::add_context_option(line, o.platform);
#endif
  apps::add_json_option(line, o.json);
  line.examples(
      "  sightline-study recognise --plot recognise.svg --json recognise.json\n"
      "  sightline-study recognise plant.rvm --segments 12,24 --tolerances 0,0.001\n"
      "  sightline-study recognise --items 100000 --chords 0.002 --roundings 0 --images 20");
}

// --- measuring -----------------------------------------------------------------------------------------------------

/// What a tolerance makes of one tessellation.
struct Outcome {
  double tolerance = 0.0;
  std::vector<double> ms = {};                       // of each pass, processor time
  std::uint64_t recovered = 0, whole = 0, same = 0;  // triangles; items without rest; of these, of the right kind
  double reported = 0.0;                             // the largest deviation that the recognition tells
  std::vector<double> surface = {}, lengths = {};    // errors, metres, of all items and where they are known
};

struct Tessellated {
  Fineness fineness;
  std::uint64_t triangles = 0;
  std::vector<double> error = {};  // of each item's triangles, metres
  std::vector<Outcome> outcomes = {};
  Json images = nullptr;
};

std::vector<RecognisedMesh> recognise_all(const std::vector<core::Mesh>& meshes, double tolerance) {
  std::vector<RecognisedMesh> found;
  found.reserve(meshes.size());
  for (const core::Mesh& mesh : meshes) found.push_back(importers::recognise(mesh, tolerance));
  return found;
}

void judge(const std::vector<Original>& originals, const std::vector<RecognisedMesh>& found,
           const std::vector<double>& error_of_mesh, Outcome& outcome) {
  for (std::size_t i = 0; i < originals.size(); ++i) {
    const auto& primitives = found[i].primitives;
    const bool whole = !primitives.empty() && found[i].rest.indices.empty();
    for (const auto& one : primitives) {
      outcome.recovered += one.triangles;
      outcome.reported = std::max(outcome.reported, one.deviation);
    }
    outcome.surface.push_back(whole ? error_of_surfaces(originals[i], found[i]) : error_of_mesh[i]);
    if (!whole) continue;
    ++outcome.whole;
    if (primitives.size() != 1 || core::kind_of(primitives[0].primitive) != core::kind_of(originals[i].primitive))
      continue;
    ++outcome.same;
    if (const auto error = error_of_lengths(originals[i], primitives[0].primitive)) outcome.lengths.push_back(*error);
  }
}

Tessellated measure(const std::vector<Original>& originals, const std::vector<core::Mesh>& meshes,
                    const Fineness& fineness, const Options& o) {
  Tessellated made{.fineness = fineness};
  for (std::size_t i = 0; i < originals.size(); ++i) {
    made.triangles += meshes[i].indices.size() / 3;
    made.error.push_back(error_of_triangles(originals[i], meshes[i]));
  }
  for (const double tolerance : o.tolerances) made.outcomes.push_back({.tolerance = tolerance});
  for (int pass = 0; pass < o.passes; ++pass)
    for (Outcome& outcome : made.outcomes) {
      const double begin = processor_milliseconds();
      const std::vector<RecognisedMesh> found = recognise_all(meshes, outcome.tolerance);
      outcome.ms.push_back(processor_milliseconds() - begin);
      if (pass == 0) judge(originals, found, made.error, outcome);
    }
  return made;
}

std::vector<Fineness> finenesses_of(const Options& o) {
  std::vector<int> segments = o.segments;
  std::vector<double> chords = o.chords;
  if (segments.empty() && chords.empty()) {
    segments.assign(std::begin(kSegments), std::end(kSegments));
    chords.assign(std::begin(kChords), std::end(kChords));
  }
  std::vector<Fineness> all;
  for (const double rounding : o.roundings) {
    for (const int count : segments) all.push_back({count, 0.0, rounding});
    for (const double chord : chords) all.push_back({0, chord, rounding});
  }
  return all;
}

// --- report --------------------------------------------------------------------------------------------------------

std::string millimetres(double metres) {
  return apps::short_number(1e3 * metres) + " mm";
}

std::string name_of(const Fineness& fineness) {
  return fineness.segments > 0 ? std::to_string(fineness.segments) + " segments" : millimetres(fineness.chord);
}

std::string name_of_rounding(double rounding) {
  return rounding > 0.0 ? "rounded to " + millimetres(rounding) : "as floats";
}

std::string name_of_tolerance(double tolerance) {
  return tolerance > 0.0 ? millimetres(tolerance) : "automatic";
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? double(part) / double(whole) : 0.0;
}

Json to_json(const Outcome& outcome, const Tessellated& of) {
  const double ms = apps::median(outcome.ms);
  return {{"tolerance", outcome.tolerance},
          {"processor_ms", ms},
          {"triangles_per_s", ms > 0.0 ? 1e3 * double(of.triangles) / ms : 0.0},
          {"recovered", share(outcome.recovered, of.triangles)},
          {"items_whole", share(outcome.whole, of.error.size())},
          {"items_of_the_kind", share(outcome.same, of.error.size())},
          {"reported_deviation", outcome.reported},
          {"surface_error", apps::to_json(apps::summarise(outcome.surface))},
          {"length_error", apps::to_json(apps::summarise(outcome.lengths))}};
}

Json to_json(const Tessellated& made) {
  Json json{{"segments", made.fineness.segments},
            {"chord", made.fineness.chord},
            {"rounding", made.fineness.rounding},
            {"triangles", made.triangles},
            {"error_of_triangles", apps::to_json(apps::summarise(made.error))}};
  for (const Outcome& outcome : made.outcomes) json["tolerances"].push_back(to_json(outcome, made));
  if (!made.images.is_null()) json["images"] = made.images;
  return json;
}

/// Tables that are also Markdown.
void print(const std::vector<Tessellated>& all, std::FILE* out) {
  std::fprintf(out,
               "| triangles | coordinates | count | their error, mm | tolerance | processor ms | M triangles/s | "
               "recovered, %% | of the kind, %% | told, mm | surface error, mean, mm | largest | lengths, mean, mm | "
               "largest |\n"
               "| --- | --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |\n");
  const auto mm = [](double metres) { return apps::short_number(1e3 * metres); };
  for (const Tessellated& made : all)
    for (const Outcome& outcome : made.outcomes) {
      const double ms = apps::median(outcome.ms);
      const apps::Summary surface = apps::summarise(outcome.surface), lengths = apps::summarise(outcome.lengths);
      std::fprintf(out, "| %s | %s | %llu | %s | %s | %.0f | %.2f | %.2f | %.2f | %s | %s | %s | %s | %s |\n",
                   name_of(made.fineness).c_str(), name_of_rounding(made.fineness.rounding).c_str(),
                   (unsigned long long)made.triangles, mm(apps::summarise(made.error).mean).c_str(),
                   name_of_tolerance(outcome.tolerance).c_str(), ms, ms > 0.0 ? double(made.triangles) / 1e3 / ms : 0.0,
                   100.0 * share(outcome.recovered, made.triangles), 100.0 * share(outcome.same, made.error.size()),
                   mm(outcome.reported).c_str(), mm(surface.mean).c_str(), mm(surface.max).c_str(),
                   mm(lengths.mean).c_str(), mm(lengths.max).c_str());
    }
  if (std::all_of(all.begin(), all.end(), [](const Tessellated& made) { return made.images.is_null(); })) return;
  std::fprintf(
      out,
      "\n| triangles | coordinates | FLIP, triangles | FLIP, recognised | wrong ids, triangles, %% | wrong ids, "
      "recognised, %% |\n"
      "| --- | --- | --: | --: | --: | --: |\n");
  for (const Tessellated& made : all) {
    if (made.images.is_null()) continue;
    const Json &triangles = made.images["triangles"], &recognised = made.images["recognised"];
    std::fprintf(out, "| %s | %s | %.3g | %.3g | %.4f | %.4f |\n", name_of(made.fineness).c_str(),
                 name_of_rounding(made.fineness.rounding).c_str(), triangles["flip"].get<double>(),
                 recognised["flip"].get<double>(), 100.0 * triangles["wrong_ids"].get<double>(),
                 100.0 * recognised["wrong_ids"].get<double>());
  }
}

/// A panel for each rounding, a line for each tolerance over the tessellations. The triangles themselves, which cost no
/// time, stand where the first tolerance does.
core::Expected<void> write_plot(std::vector<Tessellated> all, const Options& o, const std::string& name) {
  using apps::PanelSeries;
  std::stable_sort(all.begin(), all.end(),
                   [](const Tessellated& a, const Tessellated& b) { return a.triangles < b.triangles; });
  apps::PanelPlot plot{"Recognition: error against time, " + name,
                       "processor time, ms",
                       "distance from the true surfaces, mean of the items, mm",
                       {}};
  for (const double rounding : o.roundings) {
    apps::Panel panel{"coordinates " + name_of_rounding(rounding), {}};
    panel.series.push_back({"the triangles, by segments", {}});
    for (const double tolerance : o.tolerances)
      panel.series.push_back({"tolerance " + name_of_tolerance(tolerance), {}});
    for (const Tessellated& made : all) {
      if (made.fineness.rounding != rounding) continue;
      const auto add = [&](PanelSeries& series, const Outcome& outcome, const std::vector<double>& error,
                           const std::string& text) {
        series.points.push_back({apps::median(outcome.ms), 1e3 * apps::summarise(error).mean, text,
                                 series.label + ", " + name_of(made.fineness)});
      };
      const int segments = made.fineness.segments;
      add(panel.series[0], made.outcomes[0], made.error, segments > 0 ? std::to_string(segments) : "");
      for (std::size_t i = 0; i < made.outcomes.size(); ++i)
        add(panel.series[i + 1], made.outcomes[i], made.outcomes[i].surface, "");
    }
    plot.panels.push_back(std::move(panel));
  }
  return apps::write_text(o.plot, apps::svg_panels(plot));
}

// --- the whole -----------------------------------------------------------------------------------------------------

#if SIGHTLINE_HAS_GL
/// Recognised with the first of the tolerances.
core::Expected<Json> compare_images(const Images& images, const std::vector<core::Mesh>& meshes, double tolerance) {
  Json json;
  for (const bool recognised : {false, true}) {
    const auto errors =
        images.errors(meshes, recognised ? recognise_all(meshes, tolerance) : std::vector<RecognisedMesh>{});
    if (!errors) return tl::unexpected(errors.error());
    json[recognised ? "recognised" : "triangles"] = {{"flip", errors->flip}, {"wrong_ids", errors->wrong_ids}};
  }
  return json;
}
#endif

core::Expected<int> run(const Options& o) {
  const auto made = model_or_plant(o.model, o.items);
  if (!made) return tl::unexpected(made.error());
  std::string name = o.model.files.empty() ? "generated plant of " + std::to_string(o.items) + " items" : "";
  for (const std::string& file : o.model.files)
    name += (name.empty() ? "" : ", ") + std::filesystem::path(file).filename().string();
  const std::vector<Original> originals = originals_of(**made);
  if (originals.empty()) return core::fail(name + ": has no primitives whose triangles could be recognised");
#if SIGHTLINE_HAS_GL
  std::optional<Images> images;
  if (o.images > 0) {
    auto drawn = Images::create(**made, originals, o.images, o.platform);
    if (!drawn) return tl::unexpected(drawn.error());
    images.emplace(std::move(*drawn));
  }
#endif
  const std::vector<Fineness> finenesses = finenesses_of(o);
  std::vector<Tessellated> all;
  apps::Progress progress("recognising", finenesses.size());
  for (const Fineness& fineness : finenesses) {
    std::vector<core::Mesh> meshes;
    for (const Original& original : originals) meshes.push_back(triangles_of(original, fineness));
    all.push_back(measure(originals, meshes, fineness, o));
#if SIGHTLINE_HAS_GL
    if (images) {
      auto errors = compare_images(*images, meshes, o.tolerances.front());
      if (!errors) return tl::unexpected(errors.error());
      all.back().images = std::move(*errors);
    }
#endif
    progress.advance(all.size());
  }
  std::FILE* out = apps::table_stream(o.json);
  std::fprintf(out, "%s, %zu primitives, processor times, median of %d passes\n\n", name.c_str(), originals.size(),
               o.passes);
  print(all, out);
  if (!o.plot.empty())
    if (auto done = write_plot(all, o, name); !done) return tl::unexpected(done.error());
  Json json{{"model", name}, {"primitives", originals.size()}, {"passes", o.passes}};
  for (const Tessellated& one : all) json["rows"].push_back(to_json(one));
  return finish(o.json, json);
}

}  // namespace
}  // namespace sightline::bench::recognise_bench

sightline::bench::Run sightline::bench::add_recognise(apps::CommandLine& line) {
  using namespace recognise_bench;
  return add_subcommand<Options>(line, add_options, run);
}
