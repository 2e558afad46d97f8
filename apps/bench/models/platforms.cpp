#include "sightline/apps/bench/models/platforms.h"

#include <algorithm>

namespace sightline::bench {

Mix mix_of(core::Kind kind) {
  switch (kind) {
    case core::Kind::kCylinder:
      return kCylinders;
    case core::Kind::kSnout:
      return kCones;
    case core::Kind::kCircularTorus:
      return kTori;
    default:
      return kMeshes;
  }
}

std::uint64_t scaled(std::uint64_t objects, double scale) {
  constexpr std::uint64_t kFewest = 1000;
  return std::max(kFewest, std::uint64_t(double(objects) * scale));
}

void mix_kinds(const Platform& platform, std::vector<std::uint8_t>& kinds) {
  constexpr std::size_t kKinds = 4;
  std::array<std::uint64_t, kKinds> wanted{}, have{}, missing{}, surplus{};
  std::uint64_t rest = kinds.size();
  for (std::size_t k = 0; k < kMeshes; ++k) {
    wanted[k] = platform.counts[k] * kinds.size() / platform.objects();
    rest -= wanted[k];
  }
  wanted[kMeshes] = rest;
  for (const std::uint8_t k : kinds) ++have[k];
  std::uint64_t to_give = 0;
  for (std::size_t k = 0; k < kKinds; ++k) {
    surplus[k] = have[k] > wanted[k] ? have[k] - wanted[k] : 0;
    missing[k] = wanted[k] > have[k] ? wanted[k] - have[k] : 0;
    to_give += missing[k];
  }
  // As lines are drawn: item i of kind k changes when the share surplus / have has gained a whole; the kind it takes is
  // the one that lags most.
  std::array<std::uint64_t, kKinds> seen{}, given{};
  std::uint64_t changed = 0;
  for (std::uint8_t& kind : kinds) {
    const std::uint64_t n = seen[kind]++;
    if ((n + 1) * surplus[kind] / have[kind] == n * surplus[kind] / have[kind]) continue;
    ++changed;
    std::size_t next = kKinds;
    std::uint64_t lag = 0;
    for (std::size_t k = 0; k < kKinds; ++k) {
      const std::uint64_t due = changed * missing[k];
      if (given[k] < missing[k] && due >= given[k] * to_give && (next == kKinds || due - given[k] * to_give > lag)) {
        next = k;
        lag = due - given[k] * to_give;
      }
    }
    ++given[next];
    kind = std::uint8_t(next);
  }
}

}  // namespace sightline::bench
