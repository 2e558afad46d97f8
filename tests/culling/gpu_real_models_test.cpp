// Both production paths on real models, flown through as users do: the same visible set but for what lies within the
// float planes' band, and the same images.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "gpu_rig.h"
#include "scenes.h"
#include "sightline/apps/common/model.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/engine/tour.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::gpu_real_models_test {
namespace {

using core::AabbD;
using core::CameraKey;
using core::CameraPath;
using core::dvec3;
using tests::Random;
using tests::uniform;

constexpr int kFrames = 100, kDrawnEvery = 25;
constexpr double kAspect = double(tests::ImagePair::kWidth) / tests::ImagePair::kHeight;

struct Flight {
  const char* name;
  CameraPath path;
};

void look(std::vector<CameraKey>& keys, const dvec3& eye, const dvec3& target, double fovy = 1.0) {
  keys.push_back({double(keys.size()), {eye, target, {0, 0, 1}}, fovy});
}

Flight through(const char* name, std::vector<CameraKey> keys, double size, double far = core::kInfiniteFar) {
  Flight flight{name, *CameraPath::create(std::move(keys))};
  flight.path.near = 1e-4 * size;
  flight.path.far = far;
  return flight;
}

std::vector<Flight> flights_of(const core::Snapshot& snapshot, Random& random) {
  const AabbD box = snapshot.bounds().world_bounds();
  const dvec3 centre = box.centre(), half = 0.5 * box.size();
  const double size = glm::length(box.size()), start = uniform(random, 0.0, 2.0 * std::numbers::pi);
  const auto around = [&](int step, double height) {
    const double angle = start + 0.25 * std::numbers::pi * step;
    return dvec3(std::cos(angle), std::sin(angle), height);
  };
  const auto inside = [&] {
    return centre + half * dvec3(uniform(random, -0.6, 0.6), uniform(random, -0.6, 0.6), uniform(random, -0.6, 0.6));
  };
  std::vector<CameraKey> orbit, turn, over, dive;
  const dvec3 spot = inside();
  for (int i = 0; i <= 8; ++i) {
    look(orbit, centre + size * around(i, 0.4), centre);
    look(turn, spot, spot + size * around(i, 0.1));
  }
  for (int i = 0; i <= 4; ++i) {
    const dvec3 below = centre + half * dvec3(0.6 * i - 1.2, uniform(random, -0.5, 0.5), 1.0);
    look(over, below + dvec3(0, 0, 0.1 * size), below + dvec3(0.3 * size, 0, -0.3 * size));
  }
  for (int i = 0; i < 3; ++i) {  // down to a detail in a view of three degrees, and out again
    const dvec3 place = inside();
    look(dive, place + 0.8 * size * around(3 * i, 0.6), place);
    look(dive, place + 0.02 * size * around(3 * i + 1, 0.3), place, 0.05);
  }
  std::vector<Flight> flights{{"tour", engine::make_tour(snapshot.bounds(), snapshot.bounds().fitted_bounds())}};
  flights.push_back(through("orbit", std::move(orbit), size, 3.0 * size));
  flights.push_back(through("turn", std::move(turn), size));
  flights.push_back(through("fly-over", std::move(over), size));
  flights.push_back(through("dive", std::move(dive), size));
  return flights;
}

class GpuRealModels : public tests::GlTest, public testing::WithParamInterface<const char*> {
 protected:
  struct Found {
    std::size_t items = 0, extra = 0, shown = 0, ties = 0;
  };
  Found fly(tests::Rig& rig, const CameraPath& path) {
    const culling::CpuCuller cpu(rig.snapshot.bounds());
    tests::ImagePair images(*context, rig);
    Found found;
    for (int i = 0; i < kFrames; ++i) {
      SCOPED_TRACE("frame " + std::to_string(i));
      const auto view = path.view(path.time_of(i, kFrames), kAspect);
      core::VisibleSet set;
      cpu.cull(*view, set);
      const std::vector<core::Slot> wanted = rig.occupied(set);
      found.items += wanted.size();
      found.extra += tests::expect_found(rig, *view, wanted);
      if (i % kDrawnEvery != 0) continue;
      const auto pixels = images.expect_same(rig, *view, set);
      found.shown += pixels.shown;
      found.ties += pixels.ties;
    }
    return found;
  }
};

TEST_P(GpuRealModels, LookTheSameOnBothPaths) {
  SIGHTLINE_NEED_DATA(GetParam());
  apps::ModelOptions options;
  options.files = {tests::data_path(GetParam()).string()};
  const auto model = apps::load_model(options);
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_TRUE(model->scene->commit());
  for (const culling::GpuCullerConfig& config : tests::all_gpu_configs()) {
    SCOPED_TRACE(tests::name_of(config));
    tests::Rig rig(*context, *model->scene, config);
    constexpr std::uint64_t kSeed = 1;
    SCOPED_TRACE("seed " + std::to_string(kSeed));
    Random random(kSeed);
    for (const Flight& flight : flights_of(rig.snapshot, random)) {
      SCOPED_TRACE(flight.name);
      const Found found = fly(rig, flight.path);
      EXPECT_GT(found.items, std::min<std::size_t>(1000, 10 * model->scene->item_count()));
      EXPECT_LE(found.extra, 1 + found.items / 10'000);
      EXPECT_GT(found.shown, 500u);
      EXPECT_LE(found.ties, found.shown / 20);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, GpuRealModels,
                         testing::Values("small_plant.rvm", "huldra/HA-MECH.RVM", "huldra/HA-PIPE.RVM",
                                         "huldra/WD1-PSUP.RVM"));

}  // namespace
}  // namespace sightline::gpu_real_models_test
