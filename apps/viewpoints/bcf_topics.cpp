#include "sightline/apps/viewpoints/bcf_topics.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "sightline/core/internal/ascii_case.h"

namespace sightline::apps {

std::optional<double> number_of(const Node& node) {
  std::string_view text = node.text().get();
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '+'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  double value = 0.0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = !text.empty() && read.ec == std::errc() && read.ptr == text.data() + text.size();
  return good && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<core::dvec3> xyz_of(const Node& node) {
  const auto x = number_of(node.child("X")), y = number_of(node.child("Y")), z = number_of(node.child("Z"));
  return x && y && z ? std::optional(core::dvec3(*x, *y, *z)) : std::nullopt;
}

std::string number(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string printable(std::string text) {
  for (char& c : text)
    if (std::uint8_t(c) < 32 && c != '\t' && c != '\n' && c != '\r') c = ' ';
  return text;
}

void add_text(Node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(printable(text).c_str());
}

void add_vector(Node parent, const char* name, const core::dvec3& v) {
  Node node = parent.append_child(name);
  add_text(node, "X", number(v.x));
  add_text(node, "Y", number(v.y));
  add_text(node, "Z", number(v.z));
}

std::vector<Node> viewpoints_of(const Node& markup) {
  std::vector<Node> nodes;
  const auto topic = markup.child("Topic").child("Viewpoints").children("ViewPoint");  // of BCF 3.0
  for (const auto& list : {markup.children("Viewpoints"), topic}) nodes.insert(nodes.end(), list.begin(), list.end());
  const auto index = [](const Node& node) { return number_of(node.child("Index")).value_or(HUGE_VAL); };
  std::stable_sort(nodes.begin(), nodes.end(), [&](const Node& a, const Node& b) { return index(a) < index(b); });
  return nodes;
}

// BCF 3.0 has them below the topic.
std::vector<Node> comment_nodes(const Node& markup, const std::string& viewpoint, bool first) {
  std::vector<Node> nodes;
  for (const Node& list : {markup, markup.child("Topic").child("Comments")})
    for (const Node& node : list.children("Comment")) {
      const std::string of = node.child("Viewpoint").attribute("Guid").value();
      const bool has_words = !std::string_view(node.child("Comment").text().get()).empty();
      if (has_words && (of.empty() ? first : core::lower_case(of) == core::lower_case(viewpoint)))
        nodes.push_back(node);
    }
  return nodes;
}

bool is_faint(const Node& colour) {
  const std::string argb = colour.attribute("Color").value();
  return argb.size() == 8 && std::strchr("01234567", argb[0]);
}

}  // namespace sightline::apps
