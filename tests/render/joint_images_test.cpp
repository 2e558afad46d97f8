// Pipe runs where solids meet: no cracks, no insides, no ids that flicker. Every pixel against the reference of all
// solids (pixel_reference.h), close by, from far, grazing, orthographic, far from the origin and cut by sections; the
// ends that lie on each other are not drawn here (core/internal/joints.h), and must not be missed.
#include <filesystem>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <span>

#include <gtest/gtest.h>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/importers/import.h"
#include "sightline/tests/render/pixel_reference.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::joint_images_test {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::View;

constexpr int kWidth = 96, kHeight = 64;
constexpr double kAspect = double(kWidth) / kHeight;

Affine turn(double angle, const dvec3& axis) {
  const dvec3 a = glm::normalize(axis);
  dmat3 m;
  for (int i = 0; i < 3; ++i) {
    dvec3 e(0.0);
    e[i] = 1.0;
    m[i] = std::cos(angle) * e + std::sin(angle) * glm::cross(a, e) + (1.0 - std::cos(angle)) * glm::dot(a, e) * a;
  }
  return {m, dvec3(0.0)};
}

/// Solids end to end along z.
class Run {
 public:
  Run(core::Scene& scene, const Affine& start) : scene_(scene), at_(start) {}

  void pipe(float radius, float length) { straight(core::Cylinder{radius, length}, length); }
  void reducer(float from, float to, float length, float off_axis = 0.0f) {
    at_ = at_ * core::translation({0.5 * off_axis, 0, 0});
    straight(core::Snout{from, to, length, off_axis, 0, 0, 0, 0, 0}, length);
    at_ = at_ * core::translation({0.5 * off_axis, 0, 0});
  }
  void elbow(float major, float radius, float angle) {
    const Affine to_axis = core::translation({-major, 0, 0});
    add(core::CircularTorus{major, radius, angle}, to_axis * turn(0.5 * std::numbers::pi, {1, 0, 0}));
    at_ = at_ * to_axis * turn(-double(angle), {0, 1, 0}) * core::translation({major, 0, 0});
  }
  /// Two straight halves cut at a slant, half of the angle each.
  void mitre(float radius, float length, float angle) {
    const float half = 0.5f * angle;
    straight(core::Snout{radius, radius, length, 0, 0, 0, 0, half, 0}, length);
    at_ = at_ * turn(-double(angle), {0, 1, 0});
    straight(core::Snout{radius, radius, length, 0, 0, -half, 0, 0, 0}, length);
  }
  void dish(float radius, float height) { add(core::EllipticalDish{radius, height}, {}); }
  void flat_dish(float radius, float height) { add(core::SphericalDish{radius, height}, {}); }

 private:
  void add(const core::Primitive& primitive, const Affine& from_here) {
    scene_.add_primitive(scene_.root(), primitive, at_ * from_here);
  }
  void straight(const core::Primitive& primitive, double length) {
    add(primitive, core::translation({0, 0, 0.5 * length}));
    at_ = at_ * core::translation({0, 0, length});
  }
  core::Scene& scene_;
  Affine at_;
};

void add_runs(core::Scene& scene, const dvec3& site) {
  const float r = 0.1f;
  Run a(scene, core::translation(site) * turn(0.7, {1, 2, 0.5}));
  a.pipe(r, 0.3f);
  a.elbow(0.2f, r, 1.5707964f);
  a.pipe(r, 0.2f);
  a.reducer(r, 0.07f, 0.15f);
  a.pipe(0.07f, 0.25f);
  a.elbow(0.15f, 0.07f, 0.6f);
  a.dish(0.07f, 0.05f);
  Run b(scene, core::translation(site + dvec3(0.1, 0.9, -0.2)) * turn(1.9, {-1, 0.3, 1}));
  b.flat_dish(r, 0.03f);  // points into the pipe: inside of it
  b.pipe(r, 0.2f);
  b.pipe(0.16f, 0.03f);  // a flange
  b.mitre(r, 0.2f, 0.7f);
  b.reducer(r, 0.13f, 0.1f, 0.05f);
  b.flat_dish(0.13f, 0.04f);
}

/// A place where two ends meet.
struct Place {
  core::ItemId item;
  dvec3 centre, axis;
  double radius;
};

