// Whatever OpenGL refuses, an engine says so or does without, and goes on: the call that failed works once what it
// needs can be had, and images are then those of an engine that knew no trouble. Meanwhile the CPU culls.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <numeric>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "drawn_grid.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/faulty_gl.h"

namespace sightline::tests::faults_test {
namespace {

using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;

constexpr int kWidth = 64, kHeight = 48;
constexpr unsigned kSeed = 43;

/// A way to cull and draw.
struct Mode {
  const char* name;
  void (*set)(EngineConfig&);
  int side = 6;  // of the grid of items
  bool sections = false, overlays = false;
  int most_tries = 4;  // of each kind, but for long runs
  enum class Calls { kFew, kMany, kSwap } calls = Calls::kFew;
};

const Mode kModes[] = {
    {"cpu", [](EngineConfig& c) { c.culling.culler = CullerChoice::kCpu; }},
    {"programs", [](EngineConfig& c) { c.context.program_cache = std::filesystem::path(); }},
    {"occlusion", [](EngineConfig& c) { c.culling.occlusion = engine::OcclusionChoice::kOn; }},
    {"geometry",
     [](EngineConfig& c) {
       c.culling.culler = CullerChoice::kGpu;
       c.culling.gpu_variant = culling::GpuVariant::kGeometry;
     }},
    {"compute",
     [](EngineConfig& c) {
       c.culling.culler = CullerChoice::kGpu;
       c.culling.gpu_variant = culling::GpuVariant::kCompute;
     }},
    {"gpu_occlusion",
     [](EngineConfig& c) {
       c.culling.culler = CullerChoice::kGpu;
       c.culling.occlusion = engine::OcclusionChoice::kOn;
     }},
    {"hybrid",
     [](EngineConfig& c) {
       c.culling.culler = CullerChoice::kHybrid;
       DrawnGrid::switch_often(c);
     },
     22, false, false, 2},
    {"sections", [](EngineConfig& c) { c.drawing.looks.hatching.strength = 0.5f; }, 6, true},
    {"depth_shading",
     [](EngineConfig& c) {
       c.drawing.looks.depth_shading = {0.5f, 0.5f};
     }},
    {"edges", [](EngineConfig& c) { c.drawing.looks.edges.which = engine::EdgeChoice::kFeature; }, 6, true},
    {"samples", [](EngineConfig& c) { c.drawing.samples = 4; }, 6, true},
    {"overlays", [](EngineConfig& c) { c.drawing.transparency = engine::Transparency::kBlended; }, 6, false, true},
    {"overlays_in_samples",
     [](EngineConfig& c) {
       c.drawing.transparency = engine::Transparency::kBlended;
       c.drawing.looks.depth_shading = {0.5f, 0.5f};
       c.drawing.samples = 4;
     },
     6, false, true},
    {"splats",
     [](EngineConfig& c) {
       c.losses.min_projected_area = 20.0f;
       c.losses.contribution_mode = engine::ContributionMode::kPoints;
     }},
    {"budget", [](EngineConfig& c) { c.losses.budget_ms = 1e5; }},
    {"levels", [](EngineConfig& c) { c.losses.lod_error = 0.5; }},
    {"many_calls", [](EngineConfig& c) { c.losses.min_projected_area = 2.0f; }, 6, false, false, 4, Mode::Calls::kMany},
    {"landing", [](EngineConfig& c) { c.culling.rebuild_share = 0.03; }, 8, false, false, 4, Mode::Calls::kSwap},
    {"gpu_levels",
     [](EngineConfig& c) {
       c.losses.lod_error = 0.5;
       c.culling.culler = CullerChoice::kGpu;
     }},
};

struct Pixels {
  std::vector<std::uint8_t> colours;
  std::vector<std::uint32_t> ids;
  std::vector<float> metres;

