#include "sightline/apps/bench/losses/rules.h"

#include <algorithm>
#include <cmath>

namespace sightline::bench {
namespace {

using engine::ContributionMode;
using Measure = Rule::Measure;

struct NamedRule {
  const char* name;
  Measure measure;
  ContributionMode mode;
  std::vector<double> thresholds;
};

const std::vector<NamedRule>& named_rules() {
  static const std::vector<double> kAreas{0.25, 1.0, 4.0, 16.0, 64.0}, kLengths{1.0, 2.0, 4.0, 8.0, 16.0},
      kErrors{0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0};
  static const std::vector<NamedRule> kRules{{"drop", Measure::kSolid, ContributionMode::kDrop, kAreas},
                                             {"points", Measure::kSolid, ContributionMode::kPoints, kAreas},
                                             {"stochastic", Measure::kSolid, ContributionMode::kStochastic, kAreas},
                                             {"box", Measure::kBox, ContributionMode::kDrop, kAreas},
                                             {"osg", Measure::kOpenSceneGraph, ContributionMode::kDrop, kLengths},
                                             {"occt", Measure::kOpenCascade, ContributionMode::kDrop, kLengths},
                                             {"levels", Measure::kLevels, ContributionMode::kDrop, kErrors},
                                             {"both", Measure::kBoth, ContributionMode::kDrop, kAreas},
                                             {"chain", Measure::kChain, ContributionMode::kDrop, kErrors},
                                             {"primitives", Measure::kPrimitives, ContributionMode::kDrop, {0.0}}};
  return kRules;
}

}  // namespace

engine::LossConfig Rule::losses() const {
  engine::LossConfig losses;
  constexpr double kHardlySeen = 0.5;
  if (measure == Measure::kSolid || measure == Measure::kBoth) losses.min_projected_area = float(threshold);
  if (measure == Measure::kLevels) losses.lod_error = threshold;
  if (measure == Measure::kBoth) losses.lod_error = kHardlySeen;
  losses.contribution_mode = mode;
  return losses;
}

std::string name_of(const Rule& rule) {
  if (rule.measure == Measure::kNone) return "full";
  if (rule.measure == Measure::kSolid) return "solid, " + std::string(engine::name_of(rule.mode));
  return std::ranges::find(named_rules(), rule.measure, &NamedRule::measure)->name;
}

const std::vector<std::string>& rule_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const NamedRule& rule : named_rules()) names.push_back(rule.name);
    return names;
  }();
  return kNames;
}

std::vector<Rule> rules_of(const std::vector<std::string>& names) {
  std::vector<Rule> rules{{}};
  for (const NamedRule& rule : named_rules())
    if (std::ranges::find(names, rule.name) != names.end())
      for (const double threshold : rule.thresholds) rules.push_back({rule.measure, rule.mode, threshold});
  return rules;
}

double least_diagonal(const Rule& rule, const core::View& view, int width, int height) {
  const double w = 0.5 * width, h = 0.5 * height;
  const double fx = w * view.clip_from_eye()[0][0], fy = h * view.clip_from_eye()[1][1];
  if (rule.measure == Measure::kOpenCascade) return rule.threshold / fy;
  // OpenSceneGraph's, with the viewport's part in that function's scale.
  return 2.0 * rule.threshold / std::sqrt(2.0 * (fx * fx + fy * fy + w * w + h * h));
}

void keep_large(const core::View& view, double least, const core::Snapshot& snapshot, const core::VisibleSet& in,
                core::VisibleSet& kept) {
  const core::ItemBounds& bounds = snapshot.bounds();
  const core::dmat4 rows = glm::transpose(view.eye_from_world());
  const core::vec3 axis(-core::dvec3(rows[2]));
  const auto offset = float(-glm::dot(core::dvec3(rows[2]), bounds.origin) - rows[2].w);
  const auto square = float(least * least);
  kept.clear();
  kept.generation = in.generation;
  const auto visit = [&](core::Slot slot) {
    if (bounds.vacant(slot)) return;
    const core::Aabb box = bounds.box(slot);
    const core::vec3 size = box.max - box.min;
    const float distance = glm::dot(axis, 0.5f * (box.min + box.max)) + offset;
    if (glm::dot(size, size) >= square * distance * distance || snapshot.kind(slot) == core::Kind::kLine)
      kept.single_slots.push_back(slot);
  };
  in.for_each_slot(visit);
  std::sort(kept.single_slots.begin(), kept.single_slots.end());
}

}  // namespace sightline::bench
