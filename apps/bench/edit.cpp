// sightline-bench edit: the cost of edits, and their effect on culling speed until a new scene version lands.
//
// Uses a plant of cylinders and boxes. For each kind of edit, every commit edits a share of all items. Measures the
// parts of the commit (validation by the scene, snapshot, culler), and culling along a path before, after, and in the
// new order that the engine would land. Then edits and culls frame by frame with an engine while its rebuild runs.
// Last the same boxes in a BoxCuller: updates one by one and in batches, refit and a new culler, and culling after
// each. By itself: what portions of commits take of the calling thread's time (portions.h).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/models/plant_boxes.h"
#include "sightline/apps/bench/portions.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/core/internal/snapshot_copies.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/box_culler.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/engine/engine.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench::edit_bench {
namespace {

using core::ItemId;
using core::Snapshot;
using Json = json::Value;

constexpr std::size_t kItemsPerNode = 25;  // about a pipe run
constexpr int kPathPasses = 7;

struct Options {
  std::size_t items = 1'000'000;
  double share = 0.01;
  int commits = 5;
  std::string subject = "all", views, json;
};

enum class Edit { kMoveNear, kMoveFar, kInsert, kRemove, kHide, kShow };
constexpr std::pair<Edit, const char*> kEdits[] = {{Edit::kMoveNear, "move 1 m"}, {Edit::kMoveFar, "move far"},
                                                   {Edit::kInsert, "insert"},     {Edit::kRemove, "remove"},
                                                   {Edit::kHide, "hide"},         {Edit::kShow, "show"}};

// --- the plant -------------------------------------------------------------------------------------------------------

struct Plant {
  explicit Plant(std::size_t count) : boxes(PlantBoxes(1).make(count)) {
    core::NodeId node;
    for (std::size_t i = 0; i < count; ++i) {
      if (i % kItemsPerNode == 0) node = scene.add_node(scene.root());
      add(node, boxes[i], {});
    }
  }

  /// Adds a box, or the cylinder that fits it.
  void add(core::NodeId node, const core::Aabb& box, const core::dvec3& offset) {
    const core::dvec3 low(box.min), high(box.max), size = high - low;
    const core::Affine at = core::translation(0.5 * (low + high) + offset);
    const core::Affine stretched{core::dmat3(size.x, 0, 0, 0, size.y, 0, 0, 0, size.z), at.origin};
    if (scene.item_slots() % 2 == 0)
      scene.add_primitive(node, core::Box{float(size.x), float(size.y), float(size.z)}, at);
    else
      scene.add_primitive(node, core::Cylinder{0.5f, 1.0f}, stretched);
  }

  core::Scene scene;
  std::vector<core::Aabb> boxes;
};

/// Edits `count` random items, each once per commit.
class Editor {
 public:
  Editor(Plant& plant, std::uint64_t seed) : plant_(plant), random_(seed) {}

  void edit(Edit kind, std::size_t count) {
    core::Scene& scene = plant_.scene;
    for (std::size_t i = 0; i < count; ++i) {
      const ItemId item = pick(kind == Edit::kShow);
      const core::dvec3 far(spread(0, 400), spread(0, 100), spread(0, 60));
      switch (kind) {
        case Edit::kMoveNear:
          move(item, scene.placement(item).origin + core::dvec3(spread(-1, 1), spread(-1, 1), spread(-1, 1)));
          break;
        case Edit::kMoveFar:
          move(item, far);
          break;
        case Edit::kInsert: {
          const core::Aabb& box = plant_.boxes[random_() % plant_.boxes.size()];
          plant_.add(scene.node_of(item), box, {spread(-1, 1), spread(-1, 1), spread(-1, 1)});
          break;
        }
        case Edit::kRemove:
          scene.remove_item(item);
          break;
        case Edit::kHide:
          scene.set_visible(item, false);
          break;
        case Edit::kShow:
          scene.set_visible(item, true);
          break;
      }
    }
  }

