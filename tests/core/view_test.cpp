#include "sightline/core/view.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/core/seen_boxes.h"

namespace sightline::core::view_test {
namespace {

using tests::look_at_box;
using tests::Random;
using tests::Seen;
using tests::uniform;

constexpr double kPi = std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Position of a world point in the view's own terms: right, up, ahead of the eye.
struct EyeFrame {
  dvec3 right, up, forward;
  explicit EyeFrame(const Pose& pose) {
    forward = glm::normalize(pose.target - pose.eye);
    right = glm::normalize(glm::cross(forward, pose.up));
    up = glm::cross(right, forward);
  }
  dvec3 world(const Pose& pose, double x, double y, double ahead) const {
    return pose.eye + x * right + y * up + ahead * forward;
  }
};

Pose random_pose(Random& random, double distance) {
  Pose pose;
  for (int i = 0; i < 3; ++i) pose.eye[i] = uniform(random, -distance, distance);
  pose.target = pose.eye + uniform(random, 0.1, 100.0) * tests::random_direction(random);
  pose.up = uniform(random, 0.1, 10.0) * tests::random_direction(random);
  return pose;
}

bool inside(const View& view, const dvec3& p) {
  for (const Plane& plane : frustum_planes(view.clip_from_world(), view.clip_depth()))
    if (!(evaluate(plane, p) >= 0.0)) return false;
  return true;
}

void expect_orthonormal(const dmat4& m, double tolerance) {
  const dmat3 r(m);
  const dmat3 product = glm::transpose(r) * r;
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(product[c][i], c == i ? 1.0 : 0.0, tolerance);
  EXPECT_NEAR(glm::determinant(r), 1.0, tolerance);
}

TEST(View, PerspectiveKeepsWhatItsFormulaSays) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Pose pose = random_pose(random, 1000.0);
    const double fovy = uniform(random, 0.05, 3.0), aspect = uniform(random, 0.2, 4.0);
    const double near = uniform(random, 0.01, 1.0), far = seed % 3 == 0 ? kInfiniteFar : near * uniform(random, 2, 1e4);
    const View view = View::perspective(pose, fovy, aspect, near, far).value();
    const EyeFrame frame(pose);
    for (int i = 0; i < 200; ++i) {
      const double ahead = near * std::pow(10.0, uniform(random, -1.0, 5.0));
      const double x = uniform(random, -1.5, 1.5), y = uniform(random, -1.5, 1.5);  // in half widths
      const double half = ahead * std::tan(0.5 * fovy);
      const double margin = std::min({std::abs(1 - std::abs(x)), std::abs(1 - std::abs(y)), std::abs(ahead / near - 1),
                                      std::isfinite(far) ? std::abs(ahead / far - 1) : 1.0});
      if (margin < 1e-6) continue;
      const bool expected = std::abs(x) < 1 && std::abs(y) < 1 && ahead > near && ahead < far;
      EXPECT_EQ(inside(view, frame.world(pose, x * half * aspect, y * half, ahead)), expected);
    }
  }
}

TEST(View, OrthographicKeepsWhatItsFormulaSays) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Pose pose = random_pose(random, 1000.0);
    const double height = uniform(random, 0.1, 500.0), aspect = uniform(random, 0.2, 4.0);
    const double near = uniform(random, -100.0, 100.0), far = near + uniform(random, 0.1, 1000.0);
    const View view = View::orthographic(pose, height, aspect, near, far).value();
    EXPECT_TRUE(view.orthographic());
    const EyeFrame frame(pose);
    for (int i = 0; i < 200; ++i) {
      const double x = uniform(random, -1.5, 1.5), y = uniform(random, -1.5, 1.5), z = uniform(random, -0.5, 1.5);
      if (std::min({std::abs(1 - std::abs(x)), std::abs(1 - std::abs(y)), std::abs(z), std::abs(1 - z)}) < 1e-6)
        continue;
      const bool expected = std::abs(x) < 1 && std::abs(y) < 1 && z > 0 && z < 1;
      const dvec3 p = frame.world(pose, 0.5 * x * height * aspect, 0.5 * y * height, near + z * (far - near));
      EXPECT_EQ(inside(view, p), expected);
    }
  }
}

