#include "sightline/apps/viewpoints/bcf_lines.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace sightline::apps {
namespace {

using Line = std::array<core::dvec3, 2>;

void add_lines_of(const Markup& markup, const core::dvec3& ahead, std::vector<Line>& lines) {
  for (const auto& stroke : strokes(markup, ahead))
    for (std::size_t i = 1; i < stroke.size(); ++i) lines.push_back({stroke[i - 1], stroke[i]});
}

std::vector<Line> lines_of(const Markup& markup, const core::dvec3& ahead) {
  std::vector<Line> lines;
  add_lines_of(markup, ahead, lines);
  return lines;
}

core::dvec3 ahead_of(const Viewpoint& view) {
  return glm::normalize(view.pose.target - view.pose.eye);
}

/// Lines of a file, of which some are taken.
class Lines {
 public:
  explicit Lines(const Node& root) {
    for (const Node& node : root.child("Lines").children("Line")) {
      const auto from = xyz_of(node.child("StartPoint")), to = xyz_of(node.child("EndPoint"));
      if (!from || !to) continue;
      by_place_.emplace(place_of({*from, *to}), all_.size());
      all_.push_back({*from, *to});
    }
  }

  /// Takes all of these, or none where one is missing.
  bool take(const std::vector<Line>& wanted) {
    std::vector<ByPlace::node_type> taken;
    for (const Line& line : wanted) {
      const auto found = by_place_.find(place_of(line));
      if (found == by_place_.end()) {
        for (auto& node : taken) by_place_.insert(std::move(node));
        return false;
      }
      taken.push_back(by_place_.extract(found));
    }
    return true;
  }

  std::vector<Markup> rest() const {
    std::vector<std::size_t> left;
    for (const auto& [place, index] : by_place_) left.push_back(index);
    std::sort(left.begin(), left.end());
    std::vector<Markup> markups;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const auto& [from, to] = all_[left[i]];
      if (i > 0 && left[i] == left[i - 1] + 1 && markups.back().points.back() == from)
        markups.back().points.push_back(to);
      else
        markups.push_back({Markup::Kind::kLine, {from, to}, ""});
    }
    return markups;
  }

 private:
  using ByPlace = std::multimap<std::array<double, 6>, std::size_t>;

  static std::array<double, 6> place_of(const Line& line) {
    const auto& [from, to] = line;
    return {from.x, from.y, from.z, to.x, to.y, to.z};
  }

  std::vector<Line> all_;
  ByPlace by_place_;
};

}  // namespace

void add_lines(Node root, const Viewpoint& view) {
  std::vector<Line> lines;
  for (const Measurement& one : view.measurements) lines.push_back({one.from, one.to});
  for (const Markup& one : view.markups) add_lines_of(one, ahead_of(view), lines);
  if (lines.empty()) return;
  Node list = root.append_child("Lines");
  for (const auto& [from, to] : lines) {
    Node node = list.append_child("Line");
    add_vector(node, "StartPoint", from);
    add_vector(node, "EndPoint", to);
  }
}

std::string marks_file(const std::string& viewpoint_file) {
  return viewpoint_file.substr(0, viewpoint_file.rfind('.')) + ".sightline.json";
}

std::string marks_text(const Viewpoint& view) {
  const auto is_plain = [](const Markup& one) { return one.kind == Markup::Kind::kLine && one.words.empty(); };
  if (view.measurements.empty() && std::all_of(view.markups.begin(), view.markups.end(), is_plain)) return {};
  Viewpoint kept;
  kept.pose = view.pose;
  kept.fovy = view.fovy;
  kept.orthographic = view.orthographic;
  kept.near = view.near;
  kept.measurements = view.measurements;
  kept.markups = view.markups;
  return format_viewpoint(kept);
}

void take_lines(const Node& root, const std::string* marks, Viewpoint& view) {
  Lines lines(root);
  const auto read = marks ? parse_viewpoints(*marks, "marks") : core::Expected<std::vector<Viewpoint>>();
  if (read && read->size() == 1) {
    const Viewpoint& kept = read->front();
    for (const Measurement& one : kept.measurements)
      if (lines.take({{one.from, one.to}})) view.measurements.push_back(one);
    for (const Markup& one : kept.markups)
      if (lines.take(lines_of(one, ahead_of(kept)))) view.markups.push_back(one);
  }
  for (Markup& one : lines.rest()) view.markups.push_back(std::move(one));
}

}  // namespace sightline::apps
