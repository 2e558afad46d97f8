// sightline-study capi: what calls cost through the C API beside the same calls in C++.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/culling/box_culler.h"
#include "sightline/engine/engine.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/sightline.h"
#include "sightline/study/parts/parts.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/engine/pick.h"
#endif

namespace sightline::bench::capi_bench {
namespace {

using Json = json::Value;

struct Options {
  int rounds = 25;
  std::string json;
};

/// n^3 boxes of half a metre, one metre apart.
core::AabbD box_at(int i, int n) {
  const core::dvec3 at(i % n, i / n % n, i / n / n);
  return {at, at + 0.5};
}

/// One scene in both APIs, with an engine each.
class Twins {
 public:
  explicit Twins(int n) {
    require(sl_scene_create(&c_scene));
    sl_scene_info info = SL_SCENE_INFO_INIT;
    require(sl_scene_get(c_scene, &info));
    c_root = info.root;
    sl_primitive box = {SL_BOX, {{0.5f, 0.5f, 0.5f}}};
    double placement[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    for (int i = 0; i < n * n * n; ++i) {
      const core::dvec3 centre = box_at(i, n).centre();
      std::copy_n(glm::value_ptr(centre), 3, placement + 12);
      sl_item item = SL_NO_ITEM;
      require(sl_item_add_primitive(c_scene, c_root, &box, placement, {0}, &item));
      scene.add_primitive(scene.root(), core::Box{0.5f, 0.5f, 0.5f}, core::translation(centre));
    }
    require(sl_engine_create(c_scene, nullptr, &c_engine));
    auto made = engine::Engine::create(scene);
    if (made) engine.emplace(std::move(*made));
    const core::dvec3 middle(0.5 * n);
    const core::Pose pose{middle - core::dvec3(0.3 * n, 0.4 * n, 0.0), middle, {0, 0, 1}};
    view = *core::View::perspective(pose, 0.6, 1280.0 / 720.0, 0.1);
    require(sl_view_from_matrices(glm::value_ptr(view->eye_from_world()), glm::value_ptr(view->clip_from_eye()),
                                  SL_DEPTH_REVERSED_ZERO_TO_ONE, &c_view));
  }
  ~Twins() {
    (void)sl_engine_destroy(c_engine);
    (void)sl_scene_destroy(c_scene);
  }
  Twins(const Twins&) = delete;
  Twins& operator=(const Twins&) = delete;

  void require(sl_status status) { good = good && status == SL_OK; }

  sl_scene c_scene = {0};
  sl_node c_root = {0};
  sl_engine c_engine = {0};
  sl_view c_view = SL_VIEW_INIT;
  core::Scene scene;
  std::optional<engine::Engine> engine;
  std::optional<core::View> view;
  bool good = true;  ///< no call of the C API has failed
};

class Measurement {
 public:
  Measurement(const Options& options, Json& rows) : rounds_(options.rounds), rows_(&rows) {}

  /// Both loops make `calls` calls. They take turns, and the least time of each counts: what else the machine does
  /// only adds to it.
  template <class Cpp, class C>
  void run(const std::string& name, int calls, const Cpp& in_cpp, const C& in_c) {
    double cpp = std::numeric_limits<double>::infinity(), c = cpp;
    for (int round = 0; round < rounds_; ++round) {
      cpp = std::min(cpp, nanoseconds(calls, in_cpp));
      c = std::min(c, nanoseconds(calls, in_c));
    }
    rows_->push_back({{"call", name}, {"cpp_ns", cpp}, {"c_ns", c}, {"more_ns", c - cpp}});
  }

 private:
  template <class Call>
  static double nanoseconds(int calls, const Call& call) {
    const double begin = milliseconds();
    for (int i = 0; i < calls; ++i) call(i);
    return 1e6 * (milliseconds() - begin) / calls;
  }