TEST(View, AsymmetricWindowMapsToTheWholeScreen) {
  const Pose pose{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const View view = View::asymmetric(pose, -1.0, 3.0, 0.5, 2.0, 2.0, 50.0).value();
  EXPECT_FALSE(view.orthographic());
  const auto screen = [&](double x, double up, double ahead) {
    const dvec4 c = view.clip_from_world() * dvec4(x, ahead, up, 1.0);
    return dvec2(c) / c.w;
  };
  for (const double scale : {1.0, 10.0}) {
    const dvec2 low = screen(-1.0 * scale, 0.5 * scale, 2.0 * scale),
                high = screen(3.0 * scale, 2.0 * scale, 2 * scale);
    EXPECT_NEAR(low.x, -1.0, 1e-12);
    EXPECT_NEAR(low.y, -1.0, 1e-12);
    EXPECT_NEAR(high.x, 1.0, 1e-12);
    EXPECT_NEAR(high.y, 1.0, 1e-12);
  }
  // Halves of a window together are the whole: a tiled display loses nothing between its tiles.
  const View left = View::asymmetric(pose, -1.0, 1.0, -1.0, 1.0, 1.0).value();
  const View right = View::asymmetric(pose, 1.0, 3.0, -1.0, 1.0, 1.0).value();
  const Plane l = frustum_planes(left.clip_from_world(), left.clip_depth())[kRight];
  const Plane r = frustum_planes(right.clip_from_world(), right.clip_depth())[kLeft];
  EXPECT_NEAR(glm::dot(glm::normalize(l.normal), glm::normalize(r.normal)), -1.0, 1e-12);
}

TEST(View, InfiniteFarPlaneIsAbsent) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const View view = View::perspective(random_pose(random, 1e6), 1.0, 1.5, 0.1).value();
    const auto planes = frustum_planes(view.clip_from_world(), view.clip_depth());
    EXPECT_EQ(planes[kFar].normal, dvec3(0.0));
    EXPECT_GT(planes[kFar].offset, 0.0);
    // The classic form of the same projection (E. Lengyel's P): z' = -z - 2 n.
    dmat4 classic = view.clip_from_eye();
    classic[2][2] = -1.0;
    classic[3][2] = -0.2;
    const View other = View::from_matrices(view.eye_from_world(), classic, ClipDepth::kMinusOneToOne).value();
    const auto same = frustum_planes(other.clip_from_world(), other.clip_depth());
    EXPECT_EQ(same[kFar].normal, dvec3(0.0));
    EXPECT_GT(same[kFar].offset, 0.0);
  }
}

TEST(View, BothDepthConventionsCutTheSameVolume) {
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = random_pose(random, 100.0);
    const double near = uniform(random, 0.1, 1.0), far = near + uniform(random, 1.0, 100.0);
    const View view = View::perspective(pose, 1.0, 1.5, near, far).value();
    dmat4 classic = view.clip_from_eye();
    classic[2][2] = -(far + near) / (far - near);
    classic[3][2] = -2.0 * far * near / (far - near);
    const View other = View::from_matrices(view.eye_from_world(), classic, ClipDepth::kMinusOneToOne).value();
    EXPECT_EQ(other.clip_depth(), ClipDepth::kMinusOneToOne);
    const auto a = frustum_planes(view.clip_from_world(), view.clip_depth());
    const auto b = frustum_planes(other.clip_from_world(), other.clip_depth());
    for (int p = 0; p < kFrustumPlaneCount; ++p) {
      const double la = glm::length(a[p].normal), lb = glm::length(b[p].normal);
      EXPECT_LT(glm::length(a[p].normal / la - b[p].normal / lb), 1e-12) << p;
      EXPECT_NEAR(a[p].offset / la, b[p].offset / lb, 1e-9) << p;
    }
  }
}

TEST(View, EyeComesBackFromTheMatrices) {
  Random random(9);
  for (int i = 0; i < 200; ++i) {
    const Pose pose = random_pose(random, 1e7);
    const View view = View::perspective(pose, 1.0, 1.5, 0.1).value();
    EXPECT_LT(glm::distance(view.eye(), pose.eye), 1e-7);
  }
}