class JointImages : public tests::GlTest {
 protected:
  void open(core::Scene& scene) {
    engine::EngineConfig config;
    config.draw = config.drawing.ids = true;
    config.width = kWidth;
    config.height = kHeight;
    config.culling.rebuild_share = 0.0;
    config.context.application = &*context;
    auto made = engine::Engine::create(scene, config);
    ASSERT_TRUE(made) << made.error().message;
    engine_.emplace(std::move(*made));
    const core::Snapshot snapshot(scene);
    const gpuprims::Joints& joints = engine::EngineParts::joints(*engine_);
    for (core::Slot s = 0; s < snapshot.size(); ++s) {
      if (snapshot.vacant(s)) continue;
      const core::ItemId item = snapshot.item(s);
      const core::Aabb box = snapshot.bounds().box(s);
      const dvec3 low = dvec3(box.min), high = dvec3(box.max);
      const bool solid = int(snapshot.kind(s)) < core::kPrimitiveKindCount && snapshot.kind(s) != core::Kind::kLine;
      if ((snapshot.bounds().layers(s) & core::kDefaultLayerMask) == 0) continue;
      if (!solid) {
        others_.insert(item);
        continue;
      }
      solids_.push_back({item, snapshot.primitive(s), snapshot.world_from_item(s),
                         snapshot.bounds().origin + 0.5 * (low + high), 0.5 * glm::length(high - low)});
      for (const gpuprims::Ends end : {gpuprims::kBottomEnd, gpuprims::kTopEnd}) {
        if ((joints.covered(item) & end) == 0) continue;
        const auto face = gpuprims::end_face(snapshot.primitive(s), snapshot.world_from_item(s), end);
        places_.push_back({item, face->centre, glm::normalize(glm::cross(face->u, face->v)), glm::length(face->u)});
      }
    }
  }

  void TearDown() override {
    engine_.reset();
    GlTest::TearDown();
  }

  static View look(const dvec3& eye, const dvec3& target, double fovy, double near) {
    return *View::perspective({eye, target, {0.1, 0.2, 1.0}}, fovy, kAspect, near);
  }

  struct Pixel {
    double depth = std::numeric_limits<double>::infinity();
    std::uint32_t id = 0;
  };

  struct Solid {
    core::ItemId item;
    core::Primitive primitive;
    Affine world_from_item;
    dvec3 centre;
    double radius;
  };

  bool inside_something(const dvec3& eye) const {
    for (const Solid& s : solids_) {
      if (glm::length(eye - s.centre) > s.radius) continue;
      const dmat3 inverse = glm::inverse(s.world_from_item.linear);
      const auto hits = gpuprims::intersect(
          s.primitive, {inverse * (eye - s.world_from_item.origin), inverse * dvec3(0.3, 0.5, 0.8)});
      int before = 0;
      while (before < hits.count && hits.hit[before].t < 0.0) ++before;
      if (before % 2 == 1) return true;
    }
    return false;
  }

  Pixel reference(const View& view, const std::vector<const Solid*>& near, int x, int y) const {
    const tests::PixelRay ray = tests::pixel_ray(view, kWidth, kHeight, x, y);
    Pixel pixel;
    for (const Solid* s : near) {
      const double t = tests::first_shown(s->primitive, s->world_from_item, view, ray);
      if (t < pixel.depth) pixel = {t, to_index(s->item) + 1};
    }
    return pixel;
  }

  /// True when an item has a surface about there, too: which of coincident surfaces shows is arbitrary.
  bool shows(std::uint32_t id, const View& view, int x, int y, double depth, double tolerance) const {
    const auto solid =
        std::find_if(solids_.begin(), solids_.end(), [&](const Solid& s) { return to_index(s.item) + 1 == id; });
    if (solid == solids_.end()) return false;
    for (int k = 0; k < 9; ++k)
      if (std::abs(reference(view, {&*solid}, x + k % 3 - 1, y + k / 3 - 1).depth - depth) <= tolerance) return true;
    return false;
  }

  /// Solids that may be seen: those whose ball a cone about the view reaches.
  std::vector<const Solid*> solids_in(const View& view) const {
    std::vector<const Solid*> out;
    const auto planes = core::frustum_planes(view.clip_from_world(), view.clip_depth());
    for (const Solid& s : solids_) {
      bool seen = true;
      for (const core::Plane& p : planes)
        seen = seen && core::evaluate(p, s.centre) >= -s.radius * glm::length(p.normal);
      if (seen) out.push_back(&s);
    }
    return out;
  }

  /// `references`: the view itself, or where its section lies in a face, views of which either may be
  /// right; whose cut shows is arbitrary then.
  void check(const View& view, std::span<const View> references, double radius) {
    ASSERT_TRUE(engine_->frame(view));
    engine_->finish();
    const image::DepthImage depth = engine::EngineParts::drawing(*engine_)->target().read_depth(view);
    const image::IdImage ids = engine::EngineParts::drawing(*engine_)->target().read_ids();
    const std::vector<const Solid*> near = solids_in(view);
    std::vector<Pixel> expected;
    for (const View& as : references)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) expected.push_back(reference(as, near, x, y));

