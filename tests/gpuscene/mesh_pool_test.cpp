// Packed normals, against a twin of what mesh.vert unpacks.
#include "sightline/gpuscene/internal/mesh_pool.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace sightline::mesh_pool_test {
namespace {

using core::dvec3;
using core::vec3;
using gpuscene::kNoNormal;
using gpuscene::pack_normal;

dvec3 unpacked(std::uint32_t word) {
  const auto part = [](std::uint32_t bits) { return std::max(double(std::int16_t(bits)) / 32767.0, -1.0); };
  double x = part(word & 0xffffu), y = part(word >> 16);
  const double z = 1.0 - std::abs(x) - std::abs(y), fold = std::max(-z, 0.0);
  x += x < 0.0 ? fold : -fold;
  y += y < 0.0 ? fold : -fold;
  return glm::normalize(dvec3(x, y, z));
}

TEST(PackNormal, KeepsTheDirection) {
  std::mt19937_64 random(3);
  std::normal_distribution<float> component;
  std::vector<vec3> normals;
  for (int i = 0; i < 100'000; ++i) normals.emplace_back(component(random), component(random), component(random));
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0) normals.emplace_back(7e-3f * float(x), 7e-3f * float(y), 7e-3f * float(z));
  for (const vec3& n : normals) {
    const std::uint32_t word = pack_normal(n);
    ASSERT_NE(word, kNoNormal);
    ASSERT_LT(glm::length(unpacked(word) - glm::normalize(dvec3(n))), 7e-5) << n.x << ' ' << n.y << ' ' << n.z;
  }
}

TEST(PackNormal, SaysWhatHasNoDirection) {
  EXPECT_EQ(pack_normal(vec3(0.0f)), kNoNormal);
  EXPECT_EQ(pack_normal(vec3(std::numeric_limits<float>::quiet_NaN(), 0.0f, 1.0f)), kNoNormal);
  EXPECT_EQ(pack_normal(vec3(std::numeric_limits<float>::infinity(), 0.0f, 1.0f)), kNoNormal);
}

}  // namespace
}  // namespace sightline::mesh_pool_test