TEST(View, LookAtIsARotationWhateverUpIs) {
  Random random(13);
  for (int i = 0; i < 500; ++i) {
    Pose pose = random_pose(random, 10.0);
    const dvec3 forward = glm::normalize(pose.target - pose.eye);
    const double tilt = i % 4 == 0 ? 0.0 : std::pow(10.0, uniform(random, -17.0, 0.0));
    pose.up = std::copysign(std::pow(10.0, uniform(random, -250.0, 250.0)), uniform(random, -1, 1)) *
              (forward + tilt * tests::random_direction(random));
    SCOPED_TRACE(testing::Message() << "case " << i << " tilt " << tilt);
    const auto eye = look_at(pose);
    ASSERT_TRUE(eye) << eye.error().message;
    expect_orthonormal(*eye, 1e-14);
    const dvec3 seen = dmat3(*eye) * forward;
    EXPECT_NEAR(seen.z, -1.0, 1e-14);
    // Up stays up, where it says anything.
    if (tilt > 1e-9) {
      EXPECT_GT((dmat3(*eye) * (pose.up / glm::max(std::abs(pose.up.x), std::abs(pose.up.y)))).y, 0.0);
    }
  }
}

TEST(View, UpParallelToTheLineOfSightOrZeroTakesAnotherAxis) {
  for (const dvec3& direction : {dvec3(0, 0, 1), dvec3(0, 0, -1), dvec3(1, 0, 0), dvec3(0, -1, 0), dvec3(1, 1, 1)})
    for (const dvec3& up : {direction, -direction, dvec3(0.0)}) {
      const auto eye = look_at({{1, 2, 3}, dvec3(1, 2, 3) + direction, up});
      ASSERT_TRUE(eye) << eye.error().message;
      expect_orthonormal(*eye, 1e-14);
    }
}

TEST(View, KeepsMillimetresTenThousandKilometresOut) {
  const dvec3 site(1e7, -1e7, 1e4);
  const Pose pose{site, site + dvec3(3, 4, 0.5), {0, 0, 1}};
  const View view = View::perspective(pose, 1.0, 1.0, 0.1).value();
  const EyeFrame frame(pose);
  const auto planes = frustum_planes(view.clip_from_world(), view.clip_depth());
  const double half = std::tan(0.5);
  for (const double ahead : {1.0, 10.0, 100.0}) {
    const double edge = ahead * half;
    EXPECT_GT(evaluate(planes[kRight], frame.world(pose, edge - 1e-5, 0, ahead)), 0.0);
    EXPECT_LT(evaluate(planes[kRight], frame.world(pose, edge + 1e-5, 0, ahead)), 0.0);
    EXPECT_GT(evaluate(planes[kBottom], frame.world(pose, 0, -edge + 1e-5, ahead)), 0.0);
    EXPECT_LT(evaluate(planes[kBottom], frame.world(pose, 0, -edge - 1e-5, ahead)), 0.0);
  }
}

TEST(View, RowsComeFromTheProductAsRounded) {
  Random random(17);
  const View view = View::perspective(random_pose(random, 1e5), 1.0, 1.5, 0.1, 100.0).value();
  const dmat4 m = view.clip_from_world();
  const auto planes = frustum_planes(m, view.clip_depth());
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(planes[kLeft].normal[c], m[c][3] + m[c][0]);
    EXPECT_EQ(planes[kTop].normal[c], m[c][3] - m[c][1]);
    EXPECT_EQ(planes[kFar].normal[c], m[c][2]);
  }
  EXPECT_EQ(planes[kNear].offset, m[3][3] - m[3][2]);
}

// --- bad input -------------------------------------------------------------------------------------------------------

template <class T>
void expect_error(const Expected<T>& result, const std::string& part) {
  ASSERT_FALSE(result) << "expected an error with: " << part;
  EXPECT_NE(result.error().message.find(part), std::string::npos) << result.error().message;
}