    int compared = 0, holes = 0, behind = 0, before = 0, wrong_id = 0;
    for (int y = 1; y + 1 < kHeight; ++y) {
      for (int x = 1; x + 1 < kWidth; ++x) {
        double least = std::numeric_limits<double>::infinity(), most = 0.0;
        std::set<std::uint32_t> around;
        bool other = false;
        for (int k = 0; k < 9; ++k) {
          const std::size_t i = std::size_t((y + k / 3 - 1) * kWidth + x + k % 3 - 1);
          for (std::size_t e = i; e < expected.size(); e += kWidth * kHeight) {
            least = std::min(least, expected[e].depth);
            most = std::max(most, expected[e].depth);
            around.insert(expected[e].id);
          }
          other = other || (ids.ids[i] != 0 && others_.contains(core::ItemId{ids.ids[i] - 1}));
        }
        if (!std::isfinite(most) || other) continue;
        ++compared;
        const std::size_t i = std::size_t(y * kWidth + x);
        const double found = depth.metres[i], tolerance = 1e-3 * radius + 5e-6 * found;
        if (!std::isfinite(found)) {
          ++holes;
          continue;
        }
        behind += found > most + tolerance;
        before += found < least - tolerance;
        wrong_id += references.size() == 1 && !around.contains(ids.ids[i]) &&
                    !shows(ids.ids[i], view, x, y, found, tolerance + most - least);
      }
    }
    total_ += compared;
    EXPECT_EQ(holes, 0) << "of " << compared;
    EXPECT_EQ(behind, 0) << "of " << compared;
    EXPECT_EQ(before, 0) << "of " << compared;
    EXPECT_EQ(wrong_id, 0) << "of " << compared;
  }

  void check(const View& view, double radius) { check(view, std::span(&view, 1), radius); }

  void check_place(const Place& p, std::mt19937& random) {
    const auto uniform = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; };
    const dvec3 helper = std::abs(p.axis.z) < 0.8 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
    const dvec3 side = glm::normalize(glm::cross(p.axis, helper)), up = glm::cross(p.axis, side);
    const double around = uniform(0.0, 6.283), r = p.radius;
    const dvec3 out = std::cos(around) * side + std::sin(around) * up;
    const dvec3 slanted = glm::normalize(out + uniform(-0.8, 0.8) * p.axis);
    const auto at = [&](const char* name, const dvec3& eye, const dvec3& target, double fovy) {
      SCOPED_TRACE(name);
      if (!inside_something(eye)) check(look(eye, target, fovy, 0.02 * r), r);
    };
    at("near", p.centre + 5.0 * r * slanted, p.centre, 0.6);
    at("very near", p.centre + 1.4 * r * out, p.centre + r * out, 0.5);
    at("far", p.centre + 1e4 * r * slanted, p.centre, 4e-4);
    at("grazing", p.centre + 1.05 * r * out + 6.0 * r * p.axis, p.centre + r * out, 0.1);
    {
      SCOPED_TRACE("orthographic");
      check(*View::orthographic({p.centre + 20.0 * r * slanted, p.centre, {0, 0, 1}}, 4.0 * r, kAspect, -200.0 * r,
                                200.0 * r),
            r);
    }
    const View base = *View::orthographic({p.centre + 20.0 * r * slanted, p.centre, {0, 0, 1}}, 3.0 * r, kAspect,
                                          -100.0 * r, 200.0 * r);
    const auto cut = [&](const dvec3& normal, double offset) {
      View view = base;
      view.sections = {{normal, -glm::dot(normal, p.centre) + offset}};
      return view;
    };
    {
      SCOPED_TRACE("cut lengthwise");
      check(cut(-out, 0.0), r);
      check(cut(glm::normalize(0.3 * p.axis - out), 0.0), r);
    }
    // Towards the eye, with what lies behind the joint kept; in the joint itself either neighbour may be cut.
    const dvec3 away = glm::dot(slanted, p.axis) > 0.0 ? -p.axis : p.axis;
    for (const double offset : {0.0, 1e-6, -1e-6, 3e-5, -3e-5}) {
      SCOPED_TRACE("cut across, " + std::to_string(offset));
      const View either[] = {cut(away, -5e-4 * r), cut(away, 5e-4 * r)};
      check(cut(away, offset * r), either, r);
    }
  }

  std::optional<engine::Engine> engine_;
  std::vector<Solid> solids_;
  std::vector<Place> places_;
  std::set<core::ItemId> others_;
  std::uint64_t total_ = 0;
};

TEST_F(JointImages, RunsAtTheOrigin) {
  core::Scene scene;
  add_runs(scene, {1, 0, 0});
  open(scene);
  std::mt19937 random{1};
  EXPECT_GE(places_.size(), 18u);
  for (const Place& p : places_) {
    SCOPED_TRACE("item " + std::to_string(to_index(p.item)));
    check_place(p, random);
  }
  EXPECT_GT(total_, 100000u);
}

