#include "sightline/lod/internal/solid_shells.h"

#include <algorithm>
#include <cmath>

#include "sightline/core/internal/disjoint_sets.h"
#include "sightline/core/internal/hash.h"
#include "sightline/core/mesh.h"

namespace sightline::lod {
namespace {

using core::dvec3;
using core::mixed;
using core::vec3;
using Indices = std::span<const std::uint32_t>;

constexpr int kRounds = 8;          // of the search for a centre that sees the whole shell
constexpr double kStep = 1.2;       // step length, relative to the distance to the plane
constexpr double kFlatness = 1e-9;  // smaller heights over a plane, relative to a corner's distance, are rounding

struct Shell {
  std::uint64_t balance = 0;  // sum over its edges; 0: closed
  dvec3 sum{0.0};             // of all corners
  std::uint32_t corners = 0;
  dvec3 centre{0.0};
  bool seen = true;  // the centre sees the whole shell
  bool undecided = true;
  bool solid() const { return !undecided && balance == 0; }
};

/// Returns the shell of each triangle.
std::vector<std::uint32_t> find_shells(Indices corners, std::size_t positions, std::vector<Shell>& shells) {
  core::DisjointSets sets(positions);
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    sets.merge(corners[i], corners[i + 1]);
    sets.merge(corners[i], corners[i + 2]);
  }
  std::vector<std::uint32_t> number(positions, 0xffffffffu), shell_of(corners.size() / 3);
  for (std::size_t t = 0; t < shell_of.size(); ++t) {
    std::uint32_t& shell = number[sets.find(corners[3 * t])];
    if (shell == 0xffffffffu) {
      shell = std::uint32_t(shells.size());
      shells.emplace_back();
    }
    shell_of[t] = shell;
  }
  return shell_of;
}

void gather(Indices corners, std::span<const vec3> positions, Indices shell_of, std::vector<Shell>& shells) {
  for (std::size_t t = 0; t < shell_of.size(); ++t) {
    Shell& shell = shells[shell_of[t]];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = corners[3 * t + k], b = corners[3 * t + (k + 1) % 3];
      shell.balance += mixed(a << 32 | b) - mixed(b << 32 | a);
      shell.sum += dvec3(positions[a]);
    }
    shell.corners += 3;
  }
  for (Shell& shell : shells) shell.centre = shell.sum / double(shell.corners);
}

/// For each triangle that has a shell's centre in front of it, moves the centre behind it. A centre that did not have
/// to move sees its whole shell.
void relax(Indices corners, std::span<const vec3> positions, Indices shell_of, std::vector<Shell>& shells) {
  for (std::size_t t = 0; t < shell_of.size(); ++t) {
    Shell& shell = shells[shell_of[t]];
    if (!shell.undecided || shell.balance != 0) continue;
    const dvec3 a(positions[corners[3 * t]]), b(positions[corners[3 * t + 1]]), c(positions[corners[3 * t + 2]]);
    const dvec3 normal = glm::cross(b - a, c - a), reach = a - shell.centre;
    const double height = glm::dot(normal, reach), square = glm::dot(normal, normal);
    if (height >= 0.0 || height * height <= kFlatness * kFlatness * square * glm::dot(reach, reach)) continue;
    shell.seen = false;
    shell.centre += kStep * height / square * normal;
  }
  for (Shell& shell : shells) {
    shell.undecided &= !shell.seen;
    shell.seen = true;
  }
}

}  // namespace

std::uint32_t solid_shells_first(std::span<const vec3> positions, std::span<std::uint32_t> indices) {
  const std::vector<std::uint32_t> welded = core::weld(positions);
  std::vector<std::uint32_t> corners(indices.size());
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = welded[indices[i]];
  std::vector<Shell> shells;
  const std::vector<std::uint32_t> shell_of = find_shells(corners, positions.size(), shells);
  gather(corners, positions, shell_of, shells);
  for (int round = 0; round < kRounds; ++round) relax(corners, positions, shell_of, shells);

  std::vector<std::uint32_t> others;
  std::size_t solid = 0;
  for (std::size_t t = 0; t < shell_of.size(); ++t)
    for (std::size_t k = 3 * t; k < 3 * t + 3; ++k)
      if (shells[shell_of[t]].solid()) {
        indices[solid++] = indices[k];
      } else {
        others.push_back(indices[k]);
      }
  std::copy(others.begin(), others.end(), indices.begin() + std::ptrdiff_t(solid));
  return std::uint32_t(solid);
}

}  // namespace sightline::lod