TEST(View, RefusesBadPoses) {
  const Pose good;
  for (const double bad : {kNan, kInf, -kInf})
    for (int i = 0; i < 3; ++i) {
      Pose pose = good;
      pose.eye[i] = bad;
      expect_error(View::perspective(pose, 1.0, 1.0, 0.1), "must be finite");
      pose = good;
      pose.target[i] = bad;
      expect_error(View::orthographic(pose, 1.0, 1.0, 0.1, 1.0), "must be finite");
      pose = good;
      pose.up[i] = bad;
      expect_error(look_at(pose), "must be finite");
    }
  Pose same = good;
  same.target = same.eye;
  expect_error(View::perspective(same, 1.0, 1.0, 0.1), "eye and target must differ");
  Pose far = good;
  far.eye = dvec3(-1.5e308);
  far.target = dvec3(1.5e308);
  EXPECT_FALSE(look_at(far)) << "their distance overflows";
}

TEST(View, RefusesBadPerspectiveNumbers) {
  const Pose pose;
  for (const double fovy : {0.0, -1.0, kPi, 4.0, kNan, kInf})
    expect_error(View::perspective(pose, fovy, 1.0, 0.1), "fovy must lie between 0 and pi");
  for (const double aspect : {0.0, -1.0, kNan, kInf})
    expect_error(View::perspective(pose, 1.0, aspect, 0.1), "aspect must be positive");
  for (const double near : {0.0, -1.0, kNan, kInf})
    expect_error(View::perspective(pose, 1.0, 1.0, near), "0 < near < far");
  for (const double far : {0.1, 0.05, -kInf, kNan, 0.0})
    expect_error(View::perspective(pose, 1.0, 1.0, 0.1, far), "0 < near < far");
  expect_error(View::asymmetric(pose, 1, 1, -1, 1, 0.1), "left < right");
  expect_error(View::asymmetric(pose, -1, 1, 1, -1, 0.1), "bottom < top");
  expect_error(View::asymmetric(pose, kNan, 1, -1, 1, 0.1), "left < right");
  expect_error(View::asymmetric(pose, -kInf, 1, -1, 1, 0.1), "left < right");
}

TEST(View, RefusesBadOrthographicNumbers) {
  const Pose pose;
  for (const double bad : {0.0, -1.0, kNan, kInf}) {
    expect_error(View::orthographic(pose, bad, 1.0, 0.0, 1.0), "height and aspect must be positive");
    expect_error(View::orthographic(pose, 1.0, bad, 0.0, 1.0), "height and aspect must be positive");
  }
  for (const double far : {0.0, -1.0, kNan, kInf})
    expect_error(View::orthographic(pose, 1.0, 1.0, 0.0, far), "near < far must hold, both finite");
  expect_error(View::orthographic(pose, 1.0, 1.0, -kInf, 1.0), "both finite");
  EXPECT_TRUE(View::orthographic(pose, 1.0, 1.0, -10.0, -5.0)) << "either may be negative";
}

TEST(View, RefusesMatricesThatAreNotFinite) {
  for (const double bad : {kNan, kInf})
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) {
        dmat4 m(1.0);
        m[c][r] = bad;
        expect_error(View::from_matrices(m, dmat4(1.0), ClipDepth::kMinusOneToOne), "must be finite");
        expect_error(View::from_matrices(dmat4(1.0), m, ClipDepth::kMinusOneToOne), "must be finite");
      }
  expect_error(View::from_matrices(dmat4(1e200), dmat4(1e200), ClipDepth::kMinusOneToOne), "must be finite");
  EXPECT_TRUE(View::from_matrices(dmat4(1.0), dmat4(1.0), ClipDepth::kMinusOneToOne));
}

/// The projection of a view of reversed depth for another depth.
dmat4 for_depth(dmat4 clip, ClipDepth depth) {
  const double near = near_depth(depth), far = far_depth(depth);
  for (int c = 0; c < 4; ++c) clip[c][2] = far * clip[c][3] + (near - far) * clip[c][2];
  return clip;
}

bool grows(ClipDepth depth) {
  return far_depth(depth) > near_depth(depth);
}

constexpr ClipDepth kDepths[] = {ClipDepth::kReversedZeroToOne, ClipDepth::kMinusOneToOne, ClipDepth::kZeroToOne};