  int rounds_;
  Json* rows_;
};

void measure_engine(int n, Measurement& measure, bool& good) {
  Twins twins(n);
  const std::string items = " of " + std::to_string(n * n * n) + " items";
  measure.run(
      "frame" + items, 2000, [&](int) { (void)twins.engine->frame(*twins.view); },
      [&](int) {
        sl_frame_report report = SL_FRAME_REPORT_INIT;
        twins.require(sl_engine_frame(twins.c_engine, &twins.c_view, nullptr, &report));
      });
#if SIGHTLINE_HAS_RAYTRACE
  measure.run(
      "pick" + items, 2000, [&](int i) { (void)twins.engine->pick(*twins.view, 40 + i % 1200, 360); },
      [&](int i) {
        sl_pick pick = SL_PICK_INIT;
        twins.require(sl_engine_pick(twins.c_engine, &twins.c_view, 40 + i % 1200, 360, &pick));
      });
#endif
  good = good && twins.good;
}

void measure_edits(Measurement& measure, bool& good) {
  Twins twins(10);
  measure.run(
      "hide or show an item", 2000, [&](int i) { twins.scene.set_visible(core::ItemId(i % 1000), i % 2 == 0); },
      [&](int i) { twins.require(sl_item_set_visible(twins.c_scene, sl_item(i % 1000), i % 2 == 0)); });
  double placement[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  measure.run(
      "place an item", 2000,
      [&](int i) {
        twins.scene.set_placement(core::ItemId(i % 1000), core::translation({i, 0, 0}));
      },
      [&](int i) {
        placement[12] = i;
        twins.require(sl_item_set_placement(twins.c_scene, sl_item(i % 1000), placement));
      });
  measure.run(
      "add and remove a node", 2000,
      [&](int) { twins.scene.remove_node(twins.scene.add_node(twins.scene.root(), "a node")); },
      [&](int) {
        sl_node node = {0};
        twins.require(sl_node_add(twins.c_scene, twins.c_root, "a node", nullptr, &node));
        twins.require(sl_node_remove(twins.c_scene, node));
      });
  good = good && twins.good;
}

void measure_boxes(int n, Measurement& measure, bool& good) {
  const Twins twins(2);  // for the view
  std::vector<core::AabbD> boxes;
  std::vector<sl_box> c_boxes;
  for (int i = 0; i < n * n * n; ++i) {
    boxes.push_back(box_at(i, n));
    c_boxes.push_back(
        {{boxes[i].min.x, boxes[i].min.y, boxes[i].min.z}, {boxes[i].max.x, boxes[i].max.y, boxes[i].max.z}});
  }
  const auto culler = culling::BoxCuller::create(boxes);
  sl_box_culler c_culler = {0};
  good = good && culler && sl_box_culler_create(c_boxes.data(), c_boxes.size(), &c_culler) == SL_OK;
  if (!good) return;
  std::vector<std::uint32_t> visible, c_visible(boxes.size());
  const core::dmat4 matrix = twins.view->clip_from_world();
  const std::string name = "cull " + std::to_string(boxes.size()) + " boxes";
  measure.run(
      name, 2000,
      [&](int) { (void)culler->visible(glm::value_ptr(matrix), core::ClipDepth::kReversedZeroToOne, visible); },
      [&](int) {
        std::size_t count = 0;
        good = sl_box_culler_visible_in(c_culler, glm::value_ptr(matrix), SL_DEPTH_REVERSED_ZERO_TO_ONE,
                                        c_visible.data(), c_visible.size(), &count) == SL_OK &&
               good;
      });
  (void)sl_box_culler_destroy(c_culler);
}

core::Expected<int> run(const Options& options) {
  Json json{{"rounds", options.rounds}, {"rows", Json::array()}};
  Measurement measure(options, json["rows"]);
  bool good = true;
  measure_edits(measure, good);
  measure_boxes(5, measure, good);
  measure_boxes(50, measure, good);
  measure_engine(4, measure, good);
  measure_engine(30, measure, good);
  if (!good) return core::fail(std::string("capi: a call failed: ") + sl_last_error());
  return finish(options.json, json, [](const Json& done, std::FILE* out) {
    std::fprintf(out, "%-28s %10s %10s %10s\n", "ns per call", "C++", "C", "more");
    for (const Json& row : done["rows"])
      std::fprintf(out, "%-28s %10.0f %10.0f %10.0f\n", row["call"].get<std::string>().c_str(),
                   row["cpp_ns"].get<double>(), row["c_ns"].get<double>(), row["more_ns"].get<double>());
  });
}

void add_options(apps::CommandLine& line, Options& options) {
  line.add("--rounds", options.rounds, "the least time of so many rounds counts").in_range(1, 1000).shows_default();
  apps::add_json_option(line, options.json);
  line.examples(
      "  sightline-study capi\n"
      "  sightline-study capi --rounds 100 --json capi.json");
}

}  // namespace
}  // namespace sightline::bench::capi_bench

sightline::bench::Run sightline::bench::add_capi(apps::CommandLine& line) {
  using namespace capi_bench;
  return add_subcommand<Options>(line, add_options, run);
}
