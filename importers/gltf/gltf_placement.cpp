#include "sightline/importers/gltf/internal/gltf_placement.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace sightline::importers {
namespace {

using core::dmat3;

/// Rotation (a quaternion x y z w) and scale of a map that is_decomposable(). A mirrored one has a negative x scale.
struct Turn {
  float rotation[4], scale[3];
};
Turn decomposed(const dmat3& m) {
  Turn turn;
  dmat3 r;
  const double sign = glm::determinant(m) < 0.0 ? -1.0 : 1.0;
  for (int i = 0; i < 3; ++i) {
    const double scale = glm::length(m[i]) * (i == 0 ? sign : 1.0);
    turn.scale[i] = float(scale);
    r[i] = m[i] / scale;
  }
  // Shepperd's method: divides by the largest of the four.
  const double trace = r[0][0] + r[1][1] + r[2][2];
  double q[4];
  int most = 3;
  double largest = trace;
  for (int i = 0; i < 3; ++i)
    if (r[i][i] > largest) largest = r[i][i], most = i;
  if (most == 3) {
    q[3] = 0.5 * std::sqrt(1.0 + trace);
    for (int i = 0; i < 3; ++i) q[i] = (r[(i + 1) % 3][(i + 2) % 3] - r[(i + 2) % 3][(i + 1) % 3]) / (4.0 * q[3]);
  } else {
    const int i = most, j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = 0.5 * std::sqrt(1.0 + r[i][i] - r[j][j] - r[k][k]);
    q[j] = (r[i][j] + r[j][i]) / (4.0 * q[i]);
    q[k] = (r[i][k] + r[k][i]) / (4.0 * q[i]);
    q[3] = (r[j][k] - r[k][j]) / (4.0 * q[i]);
  }
  const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  for (int i = 0; i < 4; ++i) turn.rotation[i] = float(q[i] / length);
  return turn;
}

}  // namespace

bool is_decomposable(const dmat3& m) {
  constexpr double kSkew = 1e-6;
  double lengths[3];
  for (int i = 0; i < 3; ++i) lengths[i] = glm::length(m[i]);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (!(lengths[i] > 0.0) || std::abs(glm::dot(m[i], m[j])) > kSkew * lengths[i] * lengths[j]) return false;
  }
  return true;
}

std::string instance_attributes(GltfOutput& output, std::span<const core::Affine> placements) {
  std::vector<float> translations, rotations, scales;
  for (const core::Affine& placement : placements) {
    const Turn turn = decomposed(placement.linear);
    for (int c = 0; c < 3; ++c) translations.push_back(float(placement.origin[c]));
    rotations.insert(rotations.end(), std::begin(turn.rotation), std::end(turn.rotation));
    scales.insert(scales.end(), std::begin(turn.scale), std::end(turn.scale));
  }
  return fmt::format("\"TRANSLATION\":{},\"ROTATION\":{},\"SCALE\":{}", output.numbers(translations, 3),
                     output.numbers(rotations, 4), output.numbers(scales, 3));
}

}  // namespace sightline::importers