  /// How many values differ; far below 0 for other sizes.
  std::ptrdiff_t differing(const Pixels& other) const {
    return differing(colours, other.colours) + differing(ids, other.ids) + differing(metres, other.metres);
  }
  template <class T>
  static std::ptrdiff_t differing(const std::vector<T>& a, const std::vector<T>& b) {
    if (a.size() != b.size()) return -1'000'000'000;
    return std::inner_product(a.begin(), a.end(), b.begin(), std::ptrdiff_t(0), std::plus<>(), std::not_equal_to<>());
  }
};

/// What an application does with an engine, in steps that may fail and are then to work when they are tried again.
class Session {
 public:
  using Step = core::Expected<void> (Session::*)();
  struct NamedStep {
    const char* name;
    Step step;
  };
  static std::vector<NamedStep> steps(const Mode& mode) {
    std::vector<NamedStep> all = {{"create", &Session::create}, {"frame", &Session::first},
                                  {"style", &Session::style},   {"frame", &Session::second},
                                  {"read", &Session::read},     {"commit", &Session::commit}};
    if (mode.calls == Mode::Calls::kSwap) all.push_back({"land", &Session::land});
    all.insert(all.end(), {{"frame", &Session::second}, {"read", &Session::read}, {"resize", &Session::resize}});
    if (mode.calls == Mode::Calls::kMany)
      all.insert(all.end(), {{"frame", &Session::first},
                             {"loss", &Session::loss},
                             {"tile", &Session::tile},
                             {"states", &Session::states},
                             {"use another culler", &Session::use_gpu_culler},
                             {"frame", &Session::second},
                             {"read", &Session::read},
                             {"use the former culler", &Session::use_cpu_culler},
                             {"use another image", &Session::use_other_image},
                             {"frame", &Session::second},
                             {"read", &Session::read},
                             {"use the former image", &Session::use_former_image},
                             {"rebuild", &Session::rebuild}});
    all.insert(all.end(), {{"frame", &Session::first}, {"read", &Session::read}, {"end", &Session::end}});
    return all;
  }

  Session(const Mode& mode, const EngineConfig& config) : mode_(mode), config_(config) {
    for (int i = 0; i < mode.side * mode.side * mode.side; ++i) {
      const core::Affine at = core::translation({i % mode.side, i / mode.side % mode.side, i / mode.side / mode.side});
      if (i % 2 == 0)
        scene_.add_primitive(scene_.root(), core::Box{0.4f, 0.4f, 0.4f}, at);
      else
        scene_.add_primitive(scene_.root(), core::Cylinder{0.2f, 0.5f}, at);
    }
    add_torus(0.05, 0);
  }

  Engine* engine() { return engine_ ? &*engine_ : nullptr; }
  /// Goes on in another context, and draws the last image there.
  core::Expected<void> use(gl::Context& context) {
    config_.context.application = &context;
    if (!engine_) return {};
    auto done = engine_->use_context(context);
    if (done) done = engine_->finish_levels();
    return done && turn_ ? frame(*turn_) : done;
  }
  const std::vector<Pixels>& pixels() const { return pixels_; }
  core::View view(double turn) const {
    const double middle = 0.5 * mode_.side;
    const core::dvec3 centre(middle), eye = centre + 2.0 * mode_.side * core::dvec3(std::cos(turn), std::sin(turn), .3);
    core::View made = *core::View::perspective({eye, centre, {0, 0, 1}}, 0.7, double(kWidth) / kHeight, 0.1);
    if (mode_.sections) made.sections = {{core::dvec3(0, 0, 1), -0.55 * mode_.side}};
    return made;
  }

