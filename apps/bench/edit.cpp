// sightline-bench edit: the cost of edits, and their effect on culling speed until a new scene version is drawn.
//
// Uses a plant of cylinders and boxes. For each kind of edit, every commit edits a share of all items. Measures the
// parts of the commit (validation by the scene, snapshot, culler), and culling along a path before, after, and in the
// order of the scene version that the engine would draw next. Then edits and culls frame by frame with an engine while
// its rebuild runs. Last the same boxes in a BoxCuller: updates one by one and in batches, refit and a new culler, and
// culling after each. By itself: what portions of commits take of the calling thread's time (portions.h).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/bench/models/plant_boxes.h"
#include "sightline/apps/bench/portions.h"
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/table.h"
#include "sightline/core/internal/snapshot_copies.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/box_culler.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/engine/engine.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench::edit_bench {
namespace {

using apps::need;
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

/// Milliseconds per view of each subject: the median over the passes of the means along the path. All subjects take
/// turns, so that other load of the machine affects all equally.
std::vector<double> time_paths(std::size_t subjects, const std::vector<core::View>& views,
                               const std::function<void(std::size_t subject, const core::View& view)>& cull) {
  std::vector<std::vector<double>> times(subjects);
  for (int pass = -1; pass < kPathPasses; ++pass)
    for (std::size_t i = 0; i < subjects; ++i) {
      const double start = milliseconds();
      for (const core::View& view : views) cull(i, view);
      if (pass >= 0) times[i].push_back((milliseconds() - start) / double(views.size()));
    }
  std::vector<double> means;
  for (auto& of_one : times) means.push_back(apps::median(std::move(of_one)));
  return means;
}

struct Subject {
  explicit Subject(Snapshot s) : snapshot(std::move(s)), culler(snapshot.bounds()) {}
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;
  Snapshot snapshot;
  culling::CpuCuller culler;
};

Snapshot in_new_order(const Snapshot& snapshot) {
  core::ItemCopies items;
  core::copy_items(snapshot, 0, core::Slot(snapshot.size()), items);
  return core::reordered(snapshot, std::move(items));
}

/// Culling along the path before the edits, after them, and in the new order.
Json compare_culling(const Subject& before, const Subject& edited, const std::vector<core::View>& views) {
  const Subject reordered(in_new_order(edited.snapshot));
  const Subject* subjects[] = {&before, &edited, &reordered};
  core::VisibleSet set;
  const std::vector<double> ms =
      time_paths(3, views, [&](std::size_t i, const core::View& view) { subjects[i]->culler.cull(view, set); });
  return {{"before_ms", ms[0]},
          {"after_ms", ms[1]},
          {"reordered_ms", ms[2]},
          {"after_over_reordered", ms[1] / ms[2]},
          {"disorder", edited.snapshot.disorder()}};
}

std::size_t share_of(const Options& options) {
  return std::max<std::size_t>(1, std::size_t(double(options.items) * options.share));
}

Json measure(Edit kind, const char* name, const Options& options, const std::vector<core::View>& views) {
  Plant plant(options.items);
  Editor editor(plant, 1);
  const std::size_t count = share_of(options);
  if (kind == Edit::kShow) editor.edit(Edit::kHide, count * std::size_t(options.commits) * 2);
  need(plant.scene.commit());
  const Subject before{Snapshot(plant.scene)};
  Subject edited{Snapshot(plant.scene)};
  std::vector<double> scene_ms, snapshot_ms, culler_ms, total_ms;
  Json row{{"edit", name}, {"items_per_commit", count}};
  for (int commit = 0; commit < options.commits; ++commit) {
    editor.edit(kind, count);
    const double start = milliseconds();
    const auto delta = need(plant.scene.commit());
    const double validated = milliseconds();
    const std::vector<core::Slot> touched = edited.snapshot.apply(delta);
    const double applied = milliseconds();
    edited.culler.update(touched);
    const double end = milliseconds();
    scene_ms.push_back(validated - start);
    snapshot_ms.push_back(applied - validated);
    culler_ms.push_back(end - applied);
    total_ms.push_back(end - start);
    if (commit == 0) row["after_one"] = compare_culling(before, edited, views);
  }
  row["after_all"] = compare_culling(before, edited, views);
  row.update({{"commit_ms", apps::median(total_ms)},
              {"commit_ms_worst", *std::ranges::max_element(total_ms)},
              {"scene_ms", apps::median(scene_ms)},
              {"snapshot_ms", apps::median(snapshot_ms)},
              {"culler_ms", apps::median(culler_ms)}});
  return row;
}

// --- frames while the engine rebuilds --------------------------------------------------------------------------------

Json measure_rebuild(const Options& options, const std::vector<core::View>& views) {
  Plant plant(options.items);
  Editor editor(plant, 2);
  const std::size_t count = share_of(options);
  auto engine = need(engine::Engine::create(plant.scene));
  double longest_frame = 0.0, longest_commit = 0.0, started = 0.0, duration = 0.0;
  int frames = 0;
  for (int round = 0; duration == 0.0 && round < 100'000; ++round) {
    const bool was = engine.rebuilding();
    // While the rebuild runs, a tenth of a share is edited per frame, as an application that plays a motion would do.
    editor.edit(Edit::kMoveFar, std::max<std::size_t>(1, was ? count / 10 : count));
    const std::uint64_t generation = engine.snapshot().generation();
    const double start = milliseconds();
    need(engine.commit());
    const double committed = milliseconds();
    need(engine.frame(views[std::size_t(round) % views.size()]));
    const double end = milliseconds();
    if (was) {
      longest_commit = std::max(longest_commit, committed - start);
      longest_frame = std::max(longest_frame, end - committed);
      ++frames;
    } else if (engine.rebuilding()) {
      started = end;
    }
    if (engine.snapshot().generation() != generation) duration = end - started;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // stands for the rest of an application's frame
  }
  return {{"rebuild_ms", duration},
          {"frames_meanwhile", frames},
          {"longest_frame_ms", longest_frame},
          {"longest_commit_ms", longest_commit},
          {"items_per_commit_meanwhile", count / 10}};
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

Json measure_boxes(const char* name, const core::dvec3& reach, const Options& options,
                   const std::vector<core::View>& views) {
  constexpr std::size_t kSingles = 1000;
  std::vector<core::AabbD> boxes;
  for (const core::Aabb& box : PlantBoxes(1).make(options.items))
    boxes.push_back({core::dvec3(box.min), core::dvec3(box.max)});
  const std::size_t count = share_of(options);
  auto culler = need(culling::BoxCuller::create(boxes));
  BoxMover mover(boxes, reach);
  Json row{{"move", name}, {"boxes_per_batch", count}};
  // Milliseconds per view, with the list of indices.
  const auto add_culling = [&](const char* when) {
    std::vector<std::uint32_t> visible;
    row[when] =
        time_paths(1, views, [&](std::size_t, const core::View& view) { culler.visible(view, visible); }).front();
  };
  // Microseconds per box: the median of the changes. `prepare` is not timed.
  const auto add_change = [&](const char* change, std::size_t changed, const auto& prepare, const auto& run) {
    std::vector<double> times;
    for (int i = 0; i < options.commits; ++i) {
      prepare();
      const double start = milliseconds();
      run();
      times.push_back(1e3 * (milliseconds() - start) / double(changed));
    }
    row[change] = apps::median(times);
  };
  add_culling("before_ms");
  add_change(
      "single_us", kSingles, [&] { mover.draw(kSingles); },
      [&] {
        for (std::size_t i = 0; i < kSingles; ++i) need(culler.update(mover.indices[i], mover.moved[i]));
      });
  add_change(
      "batch_us", count, [&] { mover.draw(count); }, [&] { need(culler.update(mover.indices, mover.moved)); });
  add_culling("after_batches_ms");
  add_change(
      "refit_us", boxes.size(), [&] { mover.move_all(); }, [&] { need(culler.refit(boxes)); });
  add_culling("after_refits_ms");
  add_change(
      "create_us", boxes.size(), [] {}, [&] { culler = need(culling::BoxCuller::create(boxes)); });
  add_culling("anew_ms");
  return row;
}

// --- output ----------------------------------------------------------------------------------------------------------

constexpr apps::Column kEditColumns[] = {{"edit", "edit"},
                                         {"commit ms", "commit_ms", "{:.2f}"},
                                         {"scene", "scene_ms", "{:.2f}"},
                                         {"snapshot", "snapshot_ms", "{:.2f}"},
                                         {"culler", "culler_ms", "{:.2f}"},
                                         {"cull ms before", "after_one/before_ms", "{:.4f}"},
                                         {"after one", "after_one/after_ms", "{:.4f}"},
                                         {"in a new order", "after_one/reordered_ms", "{:.4f}"},
                                         {"ratio", "after_one/after_over_reordered", "{:.2f}"},
                                         {"ratio after all", "after_all/after_over_reordered", "{:.2f}"}};
constexpr apps::Column kBoxColumns[] = {{"us a box of a BoxCuller", "move"},
                                        {"single", "single_us", "{:.3f}"},
                                        {"batch", "batch_us", "{:.3f}"},
                                        {"refit", "refit_us", "{:.4f}"},
                                        {"new", "create_us", "{:.4f}"},
                                        {"cull ms before", "before_ms", "{:.3f}"},
                                        {"after batches", "after_batches_ms", "{:.3f}"},
                                        {"after refits", "after_refits_ms", "{:.3f}"},
                                        {"anew", "anew_ms", "{:.3f}"}};
constexpr apps::Column kPortionColumns[] = {{"portions of 4 ms in a drawn scene", "what"},
                                            {"portions", "portions", "{:.0f}"},
                                            {"longest, ms of the thread", "portion_ms_longest", "{:.1f}"},
                                            {"frame", "frame_ms", "{:.1f}"},
                                            {"longest", "frame_ms_longest", "{:.1f}"}};

void print_tables(const Json& json, std::FILE* out) {
  if (json.contains("portions")) apps::print_table(json["portions"], kPortionColumns, out);
  if (json.contains("edits")) {
    apps::print_table(json["edits"], kEditColumns, out);
    const Json& r = json["rebuild"];
    std::fprintf(
        out, "rebuild in the background: %.0f ms, %d frames meanwhile, longest frame %.3f ms, longest commit %.2f ms\n",
        r["rebuild_ms"].get<double>(), r["frames_meanwhile"].get<int>(), r["longest_frame_ms"].get<double>(),
        r["longest_commit_ms"].get<double>());
  }
  if (json.contains("boxes")) apps::print_table(json["boxes"], kBoxColumns, out);
}

core::Expected<int> run(const Options& options) {
  const auto views = options.views.empty() ? orbit() : need(read_views(options.views));
  if (views.empty()) apps::fail(options.views + ": no views");
  Json json{{"items", options.items}, {"commits", options.commits}, {"views", views.size()}};
  const std::string& subject = options.subject;
  if (subject == "portions") json["portions"] = measure_portions(options.items);
  if (subject == "all" || subject == "scenes") {
    for (const auto& [kind, name] : kEdits) json["edits"].push_back(measure(kind, name, options, views));
    json["rebuild"] = measure_rebuild(options, views);
  }
  if (subject == "all" || subject == "boxes")
    for (const auto& [name, reach] : {std::pair("move 1 m", core::dvec3(1.0)), {"move far", core::dvec3(200, 50, 30)}})
      json["boxes"].push_back(measure_boxes(name, reach, options, views));
  return finish(options.json, json, print_tables);
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
