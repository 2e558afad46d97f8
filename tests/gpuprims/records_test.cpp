// What shaders read: the records of items (packing.h) and the block of a view (view_block.h).
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/packing.h"
#include "sightline/gpuprims/internal/view_block.h"

namespace sightline::gpuprims::records_test {
namespace {

using core::dvec3;

/// A record in floats, packed with the identity as placement.
struct Record {
  std::vector<Texel> texels;

  explicit Record(const core::Primitive& primitive) {
    const core::Kind kind = core::kind_of(primitive);
    texels.resize(std::size_t(texels_per_item(kind)));
    PackedItem item;
    item.placement.linear = core::mat3(1.0f);
    pack(kind, core::parameters(primitive), item, texels);
  }
  float at(int texel, int component) const {
    return std::bit_cast<float>(texels[std::size_t(texel)][std::size_t(component)]);
  }
  /// Lengths of the axes of its local frame.
  dvec3 size() const {
    return {std::hypot(at(0, 0), at(0, 1), at(0, 2)), std::hypot(at(0, 3), at(1, 0), at(1, 1)),
            std::hypot(at(1, 2), at(1, 3), at(2, 0))};
  }
  dvec3 origin() const { return {at(2, 1), at(2, 2), at(2, 3)}; }
  float first() const { return at(3, 3); }
  bool nothing() const { return size() == dvec3(0.0); }
};

void expect_texel(const Record& record, int texel, const std::array<double, 4>& expected) {
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(record.at(texel, i), expected[std::size_t(i)], 1e-6) << texel << ", " << i;
}

TEST(Records, TellWhereATorusCloses) {
  constexpr double kPi = std::numbers::pi;
  for (const float angle : {6.283185f, -6.283185f, 6.2831855f, 50.0f}) {
    expect_texel(Record(core::CircularTorus{4, 1, angle}), 4, {1.0, 1.0, -1.0, 0.0});
    expect_texel(Record(core::RectangularTorus{1, 4, 2, angle}), 4, {0.25, 1.0, -1.0, 0.0});
  }
  const float quarter = float(0.5 * kPi);
  for (const float angle : {quarter, -quarter}) {
    const Record torus(core::CircularTorus{4, 1, angle}), ring(core::RectangularTorus{4, 1, 2, angle});
    expect_texel(torus, 4, {1.0, 0.0, std::cos(0.25 * kPi), std::sin(0.25 * kPi)});
    expect_texel(ring, 4, {0.25, 0.0, std::cos(0.25 * kPi), std::sin(0.25 * kPi)});
    EXPECT_EQ(torus.first(), 0.25f);
    EXPECT_EQ(ring.first(), 0.5f);
    EXPECT_NEAR(torus.size().x, 4.0, 1e-6);
    EXPECT_NEAR(torus.at(0, 0), 4.0 * std::cos(0.25 * kPi), 1e-6) << "turned towards the middle of the sweep";
    EXPECT_NEAR(torus.at(0, 1), 4.0 * std::sin(0.25 * kPi), 1e-6);
  }
  EXPECT_EQ(Record(core::CircularTorus{4, 1, 6.2831845f}).at(4, 1), 0.0f);
  EXPECT_TRUE(Record(core::CircularTorus{4, 0, 1}).nothing());
  EXPECT_TRUE(Record(core::RectangularTorus{0, 0, 1, 1}).nothing());
}

TEST(Records, PyramidsAreInUnitsOfTheirLargestLength) {
  const core::Pyramid sides[] = {
      {8, 2, 1, 4, 2, -6, 3}, {2, 8, 4, 1, 2, -6, 3}, {1, 4, 8, 2, 2, -6, 3}, {4, 1, 2, -8, 2, -6, 3}};
  for (const core::Pyramid& p : sides) {
    const Record record(p);
    EXPECT_EQ(record.size(), dvec3(8.0));
    EXPECT_EQ(record.first(), 3.0f / 8.0f);
    expect_texel(record, 4, {p.bottom_x / 16.0, p.bottom_y / 16.0, p.top_x / 16.0, std::abs(p.top_y) / 16.0});
    expect_texel(record, 5, {2.0 / 8.0, -6.0 / 8.0, 0.0, 0.0});
  }
  const Record high(core::Pyramid{1, 1, 1, 1, 0, 0, -16});
  EXPECT_EQ(high.size(), dvec3(16.0));
  EXPECT_EQ(high.first(), 1.0f);
  EXPECT_EQ(Record(core::Pyramid{8, 8, 8, 8, 0, 0, 0}).first(), 1e-7f) << "flat ones have two sides to tell apart";
  EXPECT_TRUE(Record(core::Pyramid{0, 0, 0, 0, 1, 1, 0}).nothing());
}

TEST(Records, NumbersThatNoFloatCanSquareAreDrawnAsNothing) {
  EXPECT_FALSE(Record(core::Pyramid{1, 1, 1, 1, 1e18f, 0, 1}).nothing());
  EXPECT_TRUE(Record(core::Pyramid{1, 1, 1, 1, 2e18f, 0, 1}).nothing());
  EXPECT_TRUE(Record(core::Pyramid{1, 1, 1, 1, 0, -2e18f, 1}).nothing());
  EXPECT_TRUE(Record(core::Cylinder{1e-20f, 1}).nothing());
  EXPECT_FALSE(Record(core::Cylinder{1e-17f, 1}).nothing());
  EXPECT_TRUE(Record(core::Cylinder{std::numeric_limits<float>::infinity(), 1}).nothing());
  EXPECT_TRUE(Record(core::Sphere{std::numeric_limits<float>::quiet_NaN()}).nothing());
}

TEST(Records, OtherShapes) {
  const Record cylinder(core::Cylinder{-2, -6});
  EXPECT_EQ(cylinder.size(), dvec3(2.0));
  EXPECT_EQ(cylinder.first(), 3.0f);
  EXPECT_TRUE(Record(core::Cylinder{0, 1}).nothing());
  EXPECT_EQ(Record(core::Sphere{3}).size(), dvec3(1.5));
  EXPECT_EQ(Record(core::Sphere{3}).first(), 2.0f);
  EXPECT_EQ(Record(core::Box{2, -3, 0}).size(), dvec3(2.0, 3.0, double(3e-7f)));
  EXPECT_EQ(Record(core::EllipticalDish{4, 1}).size(), dvec3(4.0, 4.0, 1.0));
  EXPECT_EQ(Record(core::EllipticalDish{4, 0}).size(), dvec3(4.0, 4.0, double(4e-7f)));
  const Record shallow(core::SphericalDish{4, 1}), deep(core::SphericalDish{3, 9});
  EXPECT_EQ(shallow.size(), dvec3(4.0));
  EXPECT_EQ(shallow.first(), 0.25f);
  EXPECT_EQ(deep.size(), dvec3(5.0));
  EXPECT_EQ(deep.origin(), dvec3(0.0, 0.0, 4.0));
  EXPECT_NEAR(deep.first(), 9.0 / 5.0, 1e-6);
  EXPECT_TRUE(Record(core::SphericalDish{0, 0}).nothing());
  const Record line(core::Line{-1, 3});
  EXPECT_EQ(line.at(0, 0), 4.0f);
  EXPECT_EQ(line.origin(), dvec3(-1.0, 0.0, 0.0));
}

TEST(Records, MeshesArePlacementsAlone) {
  PackedItem item;
  item.placement.linear = core::mat3(2.0f);
  item.placement.origin = core::vec3(1.0f, 2.0f, 3.0f);
  item.placement.chunk = 7;
  item.id = 8;
  item.material = 9u | kFlatShaded;
  std::vector<Texel> texels(std::size_t(texels_per_item(core::Kind::kMesh)));
  pack(core::Kind::kMesh, {}, item, texels);
  const auto f = [](float v) { return std::bit_cast<std::uint32_t>(v); };
  EXPECT_EQ(texels, (std::vector<Texel>{
                        {f(2), 0, 0, 0}, {f(2), 0, 0, 0}, {f(2), f(1), f(2), f(3)}, {7, 8, 9u | kFlatShaded, 0}}));
}

TEST(Records, Snouts) {
  const core::Snout cone{2, 4, 8, 1, -2, 0, 0, 0.5f, 0};
  const Record record(cone);
  EXPECT_EQ(record.size(), dvec3(4.0));
  EXPECT_EQ(record.first(), 2.0f);
  expect_texel(record, 4, {0.5, 1.0, 0.25, -0.5});
  expect_texel(record, 5, {0.0, 0.0, std::tan(0.5), 0.0});
  const core::EndRange above = core::top_end_range(cone);
  ASSERT_FALSE(above.limited);
  EXPECT_NEAR(record.at(6, 0), -1.0, 1e-6);
  EXPECT_NEAR(record.at(6, 1), (4.0 + above.max) / 4.0, 1e-6);
  EXPECT_EQ(record.at(6, 2), -1e18f);
  EXPECT_EQ(record.at(6, 3), 1e18f);
  for (const bool top_is_larger : {false, true}) {
    const Record flat(core::Snout{top_is_larger ? 2.0f : 4.0f, top_is_larger ? 4.0f : 2.0f, 0, 6, 8, 0, 0, 0, 0});
    EXPECT_EQ(flat.size(), dvec3(4.0));
    EXPECT_EQ(flat.first(), 0.0f);
    EXPECT_EQ(flat.origin(), (top_is_larger ? 1.0 : -1.0) * dvec3(3.0, 4.0, 0.0)) << "the larger end's disc";
  }
  EXPECT_TRUE(Record(core::Snout{0, 0, 1, 0, 0, 0, 0, 0, 0}).nothing());
}

// --- view block ------------------------------------------------------------------------------------------------------

core::View perspective() {
  return *core::View::perspective({{10, 20, 30}, {11, 25, 29}, {0, 0, 1}}, 0.8, 1.5, 0.25);
}

TEST(ViewBlock, KeepsSectionPlanesInEyeSpace) {
  core::View view = perspective();
  const core::Plane planes[] = {{{1, 0, 0}, -12}, {{0, 0, 0}, 5}, {{0.5, -2, 1}, 3}};
  view.sections.assign(std::begin(planes), std::end(planes));
  view.section_mode = core::SectionMode::kUnion;
  const ViewBlock block = *make_view_block(view, 300, 200);
  EXPECT_EQ(block.flags, glm::ivec4(1, 2, 1, 0)) << "perspective, two planes with a normal, in union";
  const dvec3 point(13, 22, 28);
  const glm::dvec4 eye = view.eye_from_world() * glm::dvec4(point, 1.0);
  EXPECT_NEAR(glm::dot(glm::dvec4(block.sections[0]), eye), core::evaluate(planes[0], point), 1e-5);
  EXPECT_NEAR(glm::dot(glm::dvec4(block.sections[1]), eye),
              core::evaluate(planes[2], point) / glm::length(planes[2].normal), 1e-5);
  view.section_mode = core::SectionMode::kIntersection;
  view.sections.clear();
  EXPECT_EQ(make_view_block(view, 300, 200)->flags, glm::ivec4(1, 0, 0, 0));
}

TEST(ViewBlock, HasRoomForEightSectionPlanes) {
  core::View view = perspective();
  for (int i = 0; i < 8; ++i) view.sections.push_back({{1, 0, 0}, double(i)});
  EXPECT_EQ(make_view_block(view, 300, 200)->flags[1], 8);
  for (int i = 8; i < 12; ++i) view.sections.push_back({{1, 0, 0}, double(i)});
  const ViewBlock block = *make_view_block(view, 300, 200);
  EXPECT_EQ(block.flags[1], 8);
  const glm::dvec4 eye = view.eye_from_world() * glm::dvec4(2.0, 0.0, 0.0, 1.0);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(glm::dot(glm::dvec4(block.sections[i]), eye), 2.0 + i, 1e-4) << i;
}

/// The ray of a pixel: origin and direction per axis at eye depth t.
TEST(ViewBlock, RaysOfPixelsAreWhatTheProjectionSays) {
  const core::Pose pose{{10, 20, 30}, {11, 25, 29}, {0, 0, 1}};
  const core::View views[] = {perspective(), *core::View::orthographic(pose, 12.0, 1.5, -5.0, 100.0),
                              *core::View::asymmetric(pose, -0.1, 0.3, -0.2, 0.1, 0.25, 90.0)};
  for (const core::View& view : views) {
    const ViewBlock block = *make_view_block(view, 300, 200);
    EXPECT_EQ(block.flags[0] == 0, view.orthographic());
    const double size[2] = {300.0, 200.0};
    for (const glm::dvec2& pixel : {glm::dvec2(0, 0), glm::dvec2(300, 200), glm::dvec2(37.5, 150.25)})
      for (const double t : {0.5, 3.0, 60.0}) {
        glm::dvec4 eye(0.0, 0.0, -t, 1.0);
        for (int axis = 0; axis < 2; ++axis) {
          glm::dvec4 r(block.pixel_ray[axis]);
          for (int i = 0; i < 2; ++i) r[view.orthographic() ? i : 2 + i] += block.pixel_ray_rest[2 * axis + i];
          eye[axis] = (r.x + r.y * pixel[axis]) + t * (r.z + r.w * pixel[axis]);
        }
        const glm::dvec4 clip = view.clip_from_eye() * eye;
        for (int axis = 0; axis < 2; ++axis)
          EXPECT_NEAR(clip[axis] / clip.w, 2.0 * pixel[axis] / size[axis] - 1.0, 1e-11);
        EXPECT_NEAR(eye_depth(reversed_clip_from_eye(view), clip.z / clip.w), t, 1e-9);
      }
  }
  EXPECT_NEAR(make_view_block(views[0], 300, 200)->depth_range.x, 0.25, 1e-6);
  EXPECT_EQ(make_view_block(views[0], 300, 200)->depth_range.y, 3.0e38f) << "no far plane";
  EXPECT_NEAR(make_view_block(views[2], 300, 200)->depth_range.y, 90.0, 1e-3);
}

TEST(ViewBlock, RefusesOtherProjections) {
  for (const int entry : {1, 2, 4, 6, 3, 7, 0, 5, 15}) {
    core::dmat4 clip = perspective().clip_from_eye();
    double& value = clip[entry / 4][entry % 4];
    value = value == 0.0 ? 0.5 : 0.0;
    const auto view =
        core::View::from_matrices(perspective().eye_from_world(), clip, core::ClipDepth::kReversedZeroToOne);
    ASSERT_TRUE(view);
    EXPECT_FALSE(make_view_block(*view, 300, 200)) << "entry " << entry;
  }
}

}  // namespace
}  // namespace sightline::gpuprims::records_test
