#include "exact_pairs.h"

#include <cmath>
#include <cstdio>

#include "recorded_view.h"
#include "sightline/tests/culling/box_view_pairs.h"

namespace sightline::tests {
namespace {

using core::AabbD;
using core::dvec3;

/// The block's boxes in double, and two more far out, in whose middle the origin lies: a culler takes that middle as
/// its own, so coordinates that are close calls as floats stay so.
std::vector<AabbD> pinned(const PairBlock& block) {
  const dvec3 origin = glm::round(block.origin);
  std::vector<AabbD> boxes;
  double reach = 1.0;
  for (const core::Aabb& box : block.boxes) {
    boxes.push_back(box.empty() ? AabbD() : AabbD{dvec3(box.min) + block.origin, dvec3(box.max) + block.origin});
    if (box.empty()) continue;
    for (int axis = 0; axis < 3; ++axis)
      reach = std::max(
          {reach, std::abs(boxes.back().min[axis] - origin[axis]), std::abs(boxes.back().max[axis] - origin[axis])});
  }
  const double far = std::exp2(std::ceil(std::log2(reach)));
  boxes.push_back({origin - far, origin - far});
  boxes.push_back({origin + far, origin + far});
  return boxes;
}

}  // namespace

bool write_pairs(const std::filesystem::path& file, std::uint64_t pairs, std::uint64_t batch) {
  RecordWriter out(file);
  for (std::size_t number = 0; number < kPairFamilies.size(); ++number) {
    const PairFamily& family = kPairFamilies[number];
    const double wanted = family.share * double(pairs);
    for (std::uint64_t i = 0; double(i * kBlockBoxes * kBlockViews) < wanted; ++i) {
      // A place in the generators' sequence that no other batch has.
      Random random((std::uint64_t(number) << 48) + (batch << 24) + i);
      const PairBlock block = family.make(random);
      out.text(std::string(family.name) + ", batch " + std::to_string(batch) + ", block " + std::to_string(i));
      out.array(numbers_of(pinned(block)));
      out.numbers({double(block.views.size())});
      for (const core::View& view : block.views) write_view(out, view);
    }
  }
  return out.close();
}

bool check_pairs(const std::filesystem::path& pairs, const std::filesystem::path& answers) {
  RecordReader asked(pairs), answered(answers);
  std::uint64_t count = 0, kept = 0, extra = 0, rationals = 0, lost = 0;
  while (asked.more()) {
    const std::string name = asked.text();
    const std::vector<double> numbers = asked.array<double>(), views = asked.array<double>();
    if (views.size() != 1) return false;
    for (int v = 0; v < int(views[0]); ++v) {
      const auto view = read_view(asked);
      if (!view || !answered.more()) {
        std::fprintf(stderr, "%s, view %d: no answer\n", name.c_str(), v);
        return false;
      }
      const std::span<const AabbD> boxes = boxes_of(numbers);
      std::vector<bool> found(boxes.size());
      for (const std::uint32_t index : answered.array<std::uint32_t>()) found.at(index) = true;
      ExactVolume exact(*view);
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const bool expected = exact.passes(boxes[i]);
        ++count;
        kept += found[i];
        extra += found[i] && !expected;
        if (found[i] || !expected) continue;
        if (++lost <= 10) std::fprintf(stderr, "%s, view %d: box %zu is lost\n", name.c_str(), v, i);
      }
      rationals += exact.decided_in_rationals;
    }
  }
  const auto ull = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf("%llu pairs, %llu kept, %llu lost, %llu extra, %llu planes decided in rationals\n", ull(count), ull(kept),
              ull(lost), ull(extra), ull(rationals));
  return count > 0 && lost == 0 && !answered.more();
}

}  // namespace sightline::tests