TEST(View, RefusesAProjectionOfAnotherDepth) {
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(testing::Message() << "round " << i << " of seed 11");
    const Pose pose = random_pose(random, 1e4);
    const double near = uniform(random, 0.1, 10.0), far = i % 4 == 0 ? kInfiniteFar : near * uniform(random, 1.1, 1e6);
    const View view = i % 3 == 0   ? *View::asymmetric(pose, -0.1, 0.3, 0.2, 0.25, near, far)
                      : i % 3 == 1 ? *View::perspective(pose, uniform(random, 0.01, 2.5), 1.5, near, far)
                                   : *View::orthographic(pose, 3.0, 1.5, -near, near);
    dmat4 mirror(1.0);
    if (i % 5 == 0) mirror[1][1] = -1.0;  // y downwards, as of Vulkan
    for (const ClipDepth made : kDepths)
      for (const ClipDepth stated : kDepths) {
        const dmat4 clip = for_depth(mirror * view.clip_from_eye(), made);
        const auto given = View::from_matrices(view.eye_from_world(), clip, stated);
        const auto combined = View::from_matrices(dmat4(1.0), clip * view.eye_from_world(), stated);
        if (grows(made) == grows(stated)) {
          EXPECT_TRUE(given && combined);
          continue;
        }
        expect_error(given, grows(stated) ? "its ClipDepth says that it grows" : "its ClipDepth says that it falls");
        EXPECT_EQ(bool(combined), view.orthographic()) << "which way a combined parallel projection looks is not known";
      }
  }
}

/// Where rounding or an unusual matrix leaves it open.
TEST(View, TakesMatricesThatDoNotTellTheirDepth) {
  const View view = *View::perspective({{3, -8, 2}, {0, 0, 0}, {0, 0, 1}}, 0.8, 1.5, 0.1, 1e3);
  const View below = *View::orthographic({{3, 8, -2}, {3, 8, 5}, {0, 1, 0}}, 4.0, 1.5, -10.0, 10.0);
  dmat4 oblique = view.clip_from_eye(), constant = view.clip_from_eye();
  oblique[0][2] = 0.3;
  for (int c = 0; c < 4; ++c) constant[c][2] = 0.5 * constant[c][3];
  for (const ClipDepth depth : kDepths) {
    EXPECT_TRUE(View::from_matrices(view.eye_from_world(), oblique, depth));
    EXPECT_TRUE(View::from_matrices(view.eye_from_world(), constant, depth));
    EXPECT_TRUE(View::from_matrices(dmat4(1.0), below.clip_from_world(), depth));
    EXPECT_TRUE(View::from_matrices(dmat4(1.0), dmat4(0.0), depth));
    EXPECT_TRUE(View::from_matrices(dmat4(1.0), dmat4(1e-300), depth));
  }
  // What floats make of a camera 10 000 km away is not refused for its near plane of 10 cm.
  const View away = *View::perspective({{1e7, 2e7, 0}, {1e7, 2e7 + 1, 1}, {0, 0, 1}}, 0.8, 1.5, 0.1, 1e3);
  for (const ClipDepth made : kDepths) {
    const dmat4 rounded(glm::mat4(for_depth(away.clip_from_eye(), made) * away.eye_from_world()));
    EXPECT_TRUE(View::from_matrices(dmat4(1.0), rounded, made));
  }
}

TEST(View, RefusesAProjectionInPlaceOfAnEyeMatrix) {
  const View view = View::perspective({{3, -8, 2}, {0, 0, 0}, {0, 0, 1}}, 0.8, 1.5, 0.1).value();
  const dmat4 combined = view.clip_from_world();
  expect_error(View::from_matrices(combined, dmat4(1.0), ClipDepth::kReversedZeroToOne), "must be affine");
  const auto given = View::from_matrices(dmat4(1.0), combined, ClipDepth::kReversedZeroToOne);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->clip_from_world(), combined);
}

TEST(View, StartsWithoutSectionsAndOnTheDefaultLayers) {
  const View view = View::perspective({}, 1.0, 1.0, 0.1).value();
  EXPECT_TRUE(view.sections.empty());
  EXPECT_EQ(view.section_mode, SectionMode::kIntersection);
  EXPECT_EQ(view.layers, kDefaultLayerMask);
}

// --- fitting ---------------------------------------------------------------------------------------------------------