 private:
  ItemId pick(bool hidden) {
    for (;;) {
      const ItemId item = ItemId(random_() % plant_.scene.item_slots());
      if (plant_.scene.contains_item(item) && plant_.scene.item_visible(item) != hidden) return item;
    }
  }
  double spread(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  void move(ItemId item, const core::dvec3& to) {
    core::Affine placement = plant_.scene.placement(item);
    placement.origin = to;
    plant_.scene.set_placement(item, placement);
  }

  Plant& plant_;
  std::mt19937_64 random_;
};

/// One turn around and through the plant, at walking distance.
std::vector<core::View> orbit() {
  std::vector<core::View> views;
  constexpr int kFrames = 500;
  for (int i = 0; i < kFrames; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kFrames, near = 0.5 + 0.5 * std::cos(3.0 * turn);
    const core::dvec3 target(200 + 150 * std::cos(2.0 * turn), 50, 20);
    const core::dvec3 eye = target + core::dvec3(std::cos(turn), std::sin(turn), 0.3) * (20.0 + 300.0 * near);
    views.push_back(*core::View::perspective({eye, target, {0, 0, 1}}, 0.9, 16.0 / 9.0, 0.1));
  }
  return views;
}

// --- one kind of edit ------------------------------------------------------------------------------------------------

struct Subject {
  explicit Subject(Snapshot s) : snapshot(std::move(s)), culler(snapshot.bounds()) {}
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;
  Snapshot snapshot;
  culling::CpuCuller culler;
};

struct Path {
  double mean_ms = 0.0, mean_visible = 0.0;
};

/// Times the paths in turns, so that other load of the machine affects all equally. Returns medians over the passes of
/// the means along the path.
std::vector<Path> time_paths(const std::vector<const Subject*>& subjects, const std::vector<core::View>& views) {
  std::vector<std::vector<double>> times(subjects.size());
  std::vector<Path> paths(subjects.size());
  core::VisibleSet set;
  for (int pass = -1; pass < kPathPasses; ++pass) {
    for (std::size_t i = 0; i < subjects.size(); ++i) {
      const double start = milliseconds();
      for (const core::View& view : views) subjects[i]->culler.cull(view, set);
      if (pass >= 0) times[i].push_back((milliseconds() - start) / double(views.size()));
    }
  }
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    paths[i].mean_ms = apps::median(times[i]);
    for (const core::View& view : views) {
      subjects[i]->culler.cull(view, set);
      paths[i].mean_visible += double(subjects[i]->snapshot.count(set)) / double(views.size());
    }
  }
  return paths;
}

Snapshot in_new_order(const Snapshot& snapshot) {
  core::ItemCopies items;
  core::copy_items(snapshot, 0, core::Slot(snapshot.size()), items);
  return core::reordered(snapshot, std::move(items));
}

core::Expected<Json> measure(Edit kind, const char* name, const Options& options,
                             const std::vector<core::View>& views) {
  Plant plant(options.items);
  Editor editor(plant, 1);
  const std::size_t count = std::max<std::size_t>(1, std::size_t(double(options.items) * options.share));
  if (kind == Edit::kShow) editor.edit(Edit::kHide, count * std::size_t(options.commits) * 2);
  if (auto delta = plant.scene.commit(); !delta) return tl::unexpected(delta.error());
  const Subject before{Snapshot(plant.scene)};
  Subject edited{Snapshot(plant.scene)};

  std::vector<double> scene_ms, snapshot_ms, culler_ms, total_ms;
  Json first;
  for (int commit = 0; commit < options.commits; ++commit) {
    editor.edit(kind, count);
    const double start = milliseconds();
    const auto delta = plant.scene.commit();
    if (!delta) return tl::unexpected(delta.error());
    const double validated = milliseconds();
    const std::vector<core::Slot> touched = edited.snapshot.apply(*delta);
    const double applied = milliseconds();
    edited.culler.update(touched);
    const double end = milliseconds();
    scene_ms.push_back(validated - start);
    snapshot_ms.push_back(applied - validated);
    culler_ms.push_back(end - applied);
    total_ms.push_back(end - start);
    if (commit > 0 && commit + 1 < options.commits) continue;
    const Subject landed(in_new_order(edited.snapshot));
    const std::vector<Path> paths = time_paths({&before, &edited, &landed}, views);
    Json culling{{"commits", commit + 1},
                 {"before_ms", paths[0].mean_ms},
                 {"after_ms", paths[1].mean_ms},
                 {"landed_ms", paths[2].mean_ms},
                 {"after_over_before", paths[1].mean_ms / paths[0].mean_ms},
                 {"after_over_landed", paths[1].mean_ms / paths[2].mean_ms},
                 {"visible_before", paths[0].mean_visible},
                 {"visible_after", paths[1].mean_visible},
                 {"visible_landed", paths[2].mean_visible},
                 {"slots", edited.snapshot.size()},
                 {"disorder", edited.snapshot.disorder()}};
    if (commit == 0) first = culling;
    if (commit + 1 < options.commits) continue;
    return Json{{"edit", name},
                {"items_per_commit", count},
                {"commit_ms", apps::median(total_ms)},
                {"commit_ms_worst", *std::max_element(total_ms.begin(), total_ms.end())},
                {"scene_ms", apps::median(scene_ms)},
                {"snapshot_ms", apps::median(snapshot_ms)},
                {"culler_ms", apps::median(culler_ms)},
                {"culling_after_one", first},
                {"culling_after_all", culling}};
  }
  return core::fail("no commits");
}

// --- frames while the engine rebuilds --------------------------------------------------------------------------------

core::Expected<Json> measure_rebuild(const Options& options, const std::vector<core::View>& views) {
  Plant plant(options.items);
  Editor editor(plant, 2);
  const std::size_t count = std::max<std::size_t>(1, std::size_t(double(options.items) * options.share));
  auto engine = engine::Engine::create(plant.scene);
  if (!engine) return tl::unexpected(engine.error());
  struct Longest {
    double frame = 0.0, commit = 0.0;
    int frames = 0;
  } quiet, busy;
  std::size_t at = 0;
  double started = 0.0, duration = 0.0;
  for (int round = 0; duration == 0.0 && round < 100'000; ++round) {
    const bool was = engine->rebuilding();
    Longest& longest = was ? busy : quiet;
    // While the rebuild runs, a tenth of a share is edited per frame, as an application that plays a motion would do.
    editor.edit(Edit::kMoveFar, std::max<std::size_t>(1, was ? count / 10 : count));
    const std::uint64_t generation = engine->snapshot().generation();
    const double start = milliseconds();
    if (auto done = engine->commit(); !done) return tl::unexpected(done.error());
    const double committed = milliseconds();
    if (auto frame = engine->frame(views[at++ % views.size()]); !frame) return tl::unexpected(frame.error());
    const double end = milliseconds();
    if (round > 0) {
      longest.commit = std::max(longest.commit, committed - start);
      longest.frame = std::max(longest.frame, end - committed);
      ++longest.frames;
    }
    if (!was && engine->rebuilding()) started = end;
    if (engine->snapshot().generation() != generation) duration = end - started;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // stands for the rest of an application's frame
  }
  return Json{{"rebuild_ms", duration},
              {"frames_meanwhile", busy.frames},
              {"longest_frame_ms", busy.frame},
              {"longest_commit_ms", busy.commit},
              {"items_per_commit_meanwhile", count / 10},
              {"longest_frame_ms_before", quiet.frame},
              {"longest_commit_ms_before", quiet.commit}};
}

// --- boxes without a scene -------------------------------------------------------------------------------------------

/// Changes of random boxes of a BoxCuller, which move by up to `reach` along each axis.
class BoxMover {
 public:
  BoxMover(std::vector<core::AabbD>& boxes, const core::dvec3& reach) : boxes_(boxes), reach_(reach) {}