TEST_F(JointImages, RunsFarFromTheOrigin) {
  core::Scene scene;
  add_runs(scene, {1e7, -1e7, 1e7});
  open(scene);
  std::mt19937 random{2};
  EXPECT_GE(places_.size(), 16u);
  for (const Place& p : places_) {
    SCOPED_TRACE("item " + std::to_string(to_index(p.item)));
    check_place(p, random);
  }
}

TEST_F(JointImages, TheSameAsWithAllEndsDrawn) {
  core::Scene scene;
  add_runs(scene, {1, 0, 0});
  open(scene);
  std::mt19937 random{3};
  std::vector<View> views;
  for (int i = 0; i < 20; ++i) {
    const auto uniform = [&] { return 2.0 * double(random()) / 4294967296.0 - 1.0; };
    const dvec3 eye = dvec3(1, 0.5, 0) + 2.0 * glm::normalize(dvec3(uniform(), uniform(), uniform()));
    views.push_back(look(eye, {1, 0.5, 0.1}, 0.7, 0.01));
  }
  const auto images = [&] {
    std::vector<std::vector<float>> out;
    for (const View& view : views) {
      EXPECT_TRUE(engine_->frame(view));
      engine_->finish();
      out.push_back(engine::EngineParts::drawing(*engine_)->target().read_depth(view).metres);
    }
    return out;
  };
  ASSERT_GT(engine::EngineParts::joints(*engine_).count(), 0u);
  const auto hidden = images();
  for (const Solid& s : solids_) scene.set_placement(s.item, scene.placement(s.item));
  ASSERT_TRUE(engine_->commit());
  ASSERT_EQ(engine::EngineParts::joints(*engine_).count(), 0u);
  const auto drawn = images();
  int differing = 0, shown = 0;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t i = 0; i < drawn[v].size(); ++i) {
      shown += std::isfinite(drawn[v][i]);
      differing += std::isfinite(drawn[v][i]) != std::isfinite(hidden[v][i]) ||
                   (std::isfinite(drawn[v][i]) && std::abs(drawn[v][i] - hidden[v][i]) > 1e-4f);
    }
  EXPECT_GT(shown, 5000);
  EXPECT_LE(differing, shown / 1000);
}

class JointImagesOfModels : public JointImages, public ::testing::WithParamInterface<const char*> {};

TEST_P(JointImagesOfModels, AtEveryFewJoints) {
  const std::string name = GetParam();
  SIGHTLINE_NEED_DATA(name);
  core::Scene scene;
  ASSERT_TRUE(importers::import_file(tests::data_path(name), scene, scene.root()));
  open(scene);
  EXPECT_GE(places_.size(), 24u);
  std::mt19937 random{4};
  const std::size_t step = 1 + places_.size() / 24, last = std::size_t(tests::repeated(24)) * step;
  for (std::size_t i = 0; i < std::min(places_.size(), last); i += step) {
    SCOPED_TRACE("item " + std::to_string(to_index(places_[i].item)));
    check_place(places_[i], random);
  }
  EXPECT_GT(total_, std::size_t(tests::repeated(100'000)));
}

INSTANTIATE_TEST_SUITE_P(All, JointImagesOfModels,
                         ::testing::Values("small_plant.rvm", "huldra/HA-PIPE.RVM", "huldra/HA-MECH.RVM"),
                         [](const auto& test) {
                           std::string name = std::filesystem::path(test.param).stem().string();
                           std::erase(name, '-');
                           return name;
                         });

/// Ends that are not drawn reach across the gap that a joint may have, proxies and all.
TEST_F(JointImages, NoRayPassesBetweenEndsThatAreNotDrawn) {
  constexpr double kGap = 1e-4;  // radii
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Cylinder{1, 2}, core::translation({0, 0, -1}));
  scene.add_primitive(scene.root(), core::Cylinder{1, 2}, core::translation({0, 0, 1 + kGap}));
  open(scene);
  ASSERT_EQ(places_.size(), 2u) << "ends not drawn";
  const dvec3 middle(0, 0, 0.5 * kGap);
  ASSERT_TRUE(engine_->frame(
      *View::orthographic({middle + dvec3(5, 1, 0), middle, {0, 0, 1}}, 4.0 * kGap, kAspect, 0.1, 20.0)));
  engine_->finish();
  const image::IdImage ids = engine::EngineParts::drawing(*engine_)->target().read_ids();
  EXPECT_EQ(std::count(ids.ids.begin(), ids.ids.end(), 0u), 0);
  EXPECT_EQ(ids.ids.front(), 2u);
  EXPECT_EQ(ids.ids.back(), 1u);
}

}  // namespace
}  // namespace sightline::joint_images_test