 private:
  void add_torus(double bumps, int place) {
    const auto torus = scene_.add_mesh(bumpy_torus(24, bumps)).value();
    core::Affine at = core::translation(core::dvec3(mode_.side * 0.3 * (1 + place)));
    at.linear *= 0.2 * mode_.side / 6;
    for (int i = 0; i < 3; ++i, at.origin.x += 1.0) scene_.add_mesh_instance(scene_.root(), torus, at);
  }
  core::Expected<void> create() {
    auto made = Engine::create(scene_, config_);
    if (!made) return tl::unexpected(made.error());
    engine_ = std::move(*made);
    return engine_->finish_levels();
  }
  core::Expected<void> frame(double turn) {
    auto report = engine_->frame(view(turn));
    if (!report) return tl::unexpected(report.error());
    turn_ = turn;
    if (!report->drawn) return core::fail("nothing was drawn");
    while (engine_->take_late_report()) {
    }
    engine_->finish();
    return {};
  }
  core::Expected<void> first() { return frame(0.0); }
  core::Expected<void> second() { return frame(0.4); }
  core::Expected<void> style() {
    if (!mode_.overlays) return {};
    const std::vector<core::ItemId> items = {core::ItemId(3), core::ItemId(40), core::ItemId(77), core::ItemId(111)};
    auto done = engine_->set_override({items.data(), 2}, {.ghost = true});
    if (done) done = engine_->set_override({items.data() + 2, 1}, {.alpha = 0.5f});
    if (done) done = engine_->set_override({items.data() + 3, 1}, {.outline = true});
    return done;
  }
  core::Expected<void> read() {
    Pixels read;
    auto colours = engine_->read_colour();
    if (!colours) return tl::unexpected(colours.error());
    auto ids = engine_->read_ids();
    if (!ids) return tl::unexpected(ids.error());
    auto depths = engine_->read_depth(view(0.0));
    if (!depths) return tl::unexpected(depths.error());
    pixels_.push_back({std::move(colours->pixels), std::move(ids->ids), std::move(depths->metres)});
    return {};
  }
  /// Items of a kind that was not there, more than there is room for, a mesh, and a material.
  core::Expected<void> commit() {
    if (!edited_) {
      edited_ = true;
      const auto red = scene_.add_material({"red", {1, 0, 0}, 1.0f, 0});
      for (int i = 0; i < mode_.side * mode_.side * mode_.side; ++i) {
        const core::Affine at =
            core::translation({i % mode_.side + 0.5, i / mode_.side % mode_.side, i / mode_.side / mode_.side});
        scene_.add_primitive(scene_.root(), core::Box{0.1f, 0.1f, 0.3f}, at, red);
      }
      scene_.add_primitive(scene_.root(), core::Sphere{0.7f}, core::translation({5, 2, 3}));
      scene_.remove_item(core::ItemId(5));
      add_torus(0.1, 1);
    }
    if (auto done = engine_->commit(); !done) return done;
    return engine_->finish_levels();
  }
  /// Until what is made in the background is shown, or without that if it was given up.
  core::Expected<void> land() {
    while (engine_->rebuilding())
      if (auto drawn = second(); !drawn) return drawn;
    return engine_->rebuild();
  }
  core::Expected<void> loss() { return without_value(engine_->loss(view(0.0))); }
  core::Expected<void> tile() {
    return without_value(engine_->frame_tile(view(0.0), {4 * kWidth, 4 * kHeight, kWidth, 0}));
  }
  core::Expected<void> states() { return without_value(engine_->cull_states(view(0.0))); }
  core::Expected<void> use_culler(CullerChoice culler, float area) {
    EngineConfig changed = engine_->config();
    changed.culling.culler = culler;
    changed.losses.min_projected_area = area;
    return engine_->configure(changed);
  }
  core::Expected<void> use_gpu_culler() { return use_culler(CullerChoice::kGpu, 0.0f); }
  core::Expected<void> use_cpu_culler() { return use_culler(CullerChoice::kCpu, 1.0f); }
  core::Expected<void> use_other_image() { return engine_->use_image(1); }
  core::Expected<void> use_former_image() { return engine_->use_image(0); }
  core::Expected<void> rebuild() { return engine_->rebuild(); }
  template <class T>
  static core::Expected<void> without_value(const core::Expected<T>& result) {
    return result ? core::Expected<void>() : tl::unexpected(result.error());
  }
  core::Expected<void> resize() { return engine_->resize(kWidth + 16, kHeight); }
  core::Expected<void> end() {
    engine_.reset();
    return {};
  }

  Mode mode_;
  EngineConfig config_;
  core::Scene scene_;
  std::optional<Engine> engine_;
  std::vector<Pixels> pixels_;
  std::optional<double> turn_;  // of the last frame
  bool edited_ = false;
};

class FaultsTest : public DrawnGrid, public ::testing::WithParamInterface<Mode> {
 protected:
  EngineConfig configured() {
    EngineConfig c = config(CullerChoice::kCpu, kWidth, kHeight);
    c.drawing.ids = true;
    c.culling.rebuild_share = 0.0;
    GetParam().set(c);
    return c;
  }
  /// `most` of the numbers below `count`, at random, or all if there are no more.
  static std::vector<int> some_of(int count, int most) {
    std::vector<int> numbers(static_cast<std::size_t>(count));
    std::iota(numbers.begin(), numbers.end(), 0);
    std::mt19937 random(kSeed);
    std::shuffle(numbers.begin(), numbers.end(), random);
    numbers.resize(std::size_t(std::min(count, most)));
    return numbers;
  }
  /// All calls in a long run, else some of them.
  static std::vector<int> tried(int count) { return some_of(count, long_run() ? count : GetParam().most_tries); }
  void run_without_fault(FaultyGl& faulty) {
    Session run(GetParam(), configured());
    faulty.reset();
    for (const auto& [name, step] : Session::steps(GetParam())) {
      const auto done = (run.*step)();
      ASSERT_TRUE(done) << name << ": " << done.error().message;
    }
    wanted = run.pixels();
    calls = faulty.calls();
    fallible = faulty.fallible();
  }
  /// What can be asked of an engine whose context fails or is lost.
  static void expect_that_the_cpu_culls(Session& run) {
    if (!run.engine()) return;
    Engine& engine = *run.engine();
    const auto report = engine.frame(run.view(0.2));
    if (!report || !report->drawn) {
      EXPECT_GT(engine.snapshot().count(engine.visible()), 50u);
    }
    const auto items = engine.items_in(run.view(0.0), {0, 0, kWidth, kHeight}, culling::RegionRule::kCrossing);
    ASSERT_TRUE(items) << items.error().message;
    EXPECT_GT(items->size(), 50u);
  }
  void run_with_fault(FaultyGl& faulty, int number, int count) {
    Session run(GetParam(), configured());
    faulty.reset();
    faulty.fail(number, count);
    for (const auto& [name, step] : Session::steps(GetParam())) {
      auto done = (run.*step)();
      SCOPED_TRACE(std::string(name) + ", " + std::string(faulty.failed_first()) + " failed");
      if (!done) {
        ASSERT_TRUE(faulty.failed()) << done.error().message;
        EXPECT_FALSE(done.error().message.empty());
        ++errors;
        if (std::string_view(name) != "read") expect_that_the_cpu_culls(run);
        (void)context->take_errors();
        faulty.stop();
        done = (run.*step)();
        ASSERT_TRUE(done) << "a second time: " << done.error().message;
      }
      for (const std::string& error : context->take_errors()) {
        if (error != "GetError: GL_OUT_OF_MEMORY") ADD_FAILURE() << "GL error left: " << error;
      }
    }
    expect_wanted(run, faulty.failed_first());
  }