  /// Draws a batch of `count` boxes, with their moves in boxes_ and in `moved`.
  void draw(std::size_t count) {
    indices.clear(), moved.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const auto index = std::uint32_t(random_() % boxes_.size());
      move(boxes_[index]);
      indices.push_back(index);
      moved.push_back(boxes_[index]);
    }
  }
  void move_all() {
    for (core::AabbD& box : boxes_) move(box);
  }

  std::vector<std::uint32_t> indices;
  std::vector<core::AabbD> moved;

 private:
  void move(core::AabbD& box) {
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    const core::dvec3 by = reach_ * core::dvec3(share(random_), share(random_), share(random_));
    box.min += by, box.max += by;
  }

  std::vector<core::AabbD>& boxes_;
  core::dvec3 reach_;
  std::mt19937_64 random_{3};
};

/// Milliseconds per view: the median over the passes of the means along the path.
double path_ms(const culling::BoxCuller& culler, const std::vector<core::View>& views) {
  std::vector<double> times;
  std::vector<std::uint32_t> visible;
  for (int pass = -1; pass < kPathPasses; ++pass) {
    const double start = milliseconds();
    for (const core::View& view : views) culler.visible(view, visible);
    if (pass >= 0) times.push_back((milliseconds() - start) / double(views.size()));
  }
  return apps::median(times);
}