/// All corners inside, centred, and two opposite borders touched, unless the eye is as near as it may be.
void expect_fitted(const AabbD& box, const dvec3& direction, double fovy, double aspect) {
  const auto view = View::fit(box, direction, fovy, aspect);
  ASSERT_TRUE(view) << view.error().message;
  const Pose pose = fitting_pose(box, direction, fovy, aspect);
  const double diagonal = glm::length(box.size()), from_origin = glm::length(box.centre());
  const dvec3 forward = glm::normalize(pose.target - pose.eye);
  const Seen seen = look_at_box(box, *view);
  // Poses are rounded where they stand; what that moves in the image grows towards the eye and with the lens.
  const double tangent = std::tan(0.5 * fovy), widest = std::min(tangent, tangent * aspect);
  const double rounding = 1e-15 * (from_origin + glm::length(pose.eye - box.centre()));
  const double tolerance = 1e-9 + 20.0 * rounding / (widest * seen.nearest) + 20.0 * rounding / diagonal;
  EXPECT_LE(glm::length(forward - glm::normalize(direction)), 1e-9 + 10.0 * rounding / diagonal);
  EXPECT_LE(std::max(seen.high.x, seen.high.y), 1.0 + tolerance);
  EXPECT_NEAR(seen.low.x + seen.high.x, 0.0, 2.0 * tolerance);
  EXPECT_NEAR(seen.low.y + seen.high.y, 0.0, 2.0 * tolerance);
  EXPECT_GE(seen.nearest, (0.01 - 1e-9) * diagonal - 20.0 * rounding);
  if (seen.nearest > (0.01 + 1e-9) * diagonal + 20.0 * rounding) {
    EXPECT_GE(std::max(seen.high.x, seen.high.y), 1.0 - tolerance);
  }
  EXPECT_NEAR(glm::dot(pose.target - box.centre(), forward), 0.0, 1e-9 * diagonal + 20.0 * rounding);
}

TEST(FittingPose, FillsTheImageWithTheBox) {
  Random random(7);
  int at_a_hundredth = 0;
  for (int i = 0; i < 3000; ++i) {
    SCOPED_TRACE("case " + std::to_string(i) + " of seed 7");
    const double far = std::pow(10.0, uniform(random, -3.0, 7.0)), size = std::pow(10.0, uniform(random, -2.0, 4.0));
    const dvec3 half = size * dvec3(uniform(random, 0.0, 1.0), uniform(random, 0.0, 1.0), uniform(random, 0.0, 1.0));
    const dvec3 centre = far * tests::random_direction(random);
    const double fovy = uniform(random, 0.05, 2.6), aspect = std::pow(10.0, uniform(random, -0.7, 0.7));
    const AabbD box{centre - half, centre + half};
    expect_fitted(box, uniform(random, 0.1, 10.0) * tests::random_direction(random), fovy, aspect);
    const Seen seen = look_at_box(box, View::fit(box, {1, 1, 1}, fovy, aspect).value());
    at_a_hundredth += seen.nearest < 0.0101 * glm::length(box.size());
  }
  EXPECT_GT(at_a_hundredth, 10) << "few wide lenses along diagonals";
}

TEST(FittingPose, LeavesRoomThatIsAskedFor) {
  const AabbD box{{-1, -2, -3}, {4, 5, 6}};
  for (const double filled : {0.25, 0.9, 1.0}) {
    const auto view = View::fit(box, kOverviewDirection, 0.8, 1.6, filled);
    ASSERT_TRUE(view);
    double reach = 0.0;
    for (int i = 0; i < 8; ++i) {
      const dvec4 p = view->clip_from_world() * dvec4(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                                      i & 4 ? box.max.z : box.min.z, 1.0);
      reach = std::max({reach, std::abs(p.x / p.w), std::abs(p.y / p.w)});
    }
    EXPECT_NEAR(reach, filled, 1e-9);
  }
  for (const double bad : {0.0, -1.0, 1.1, std::nan("")})
    EXPECT_FALSE(View::fit(box, kOverviewDirection, 0.8, 1.6, bad)) << bad;
}