  /// In a context that is lost at that call; the rest in the test's own.
  void run_with_loss(int number) {
    auto made = gl::Context::create_offscreen();
    ASSERT_TRUE(made) << made.error().message;
    FaultyGl faulty(*made);
    EngineConfig c = configured();
    c.context.application = &*made;
    Session run(GetParam(), c);
    faulty.lose(number);
    bool before = true;
    for (const auto& [name, step] : Session::steps(GetParam())) {
      auto done = (run.*step)();
      SCOPED_TRACE(std::string(name) + ", lost in " + std::string(faulty.failed_first()));
      if (before && faulty.lost()) {
        before = false;
        expect_frames_without_context(run);
        ASSERT_TRUE(context->make_current());
        const auto used = run.use(*context);
        ASSERT_TRUE(used) << used.error().message;
        if (!done) done = (run.*step)();
      }
      ASSERT_TRUE(done) << done.error().message;
      for (const std::string& error : context->take_errors()) ADD_FAILURE() << "GL error left: " << error;
    }
    expect_wanted(run, faulty.failed_first());
    ASSERT_TRUE(made->make_current());
  }
  static void expect_frames_without_context(Session& run) {
    if (!run.engine()) return;
    const auto report = run.engine()->frame(run.view(0.2));
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_FALSE(report->drawn);
    EXPECT_EQ(engine::EngineParts::drawing(*run.engine()), nullptr);
    expect_that_the_cpu_culls(run);
  }
  void expect_wanted(const Session& run, std::string_view failed) const {
    ASSERT_EQ(run.pixels().size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i)
      EXPECT_EQ(run.pixels()[i].differing(wanted[i]), 0) << "pixels of image " << i << ", after " << failed;
  }

  /// Lets `count` calls fail from each call on that is tried.
  void try_faults(int count) {
    FaultyGl faulty(*context);
    for (int i = 0; i < 2; ++i)  // the first run may have to compile programs
      ASSERT_NO_FATAL_FAILURE(run_without_fault(faulty));
    int not_reached = 0;
    const std::vector<int> numbers = tried(fallible);
    for (const int number : numbers) {
      SCOPED_TRACE("call " + std::to_string(number) + " of " + std::to_string(fallible));
      ASSERT_NO_FATAL_FAILURE(run_with_fault(faulty, number, count));
      not_reached += !faulty.failed();  // how often a frame asks whether something is done depends on the time
    }
    const int all = int(numbers.size());
    std::printf("%d of %d calls that may fail, seed %u: %d errors, %d not noticed, %d not reached\n", all, fallible,
                kSeed, errors, all - errors - not_reached, not_reached);
    EXPECT_LE(not_reached, 5 + all / 20);
  }

  std::vector<Pixels> wanted;
  int calls = 0, fallible = 0;
  int errors = 0;
};

TEST_P(FaultsTest, OneCallFails) {
  try_faults(1);
}

/// As it is while the memory is full: the call that failed is tried again once it is not.
TEST_P(FaultsTest, AllCallsFailForAWhile) {
  try_faults(FaultyGl::kForever);
}

TEST_P(FaultsTest, TheContextIsLostInTheMiddle) {
  {
    FaultyGl faulty(*context);
    for (int i = 0; i < 2; ++i) ASSERT_NO_FATAL_FAILURE(run_without_fault(faulty));
  }
  const std::vector<int> numbers = some_of(calls, GetParam().most_tries * (long_run() ? 25 : 1));
  for (const int number : numbers) {
    SCOPED_TRACE("call " + std::to_string(number) + " of " + std::to_string(calls));
    ASSERT_NO_FATAL_FAILURE(run_with_loss(number));
  }
  std::printf("lost at %zu of %d calls, seed %u\n", numbers.size(), calls, kSeed);
}

INSTANTIATE_TEST_SUITE_P(Modes, FaultsTest, ::testing::ValuesIn(kModes),
                         [](const auto& mode) { return std::string(mode.param.name); });

}  // namespace
}  // namespace sightline::tests::faults_test
