#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::snout_test {
namespace {

using twin::LVec;

struct Solid {
  core::Snout shape;
  core::EndRange bottom = core::bottom_end_range(shape), top = core::top_end_range(shape);

  // Straight from the definition in core/primitive.h.
  bool inside(const LVec& p) const {
    const long double h = shape.height, part = p.z / h;
    if (p.z < -0.5L * h + bottom.min || p.z > 0.5L * h + top.max) return false;
    const long double r = radius(p.z);
    const long double x = p.x - part * shape.offset_x, y = p.y - part * shape.offset_y;
    if (r < 0 || x * x + y * y > r * r) return false;
    const long double low = -0.5L * h + std::tan((long double)shape.bottom_shear_x) * (p.x + 0.5L * shape.offset_x) +
                            std::tan((long double)shape.bottom_shear_y) * (p.y + 0.5L * shape.offset_y);
    const long double high = 0.5L * h + std::tan((long double)shape.top_shear_x) * (p.x - 0.5L * shape.offset_x) +
                             std::tan((long double)shape.top_shear_y) * (p.y - 0.5L * shape.offset_y);
    return p.z >= low && p.z <= high;
  }
  long double radius(long double z) const {
    return shape.bottom_radius + ((long double)shape.top_radius - shape.bottom_radius) * (z / shape.height + 0.5L);
  }
  long double lateral(const LVec& p) const {
    const long double part = p.z / shape.height;
    return std::hypot(p.x - part * shape.offset_x, p.y - part * shape.offset_y) - radius(p.z);
  }
  std::vector<dvec3> cap_normals() const {
    return {{std::tan(double(shape.bottom_shear_x)), std::tan(double(shape.bottom_shear_y)), -1.0},
            {-std::tan(double(shape.top_shear_x)), -std::tan(double(shape.top_shear_y)), 1.0},
            {0, 0, -1},
            {0, 0, 1}};
  }
  dvec3 half() const {
    const core::AabbD box = core::bounds(shape, {});
    return glm::max(glm::abs(box.min), glm::abs(box.max));
  }
  double size() const { return glm::length(half()); }
  double feature() const { return std::min({std::max(shape.bottom_radius, shape.top_radius), shape.height}); }
};

core::Snout random_snout(twin::Random& random, double steepest) {
  const double scale = random.log_uniform(-6, 6);
  core::Snout s{};
  s.bottom_radius = float(scale * random.log_uniform(-1, 1));
  s.top_radius = float(scale * random.log_uniform(-1, 1));
  s.height = float(scale * random.log_uniform(-1, 1));
  switch (random.below(6)) {
    case 0:
      s.top_radius = s.bottom_radius;
      break;
    case 1:
      s.top_radius = 0.0f;
      break;
    case 2:
      s.bottom_radius = 0.0f;
      break;
    case 3:
      s.top_radius = std::nextafterf(s.bottom_radius, 0.0f);
      break;
    default:
      break;
  }
  if (random.below(2)) {
    s.offset_x = s.height * float(random.uniform(-1, 1));
    s.offset_y = s.height * float(random.uniform(-1, 1));
  }
  if (random.below(2)) {
    s.bottom_shear_x = float(random.uniform(-steepest, steepest));
    s.bottom_shear_y = float(random.uniform(-steepest, steepest));
    s.top_shear_x = float(random.uniform(-steepest, steepest));
    s.top_shear_y = float(random.uniform(-steepest, steepest));
  }
  return s;
}

void run_against_twin(unsigned count, double steepest) {
  twin::run(count, 0.125, [&](twin::Random& random) { return Solid{random_snout(random, steepest)}; });
}

TEST(Snout, AgreesWithTheMarchingTwin) {
  run_against_twin(6000, 0.5);
}

TEST(Snout, AgreesWithTheTwinWhereEndPlanesAreSteeperThanTheCone) {
  run_against_twin(6000, 1.55);
}

TEST(Snout, EqualRadiiAreTheCylinder) {
  for (unsigned seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    twin::Random random(seed);
    const auto r = float(random.log_uniform(-3, 3)), h = float(random.log_uniform(-3, 3));
    const twin::Shot shot = random_shot(random, {r, r, 0.5 * h});
    const Hits a = intersect(core::Cylinder{r, h}, shot.ray);
    const Hits b = intersect(core::Snout{r, r, h, 0, 0, 0, 0, 0, 0}, shot.ray);
    ASSERT_EQ(a.count, b.count);
    const double tolerance = 1e-7 * std::max(r, h) / glm::length(shot.ray.direction) + 1e-14 * std::fabs(shot.aim);
    for (int i = 0; i < a.count; ++i) ASSERT_NEAR(a.hit[i].t, b.hit[i].t, tolerance);
  }
}

TEST(Snout, RayParallelToAGenerator) {
  const core::Snout cone{2.0f, 0.0f, 2.0f, 0, 0, 0, 0, 0, 0};  // generators at 45 degrees, apex at z = 1
  const Hits hits = intersect(cone, {{-1.5, 0.0, -5.0}, {-1.0, 0.0, 1.0}});
  EXPECT_EQ(hits.count, 0);
  const Hits through = intersect(cone, {{1.0 + 3.0, 0.0, -1.0 - 3.0}, {-1.0, 0.0, 1.0}});  // enters at x = 1, z = -1
  ASSERT_EQ(through.count, 2);
  EXPECT_NEAR(through.hit[0].t, 3.0, 1e-14);
  EXPECT_NEAR(through.hit[1].t, 4.5, 1e-14);  // at x = -0.5, z = 0.5
}

TEST(Snout, HeightZeroIsADiscOfTheLargerEnd) {
  const core::Snout flat{1.0f, 3.0f, 0.0f, 4.0f, 0.0f, 0, 0, 0, 0};
  EXPECT_EQ(intersect(flat, {{4.5, 0.0, 1.0}, {0, 0, -1}}).count, 2);
  EXPECT_EQ(intersect(flat, {{-2.0, 0.0, 1.0}, {0, 0, -1}}).count, 0);
}

TEST(Snout, ShowsNothingWithoutRadii) {
  EXPECT_EQ(intersect(core::Snout{0, 0, 1, 0, 0, 0, 0, 0, 0}, {{0, 0, -5}, {0, 0, 1}}).count, 0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(intersect(core::Snout{1, 1, 1, 0, 0, nan, 0, 0, 0}, {{0, 0, -5}, {0, 0, 1}}).count, 0);
}

/// The plane through the apex cuts the whole cone off. Rays through the apex met it and the cone far from one another.
TEST(Snout, ShowsNoApexAlone) {
  const struct {
    core::Snout cone;
    Ray ray;
  } cases[] = {
      {{0.029917966574430466f, 0, 0.023984353989362717f, 0, 2.3317534923553467f, 0, 0, 0, 0.48725506663322449f},
       {{-3.4255503270103085, -273.54521504696635, -2.8055907263550837},
        {0.00011074452875659451, 0.0088811278482640657, 9.108956549368139e-05}}},
      {{0.0016587666468694806f, 0, 0.0090244980528950691f, 1.8779118061065674f, -1.9566829204559326f, 0, 0,
        1.1953567266464233f, 0},
       {{1.8133630810527404, -1.8884509175242448, 0.0087107191125581091},
        {-4309.5211414625401, 4485.4800440187455, -20.692185577990287}}},
      {{0.012382700107991695f, 0, 0.017463915050029755f, -1.9509961605072021f, 0, 0, 0, -0.71078109741210938f,
        -0.49071082472801208f},
       {{13.118565487779451, -0.07644636403584229, -0.11701720384841691},
        {-0.051422897006142165, 0.00027891838896096133, 0.00045880211499692915}}}};
  for (const auto& c : cases) {
    EXPECT_EQ(intersect(c.cone, c.ray).count, 0);
    core::Snout turned = c.cone;
    std::swap(turned.bottom_radius, turned.top_radius);
    std::swap(turned.bottom_shear_x, turned.top_shear_x);
    std::swap(turned.bottom_shear_y, turned.top_shear_y);
    const core::dvec3 over(1.0, 1.0, -1.0);  // upside down
    turned.offset_x = -turned.offset_x, turned.offset_y = -turned.offset_y;
    turned.bottom_shear_x = -turned.bottom_shear_x, turned.bottom_shear_y = -turned.bottom_shear_y;
    EXPECT_EQ(intersect(turned, {c.ray.origin * over, c.ray.direction * over}).count, 0);
  }
}

/// A ray through the apex, nearly along a generator. The cone leans two thousandfold, so its middle is far from there.
TEST(Snout, LeaningConesAreRightAtTheirApex) {
  const core::Snout cone{0.046644184738397598f, 0, 0.0008691199473105371f, 1.7081553936004639f, 0, 0, 0, 0,
                         -1.0848501920700073f};
  const double apex = 274.87647989928178;
  const Hits hits = intersect(cone, {{-0.4566665030937111, 0.031305230200428323, -0.00022400670812103515},
                                     {0.0047684843765957692, -0.00011388835527828783, 2.3958640696261583e-06}});
  for (int i = 0; i < hits.count; ++i) EXPECT_NEAR(hits.hit[i].t, apex, 1e-6);
}

TEST(Snout, OpenEndsDropTheirCrossingOnly) {
  const core::Snout s{1.0f, 0.5f, 2.0f, 0.2f, 0.0f, 0.1f, 0.0f, -0.2f, 0.1f};
  const Ray along{{0.0, 0.0, 3.0}, {0.0, 0.0, -1.0}};
  EXPECT_EQ(intersect(s, along).count, 2);
  const Hits bottom = intersect(s, along, {true, false}), top = intersect(s, along, {false, true});
  ASSERT_EQ(bottom.count, 1);
  EXPECT_LT(bottom.hit[0].normal.z, 0.0);
  ASSERT_EQ(top.count, 1);
  EXPECT_GT(top.hit[0].normal.z, 0.0);
  EXPECT_EQ(intersect(s, along, {false, false}).count, 0);
  EXPECT_EQ(intersect(s, {{0.0, 5.0, 0.1}, {0.0, -1.0, 0.0}}, {false, false}).count, 2);
}

}  // namespace
}  // namespace sightline::gpuprims::snout_test
