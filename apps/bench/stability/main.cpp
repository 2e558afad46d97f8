// sightline-stability: computes stiff and extreme cases of all analytic primitives in double and in the shaders, and
// compares them with a reference of 113 bits.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include "sightline/apps/bench/stability/measure.h"
#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/thread_pool.h"
#include "sightline/importers/json/internal/json.h"
#if SIGHTLINE_HAS_GL
#include "sightline/apps/bench/stability/fuzz.h"
#include "sightline/apps/bench/stability/view_rays.h"
#endif
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/apps/bench/stability/traced_rays.h"
#endif

namespace {

using namespace sightline;
using apps::need;
using bench::Case;
using bench::Path;
using bench::Result;
using Json = json::Value;

struct Options {
  int rays = 200;
  std::int64_t fuzz = 0, trace = 0;
  std::uint64_t seed = 1;
  std::vector<std::string> primitives, families, paths;
  std::string json, plot;
  gl::ContextPlatform platform = {};
  bool details = false;
};

bool wanted(const std::vector<std::string>& names, std::string_view name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

void add_options(apps::CommandLine& line, Options& options) {
  line.add("--rays", options.rays, "per case").in_range(1, 1'000'000).shows_default();
  line.add("--seed", options.seed, "of all cases; of --trace, of the first 10,000 rays, and 1 more for the next")
      .shows_default();
  std::vector<std::string> kinds, families = bench::stability_families();
  for (int kind = 0; kind < core::kPrimitiveKindCount; ++kind) kinds.emplace_back(core::name_of(core::Kind(kind)));
  families.insert(families.end(), {"near-far", "field-of-view", "view-offset", "view-distance"});
  line.add("--primitive", options.primitives, "only these kinds, as sightline-info names them")
      .metavar("KIND")
      .one_of(kinds);
  line.add("--case", options.families, "only these families").metavar("FAMILY").one_of(families);
  line.add("--path", options.paths, "only these ways of computing").one_of({"double", "glsl"});
  line.add("--fuzz", options.fuzz, "instead: so many random parameter sets of each kind through the shaders")
      .in_range(std::int64_t(1), std::int64_t(1'000'000'000));
  line.add("--trace", options.trace, "instead: so many rays through the ray tracer, half of them in mixed scenes")
      .in_range(std::int64_t(1), std::int64_t(1'000'000'000'000));
  line.add_flag("--details", options.details, "a line for every magnitude, not only for the worst of a family");
  apps::add_context_option(line, options.platform);
  apps::add_json_option(line, options.json);
  line.add("--plot", options.plot, "error against magnitude, SVG").accepted_by(apps::parse_svg_name);
}

/// Calls work(0 ... count - 1) on all processors, and shows the progress.
template <class Work>
void for_all(const char* label, std::size_t count, const Work& work) {
  apps::Progress progress(label, count);
  std::atomic<std::size_t> done = 0;
  const auto own = std::this_thread::get_id();
  const auto job = [&](std::uint32_t i) {
    work(i);
    ++done;
    if (std::this_thread::get_id() == own) progress.advance(done);
  };
  core::ThreadPool(int(std::thread::hardware_concurrency())).run_at_once(std::uint32_t(count), job);
}

/// Data of one case, for every path.
struct Prepared {
  std::vector<bench::Sample> samples;
  std::vector<bench::Truth> truths;
};

Result result_of(const Case& c, Path path, const Prepared& p, const std::vector<bench::Answer>& answers) {
  const bench::Limits& limits = path == Path::kDouble ? c.wide : c.single;
  return {c.kind, c.family, c.name(), c.magnitude, path, judge(p.samples, p.truths, answers, limits)};
}

/// Without GL nothing is measured; that is an error only if the shaders were requested.
void measure_shaders([[maybe_unused]] const std::vector<Case>& cases,
                     [[maybe_unused]] const std::vector<Prepared>& prepared, const Options& options,
                     [[maybe_unused]] std::vector<std::vector<Result>>& by_case) {
#if SIGHTLINE_HAS_GL
  auto shaders = bench::GlslRays::create(options.platform);
  if (!shaders && options.paths.empty()) {
    std::fprintf(stderr, "sightline-stability: without the shaders: %s\n", shaders.error().message.c_str());
    return;
  }
  bench::GlslRays glsl = need(std::move(shaders));
  apps::Progress progress("shaders", cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto answers = need(glsl.trace(cases[i].kind, prepared[i].samples));
    by_case[i].push_back(result_of(cases[i], Path::kGlsl, prepared[i], answers));
    progress.advance(i + 1);
  }
#else
  if (!options.paths.empty()) apps::fail("--path glsl: this build has no GL");
#endif
}

/// Measures the cases that need a whole image, after those of single rays.
void measure_views([[maybe_unused]] const Options& options, [[maybe_unused]] std::vector<Result>& results) {
#if SIGHTLINE_HAS_GL
  std::vector<bench::ViewCase> cases = bench::view_cases(options.seed);
  std::erase_if(cases, [&](const bench::ViewCase& c) {
    return !wanted(options.primitives, core::name_of(c.kind)) || !wanted(options.families, c.family);
  });
  if (cases.empty() || !wanted(options.paths, "glsl")) return;
  auto created = bench::ViewRays::create(options.platform);
  if (!created && options.paths.empty()) return;  // already reported
  bench::ViewRays views = need(std::move(created));
  apps::Progress progress("views", cases.size());
  for (const bench::ViewCase& c : cases) {
    results.push_back({c.kind, c.family, c.name(), c.magnitude, Path::kGlsl, need(views.judge_image(c, options.rays))});
    progress.advance(results.size());
  }
#endif
}

std::vector<Result> measure(const std::vector<Case>& cases, const Options& options) {
  std::vector<Prepared> prepared(cases.size());
  std::vector<std::vector<Result>> by_case(cases.size());
  for_all("cases", cases.size(), [&](std::size_t i) {
    const Case& c = cases[i];
    Prepared& p = prepared[i];
    p.samples = bench::make_samples(c, options.rays, options.seed);
    for (const bench::Sample& sample : p.samples) p.truths.push_back(bench::find_truth(sample));
    if (!wanted(options.paths, bench::path_name(Path::kDouble))) return;
    std::vector<bench::Answer> answers;
    for (const bench::Sample& sample : p.samples) answers.push_back(bench::intersect_on_cpu(sample));
    by_case[i].push_back(result_of(c, Path::kDouble, p, answers));
  });
  if (wanted(options.paths, "glsl")) measure_shaders(cases, prepared, options, by_case);
  std::vector<Result> results;
  for (const std::vector<Result>& some : by_case) results.insert(results.end(), some.begin(), some.end());
  measure_views(options, results);
  return results;
}

// --- reports ---------------------------------------------------------------------------------------------------------

constexpr apps::Column kCaseColumns[] = {{"primitive", "primitive"},
                                         {"case", "case"},
                                         {"path", "path"},
                                         {"rays", "rays", "{:.0f}"},
                                         {"hits", "hits", "{:.0f}"},
                                         {"max t/r", "max_rel_t_error", "{:.1e}"},
                                         {"99.9 %", "p999_rel_t_error", "{:.1e}"},
                                         {"bound", "bound", "{:.1e}"},
                                         {"normal, deg", "max_normal_error_deg", "{:.1e}"},
                                         {"false+", "false_hits", "{:.0f}"},
                                         {"false-", "false_misses", "{:.0f}"},
                                         {"not finite", "not_finite", "{:.0f}"},
                                         {"ties", "in_band", "{:.0f}"},
                                         {"", "verdict"}};
constexpr apps::Column kFuzzColumns[] = {{"primitive", "primitive"},
                                         {"sets", "sets", "{:.0f}"},
                                         {"finite", "finite", "{:.0f}"},
                                         {"hits", "hits", "{:.0f}"},
                                         {"not finite", "not_finite", "{:.0f}"},
                                         {"outside", "outside_bounds", "{:.0f}"},
                                         {"disagree", "disagree", "{:.0f}"},
                                         {"in band", "in_band", "{:.0f}"},
                                         {"thin", "thin", "{:.0f}"},
                                         {"", "verdict"}};
constexpr apps::Column kTraceColumns[] = {{"scenes", "scenes"},
                                          {"rays", "rays", "{:.0f}"},
                                          {"hits", "hits", "{:.0f}"},
                                          {"crossings", "crossings", "{:.0f}"},
                                          {"ties", "ties", "{:.0f}"},
                                          {"grazes", "grazes", "{:.0f}"},
                                          {"worst", "worst", "{:.1e}"},
                                          {"wrong", "wrong", "{:.0f}"},
                                          {"", "verdict"}};

const char* verdict(bool ok) {
  return ok ? "ok" : "FAILS";
}

/// Larger is worse. Failing cases come before all others.
double badness(const Result& r) {
  const bench::CaseErrors& f = r.errors;
  const double t = f.max_t / f.limits.t;
  return f.ok() ? t : 1e6 + t + f.false_hits + f.false_misses;
}

/// The magnitude with the worst result for each family.
std::vector<Result> worst_of_families(const std::vector<Result>& results) {
  std::vector<Result> worst;
  std::map<std::tuple<core::Kind, std::string, Path>, std::size_t> known;
  for (const Result& r : results) {
    const auto [place, fresh] = known.try_emplace({r.kind, r.family, r.path}, worst.size());
    if (fresh) {
      worst.push_back(r);
    } else if (badness(r) > badness(worst[place->second])) {
      worst[place->second] = r;
    }
  }
  return worst;
}

Json to_json(const std::vector<Result>& results) {
  Json cases = Json::array();
  for (const Result& r : results) {
    const bench::CaseErrors& f = r.errors;
    cases.push_back({{"primitive", core::name_of(r.kind)},
                     {"case", r.name},
                     {"path", path_name(r.path)},
                     {"rays", f.rays},
                     {"max_rel_t_error", f.max_t},
                     {"false_hits", f.false_hits},
                     {"false_misses", f.false_misses},
                     {"bound", f.limits.t},
                     {"ok", f.ok()},
                     {"verdict", verdict(f.ok())},
                     {"family", r.family},
                     {"magnitude", r.magnitude},
                     {"hits", f.hits},
                     {"p999_rel_t_error", f.p999_t},
                     {"max_normal_error_deg", f.max_normal * 180.0 / std::numbers::pi},
                     {"not_finite", f.not_finite},
                     {"band", f.limits.band},
                     {"in_band", f.ties},
                     {"wrong_allowed", f.limits.wrong}});
  }
  return cases;
}

/// Error against magnitude: a panel for each family, and a line for each path with the worst of all kinds. Magnitude 0
/// lies a decade before the others.
std::string plot(const std::vector<Result>& results) {
  std::vector<apps::Panel> panels;
  std::map<std::tuple<std::string, std::string, double>, double> worst;  // family, line, magnitude
  std::map<std::string, double> least;
  for (const Result& r : results) {
    if (r.family == "singular") continue;  // there only finiteness is tested
    const double magnitude = std::fabs(r.magnitude);
    const bool wide = r.path == Path::kDouble;
    const auto note = [&](const std::string& line, double value) {
      double& known = worst[{r.family, line, magnitude}];
      known = std::max(known, value);
    };
    note(std::string(path_name(r.path)), r.errors.max_t);
    note(wide ? "bound of double" : "bound of glsl", r.errors.limits.t);
    if (least.try_emplace(r.family, HUGE_VAL).second) panels.push_back({r.family, {}});
    if (magnitude > 0.0) least[r.family] = std::min(least[r.family], magnitude);
  }
  for (apps::Panel& panel : panels) {
    for (const auto& [key, value] : worst) {
      const auto& [family, line, magnitude] = key;
      if (family != panel.title) continue;
      if (panel.series.empty() || panel.series.back().label != line) panel.series.push_back({line, {}});
      panel.series.back().points.push_back({magnitude > 0.0 ? magnitude : 0.1 * least[family], value, {}});
    }
  }
  return apps::svg_panels({.title = "Largest error of all kinds",
                           .x_label = "what the case sweeps",
                           .y_label = "error of t in radii",
                           .panels = std::move(panels),
                           .own_x = true});
}

void print_examples(const std::vector<std::string>& examples, std::FILE* out) {
  for (const std::string& example : examples) std::fprintf(out, "    %s\n", example.c_str());
}

#if SIGHTLINE_HAS_GL
core::Expected<int> run_fuzz(const Options& options) {
  bench::GlslRays shaders = need(bench::GlslRays::create(options.platform));
  Json kinds = Json::array();
  std::vector<std::string> examples;
  bool ok = true;
  for (const core::Kind kind : bench::kSolids) {
    if (!wanted(options.primitives, core::name_of(kind))) continue;
    const bench::FuzzCounts f = need(bench::fuzz(shaders, kind, options.fuzz, options.seed));
    ok = ok && f.ok();
    examples.insert(examples.end(), f.examples.begin(), f.examples.end());
    kinds.push_back({{"primitive", core::name_of(kind)},
                     {"sets", f.sets},
                     {"finite", f.finite},
                     {"hits", f.hits},
                     {"not_finite", f.not_finite},
                     {"outside_bounds", f.outside},
                     {"disagree", f.disagree},
                     {"in_band", f.in_band},
                     {"thin", f.thin},
                     {"band_of_size", bench::kFuzzBand},
                     {"ok", f.ok()},
                     {"verdict", verdict(f.ok())}});
  }
  std::FILE* out = apps::table_stream(options.json);
  apps::print_table(kinds, kFuzzColumns, out);
  print_examples(examples, out);
  need(apps::write_json(options.json, Json{{"fuzz", kinds}}));
  return ok ? apps::kExitOk : apps::kExitFailure;
}
#else
core::Expected<int> run_fuzz(const Options&) {
  return core::fail("--fuzz: this build has no GL");
}
#endif

#if SIGHTLINE_HAS_RAYTRACE
/// Half of the rays in mixed scenes, the others with one kind each. Parts of them on all processors.
core::Expected<int> run_trace(const Options& options) {
  std::vector<bench::TracedKind> kinds;
  for (int i = 0; i < core::kKindCount; ++i)
    if (const auto kind = core::Kind(i); kind != core::Kind::kLine && kind != core::Kind::kFacetGroup) {
      kinds.emplace_back(kind);
      kinds.emplace_back();
    }
  std::erase_if(kinds, [&](const bench::TracedKind& kind) {
    return !wanted(options.primitives, kind ? core::name_of(*kind) : "mixed");
  });
  if (kinds.empty()) return core::fail("nothing to trace: no scenes of that kind");
  constexpr std::int64_t kPart = 10'000;
  const std::int64_t parts = (options.trace + kPart - 1) / kPart;
  std::map<std::string, bench::TracedCounts> counts;
  std::mutex access;
  for_all("rays", std::size_t(parts), [&](std::size_t part) {
    const bench::TracedKind kind = kinds[part % kinds.size()];
    const std::int64_t rays = std::min(kPart, options.trace - std::int64_t(part) * kPart);
    const auto found = bench::trace_rays(kind, rays, options.seed + part);
    const std::lock_guard lock(access);
    counts[kind ? std::string(core::name_of(*kind)) : "mixed"].add(found);
  });
  Json rows = Json::array();
  const auto add = [&](const std::string& scenes, const bench::TracedCounts& f) {
    rows.push_back({{"scenes", scenes},
                    {"rays", f.rays},
                    {"hits", f.hits},
                    {"crossings", f.crossings},
                    {"ties", f.ties},
                    {"grazes", f.grazes},
                    {"worst", f.worst},
                    {"wrong", f.wrong},
                    {"verdict", verdict(f.ok())}});
  };
  bench::TracedCounts all;
  for (const auto& [scenes, found] : counts) add(scenes, found), all.add(found);
  add("all", all);
  std::FILE* out = apps::table_stream(options.json);
  apps::print_table(rows, kTraceColumns, out);
  print_examples(all.examples, out);
  need(apps::write_json(options.json, Json{{"trace", rows}}));
  return all.ok() ? apps::kExitOk : apps::kExitFailure;
}
#else
core::Expected<int> run_trace(const Options&) {
  return core::fail("--trace: this build has no ray tracer");
}
#endif

core::Expected<int> run(const Options& options) {
  if (options.fuzz > 0) return run_fuzz(options);
  if (options.trace > 0) return run_trace(options);
  std::vector<Case> cases;
  for (Case& c : bench::stability_cases())
    if (wanted(options.primitives, core::name_of(c.kind)) && wanted(options.families, c.family))
      cases.push_back(std::move(c));
  const std::vector<Result> results = measure(cases, options);
  if (results.empty()) return core::fail("nothing to measure: no case of that kind, family and path");
  const auto failed = std::ranges::count_if(results, [](const Result& r) { return !r.errors.ok(); });
  std::FILE* out = apps::table_stream(options.json);
  apps::print_table(to_json(options.details ? results : worst_of_families(results)), kCaseColumns, out);
  std::fprintf(out, "%zu cases, %zu past a bound\n", results.size(), std::size_t(failed));
  need(apps::write_json(options.json, Json{{"cases", to_json(results)}}));
  if (!options.plot.empty()) need(apps::write_text(options.plot, plot(results)));
  return failed == 0 ? apps::kExitOk : apps::kExitFailure;
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("How stable the intersections with analytic primitives are in stiff and extreme cases",
                         "sightline-stability",
                         "  sightline-stability --plot stability.svg\n"
                         "  sightline-stability --primitive cylinder --case slenderness --details\n"
                         "  sightline-stability --fuzz 1000000 --primitive snout\n"
                         "  sightline-stability --trace 1000000 --seed 101\n"
                         "  sightline-stability --path double --rays 100000 --json results.json");
  Options options;
  add_options(line, options);
  return line.run(argc, argv, [&] { return run(options); });
}