TEST(FittingPose, LooksAlongEveryAxisAndFarFromTheOrigin) {
  for (const double far : {0.0, 1e3, 1e7})
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        dvec3 direction(0.0);
        direction[axis] = sign;
        const dvec3 centre(far, -far, 0.5 * far);
        expect_fitted({centre, centre + dvec3(100, 40, 20)}, direction, 0.8, 1.5);
        expect_fitted({centre, centre + dvec3(0.1, 0.04, 0.02)}, direction, 0.8, 1.5);
        expect_fitted({centre, centre + dvec3(1, 4, 20)}, direction + dvec3(1e-5, 1e-6, 1e-7), 0.8, 0.5);
        expect_fitted({centre, centre + dvec3(1, 4, 20)}, direction + dvec3(1e-9, 3e-10, 2e-9), 0.8, 0.5);
      }
}

TEST(FittingPose, FitsFlatBoxesAndLines) {
  for (int flat = 0; flat < 3; ++flat)
    for (int axis = 0; axis < 3; ++axis) {
      dvec3 plane(30, 20, 10), line(0.0), edge_on(0.0);
      plane[flat] = 0.0;
      line[flat] = 50.0;
      edge_on[axis] = 1.0;
      for (const dvec3& direction : {edge_on, kOverviewDirection}) {
        expect_fitted({dvec3(5.0), dvec3(5.0) + plane}, direction, 0.8, 1.5);
        if (flat != axis || direction != edge_on) expect_fitted({dvec3(5.0), dvec3(5.0) + line}, direction, 0.8, 1.5);
      }
      // A line along the line of sight is a point in the middle.
      const Seen end = look_at_box({dvec3(0.0), line}, View::fit({dvec3(0.0), line}, line, 0.8, 1.5).value());
      EXPECT_NEAR(end.nearest, 0.5, 1e-9);
      EXPECT_LE(std::max({-end.low.x, -end.low.y, end.high.x, end.high.y}), 1e-9);
    }
}

TEST(FittingPose, WhatHasNoSizeIsACube) {
  const auto same = [](const Pose& a, const Pose& b, double tolerance) {
    EXPECT_LE(glm::length(a.eye - b.eye), tolerance);
    EXPECT_LE(glm::length(a.target - b.target), tolerance);
  };
  const auto fitted = [](const AabbD& box) { return fitting_pose(box, kOverviewDirection, 0.8, 1.5); };
  const AabbD unit{dvec3(-1.0), dvec3(1.0)};
  same(fitted({}), fitted(unit), 0.0);
  for (const double far : {0.0, 1.0, 1e7}) {
    const dvec3 p(far, 2.0 * far, -far);
    same(fitted({p, p}), fitted({p - 1.0, p + 1.0}), 0.0);
    same(fitted({p, p + 1e-9}), fitted({p - 1.0, p + 1.0}), 1e-8);
  }
  expect_fitted({dvec3(-1e36), dvec3(1e36)}, kOverviewDirection, 0.8, 1.5);
  EXPECT_TRUE(View::fit({dvec3(1e36), dvec3(1e36)}, kOverviewDirection, 0.8, 1.5));
}

TEST(FittingPose, NothingOfTheBoxIsCutAway) {
  for (const double size : {1e-5, 1e-3, 1.0, 1e6}) {
    const AabbD box{dvec3(0.0), dvec3(size)};
    const View view = View::fit(box, {1, 1, 1}, 2.5, 1.0).value();
    for (const dvec3& p : {dvec3(0.0), dvec3(size)})
      for (const Plane& plane : frustum_planes(view.clip_from_world(), view.clip_depth()))
        EXPECT_GE(glm::dot(plane.normal, p) + plane.offset, 0.0) << size;
  }
}

TEST(FittingPose, ViewsRefuseBadNumbers) {
  const AabbD box{dvec3(0.0), dvec3(1.0)};
  for (const dvec3& bad : {dvec3(0.0), dvec3(kNan, 0, 1), dvec3(kInf, 0, 0)})
    expect_error(View::fit(box, bad, 0.8, 1.5), "direction must be finite and not zero");
  for (const double bad : {0.0, -1.0, kPi, kNan}) expect_error(View::fit(box, {0, 1, 0}, bad, 1.5), "fovy");
  for (const double bad : {0.0, -1.0, kInf, kNan}) expect_error(View::fit(box, {0, 1, 0}, 0.8, bad), "aspect");
  expect_error(View::fit({dvec3(0.0), dvec3(kInf)}, {0, 1, 0}, 0.8, 1.5), "bounds must be finite");
}

}  // namespace
}  // namespace sightline::core::view_test