/// Microseconds per box of `count` boxes, the median of the commits.
template <class Change>
double per_box_us(int commits, std::size_t count, const Change& change) {
  std::vector<double> times;
  for (int i = 0; i < commits; ++i) times.push_back(1e3 * change() / double(count));
  return apps::median(times);
}

core::Expected<Json> measure_boxes(const char* name, const core::dvec3& reach, const Options& options,
                                   const std::vector<core::View>& views) {
  constexpr std::size_t kSingles = 1000;
  std::vector<core::AabbD> boxes;
  for (const core::Aabb& box : PlantBoxes(1).make(options.items))
    boxes.push_back({core::dvec3(box.min), core::dvec3(box.max)});
  const std::size_t count = std::max<std::size_t>(1, std::size_t(double(options.items) * options.share));
  auto culler = culling::BoxCuller::create(boxes);
  if (!culler) return tl::unexpected(culler.error());
  BoxMover mover(boxes, reach);
  bool good = true;
  Json figures{{"move", name}, {"boxes_per_batch", count}, {"before_ms", path_ms(*culler, views)}};
  figures["single_us"] = per_box_us(options.commits, kSingles, [&] {
    mover.draw(kSingles);
    const double start = milliseconds();
    for (std::size_t i = 0; i < kSingles; ++i) good &= culler->update(mover.indices[i], mover.moved[i]).has_value();
    return milliseconds() - start;
  });
  figures["batch_us"] = per_box_us(options.commits, count, [&] {
    mover.draw(count);
    const double start = milliseconds();
    good &= culler->update(mover.indices, mover.moved).has_value();
    return milliseconds() - start;
  });
  figures["after_batches_ms"] = path_ms(*culler, views);
  figures["refit_us"] = per_box_us(options.commits, boxes.size(), [&] {
    mover.move_all();
    const double start = milliseconds();
    good &= culler->refit(boxes).has_value();
    return milliseconds() - start;
  });
  figures["after_refits_ms"] = path_ms(*culler, views);
  figures["create_us"] = per_box_us(1, boxes.size(), [&] {
    const double start = milliseconds();
    culler = culling::BoxCuller::create(boxes);
    return milliseconds() - start;
  });
  if (!good || !culler) return core::fail("a box was refused");
  figures["anew_ms"] = path_ms(*culler, views);
  return figures;
}

void print_boxes(const Json& json, std::FILE* out) {
  std::fprintf(out, "BoxCuller, us a box; culling in ms per view, with the list of indices\n");
  std::fprintf(out, "%-9s single   batch   refit     new | cull before, after batches, refits, anew\n", "");
  for (const Json& b : json["boxes"])
    std::fprintf(out, "%-9s %6.3f  %6.3f  %6.4f  %6.4f |      %6.3f         %6.3f  %6.3f  %6.3f\n",
                 b["move"].get<std::string>().c_str(), b["single_us"].get<double>(), b["batch_us"].get<double>(),
                 b["refit_us"].get<double>(), b["create_us"].get<double>(), b["before_ms"].get<double>(),
                 b["after_batches_ms"].get<double>(), b["after_refits_ms"].get<double>(), b["anew_ms"].get<double>());
}

void print_scenes(const Json& json, std::FILE* out) {
  std::fprintf(out, "%zu items, %zu edited per commit; culling in ms per view, mean over %zu views\n",
               json["items"].get<std::size_t>(), json["edits"][0]["items_per_commit"].get<std::size_t>(),
               json["views"].get<std::size_t>());
  std::fprintf(out, "%-9s %6s = scene + snapshot + culler | cull before   after  ratio  landed | after %d: ratio\n",
               "edit", "commit", json["commits"].get<int>());
  for (const Json& e : json["edits"]) {
    const Json &one = e["culling_after_one"], &all = e["culling_after_all"];
    std::fprintf(out, "%-9s %6.2f  %6.2f  %9.2f  %7.2f |      %7.4f %7.4f %6.2f %7.4f |    %10.2f\n",
                 e["edit"].get<std::string>().c_str(), e["commit_ms"].get<double>(), e["scene_ms"].get<double>(),
                 e["snapshot_ms"].get<double>(), e["culler_ms"].get<double>(), one["before_ms"].get<double>(),
                 one["after_ms"].get<double>(), one["after_over_landed"].get<double>(), one["landed_ms"].get<double>(),
                 all["after_over_landed"].get<double>());
  }
  const Json& r = json["rebuild"];
  std::fprintf(
      out, "rebuild in the background: %.0f ms, %d frames meanwhile, longest frame %.3f ms, longest commit %.2f ms\n",
      r["rebuild_ms"].get<double>(), r["frames_meanwhile"].get<int>(), r["longest_frame_ms"].get<double>(),
      r["longest_commit_ms"].get<double>());
}

void print_portions(const Json& json, std::FILE* out) {
  std::fprintf(out,
               "portions of 4 ms in a drawn scene, ms of the calling thread\n%-32s portions longest |  frame longest\n",
               "");
  for (const Json& p : json["portions"])
    std::fprintf(out, "%-32s %8d %7.1f | %6.1f %7.1f\n", p["what"].get<std::string>().c_str(), p["portions"].get<int>(),
                 p.contains("portion_ms_longest") ? p["portion_ms_longest"].get<double>() : 0.0,
                 p["frame_ms"].get<double>(), p["frame_ms_longest"].get<double>());
}

void print_table(const Json& json, std::FILE* out) {
  if (json.contains("portions")) print_portions(json, out);
  if (json.contains("edits")) print_scenes(json, out);
  if (json.contains("boxes")) print_boxes(json, out);
}

core::Expected<void> measure_scenes(const Options& options, const std::vector<core::View>& views, Json& json) {
  for (const auto& [kind, name] : kEdits) {
    auto figures = measure(kind, name, options, views);
    if (!figures) return tl::unexpected(figures.error());
    json["edits"].push_back(std::move(*figures));
  }
  auto rebuild = measure_rebuild(options, views);
  if (!rebuild) return tl::unexpected(rebuild.error());
  json["rebuild"] = std::move(*rebuild);
  return {};
}

core::Expected<int> run(const Options& options) {
  auto views = options.views.empty() ? core::Expected<std::vector<core::View>>(orbit()) : read_views(options.views);
  if (!views) return tl::unexpected(views.error());
  if (views->empty()) return core::fail(options.views + ": no views");
  Json json{{"items", options.items}, {"commits", options.commits}, {"views", views->size()}};
  if (options.subject == "portions") {
    auto figures = measure_portions(options.items);
    if (!figures) return tl::unexpected(figures.error());
    json["portions"] = std::move(*figures);
    return finish(options.json, json, print_table);
  }
  if (options.subject != "boxes")
    if (auto done = measure_scenes(options, *views, json); !done) return tl::unexpected(done.error());
  if (options.subject != "scenes") {
    for (const auto& [name, reach] :
         {std::pair("move 1 m", core::dvec3(1.0)), {"move far", core::dvec3(200, 50, 30)}}) {
      auto figures = measure_boxes(name, reach, options, *views);
      if (!figures) return tl::unexpected(figures.error());
      json["boxes"].push_back(std::move(*figures));
    }
  }
  return finish(options.json, json, print_table);
}

void add_options(apps::CommandLine& line, Options& options) {
  line.add("--items", options.items, "items of a made-up plant of 400 x 100 x 60 m")
      .in_range(100, 20'000'000)
      .shows_default();
  line.add("--share", options.share, "of the items, edited per commit").in_range(1e-6, 0.1).shows_default();
  line.add("--subject", options.subject,
           "what is edited: scenes, the boxes of a BoxCuller, first one, then the other, or a drawn scene in portions")
      .one_of({"all", "scenes", "boxes", "portions"})
      .shows_default();
  line.add("--commits", options.commits, "of each kind of edit, one after the other").in_range(1, 9).shows_default();
  add_views_option(line, options.views);
  apps::add_json_option(line, options.json);
  line.examples("  sightline-bench edit --items 1000000 --share 0.01 --views views.f64 --json -");
}

}  // namespace
}  // namespace sightline::bench::edit_bench

sightline::bench::Run sightline::bench::add_edit(apps::CommandLine& line) {
  using namespace edit_bench;
  return add_subcommand<Options>(line, add_options, run);
}
