#include "sightline/core/find_nodes.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/internal/text_pattern.h"

namespace sightline::core {
namespace {

constexpr std::string_view kExpression = "re:";

/// Where a condition holds of a node, in the order of the rule. Odd ones hold regardless of case.
enum Rank : int {
  kWholePath = 0,
  kPathEnd = 2,
  kExactName = 4,
  kBareName = 6,
  kExactValue = 8,
  kLoose = 10,
  kNowhere = 12,
};

std::string_view bare(std::string_view name) {
  const std::size_t first = name.find_first_not_of('/');
  return first == std::string_view::npos ? name : name.substr(first);
}

bool same(std::string_view a, std::string_view b, bool any_case) {
  return any_case ? same_but_for_case(a, b) : a == b;
}

/// What Scene::path() calls nodes, without the slashes that names begin with.
class Labels {
 public:
  /// `numbers`: those of nodes without a name are asked for. A step per node for all of them.
  Labels(const Scene& scene, bool numbers) : scene_(&scene) {
    if (!numbers) return;
    std::vector<std::uint32_t> children;
    scene.for_each_node(scene.root(), [&](NodeId node, const auto&...) {
      const std::size_t size = std::max<std::size_t>(node.index + 1, position_.size());
      position_.resize(size);
      children.resize(size);
      if (const NodeId parent = scene.parent(node); parent.valid()) position_[node.index] = children[parent.index]++;
    });
  }

  std::string_view of(NodeId node, std::string& number) const {
    const std::string_view name = scene_->name(node);
    if (!name.empty() || position_.empty()) return bare(name);
    return number = "#" + std::to_string(position_[node.index]);
  }

  std::string path(NodeId node) const {
    std::string path, number;
    for (; node.valid() && node != scene_->root(); node = scene_->parent(node))
      path = std::string(of(node, number)) + (path.empty() ? "" : "/") + path;
    return path;
  }

  /// How many nodes, the last of them this one, a text names as an end of the path; 0: it is none. Any number of
  /// slashes may stand between two.
  int path_end(NodeId node, std::string_view text, bool any_case) const {
    std::string number;
    for (int count = 1; node.valid() && node != scene_->root(); node = scene_->parent(node), ++count) {
      const std::string_view label = of(node, number);
      if (label.empty() || text.size() < label.size() ||
          !same(text.substr(text.size() - label.size()), label, any_case))
        return 0;
      text.remove_suffix(label.size());
      const std::size_t last = text.find_last_not_of('/');
      if (last == std::string_view::npos) return count;
      if (last + 1 == text.size()) return 0;
      text = text.substr(0, last + 1);
    }
    return 0;
  }

 private:
  const Scene* scene_;
  std::vector<std::uint32_t> position_;  // among its siblings, by a node's index
};

bool is_word_part(char c) {
  return (c >= '0' && c <= '9') || (lower_case(c) >= 'a' && lower_case(c) <= 'z') || (c & 0x80) != 0;
}

/// Whether the words, in lower case, occur in a text with neither a letter nor a digit next to them.
bool has_words(std::string_view text, std::string_view words) {
  const auto alike = [](char x, char y) { return lower_case(x) == y; };
  for (auto from = text.begin();; ++from) {
    from = std::search(from, text.end(), words.begin(), words.end(), alike);
    if (from == text.end()) return false;
    const auto end = from + std::ptrdiff_t(words.size());
    if ((from == text.begin() || !is_word_part(from[-1])) && (end == text.end() || !is_word_part(*end))) return true;
  }
}

/// A condition, read once for all nodes.
class Query {
 public:
  static Expected<Query> create(const NodeCondition& condition) {
    Query query;
    query.key_ = condition.key;
    query.text_ = query.value_ = condition.text;
    while (query.text_.size() > 1 && query.text_.ends_with('/')) query.text_.pop_back();
    const std::size_t equals = condition.text.find('=');
    if (condition.key.empty() && equals != std::string::npos && equals > 0 && !is_expression(condition.text)) {
      query.value_key_ = condition.text.substr(0, equals);
      query.value_ = condition.text.substr(equals + 1);
    } else {
      query.value_key_ = condition.key;
    }
    query.words_ = lower_case(query.text_);
    for (const auto& [text, pattern] :
         {std::pair{&query.text_, &query.pattern_}, {&query.value_, &query.value_pattern_}}) {
      if (!is_pattern(*text)) continue;
      auto made = is_expression(*text) ? TextPattern::regular(std::string_view(*text).substr(kExpression.size()))
                                       : Expected<TextPattern>(TextPattern::wildcards(bare(*text)));
      if (!made) return tl::unexpected(made.error());
      *pattern = std::move(*made);
    }
    if (!is_expression(query.text_) && bare(query.text_).find('/') != std::string_view::npos && query.pattern_)
      query.path_pattern_ = TextPattern::wildcards("*/" + std::string(bare(query.text_)));
    return query;
  }

  /// Whether rank() needs the numbers of nodes without a name.
  bool needs_numbers() const { return path_pattern_ || text_.find('#') != std::string::npos; }

  /// Ranks above `most` are of no interest.
  int rank(const Scene& scene, const Labels& labels, NodeId node, int most) const {
    if (value_.empty() && (!value_key_.empty() || text_.empty())) return has_value_key(scene, node) ? 0 : kNowhere;
    int best = key_.empty() ? rank_of_text(scene, labels, node) : int(kNowhere);
    if (best > kExactValue && !value_key_.empty()) best = std::min(best, rank_of_value(scene, node));
    return best > kLoose && most >= kLoose && fits_loosely(scene, labels, node) ? kLoose : best;
  }

  /// The step of a rank.
  NodeMatch match(int rank) const {
    if (rank >= kLoose || value_.empty())
      return pattern_ || value_pattern_ || value_.empty() ? NodeMatch::kPattern : NodeMatch::kWords;
    return rank >= kExactValue ? NodeMatch::kValue : rank >= kExactName ? NodeMatch::kName : NodeMatch::kPath;
  }

 private:
  static bool is_expression(std::string_view text) { return text.starts_with(kExpression); }

  int rank_of_text(const Scene& scene, const Labels& labels, NodeId node) const {
    const std::string_view name = scene.name(node);
    int best = kNowhere;
    for (const bool any_case : {false, true}) {
      const int nodes = labels.path_end(node, text_, any_case);
      if (nodes > 1)
        best = std::min(best, (same(scene.path(node), text_, any_case) ? kWholePath : kPathEnd) + any_case);
      if (nodes == 1) best = std::min(best, (same(name, text_, any_case) ? kExactName : kBareName) + any_case);
    }
    for (const auto& [key, value] : scene.attributes(node))
      if (best > kExactValue && same(value, text_, true)) best = std::min(best, kExactValue + int(value != text_));
    return best;
  }

  /// Calls visit(value) for each value of the key, until one is true.
  template <class Visit>
  bool any_value(const Scene& scene, NodeId node, const Visit& visit) const {
    const auto& attributes = scene.attributes(node);
    return (same_but_for_case(value_key_, "name") && visit(scene.name(node))) ||
           std::any_of(attributes.begin(), attributes.end(), [&](const auto& attribute) {
             return same_but_for_case(attribute.first, value_key_) && visit(attribute.second);
           });
  }

  bool has_value_key(const Scene& scene, NodeId node) const {
    return value_key_.empty() || any_value(scene, node, [](std::string_view) { return true; });
  }

  int rank_of_value(const Scene& scene, NodeId node) const {
    for (const bool any_case : {false, true})
      if (any_value(scene, node, [&](std::string_view value) { return same(bare(value), bare(value_), any_case); }))
        return kExactValue + any_case;
    return kNowhere;
  }

  bool fits_loosely(const Scene& scene, const Labels& labels, NodeId node) const {
    if (!value_key_.empty() && value_pattern_ && any_value(scene, node, [&](std::string_view value) {
          return value_pattern_->fits(is_expression(value_) ? value : bare(value));
        }))
      return true;
    if (!key_.empty()) return false;
    const auto fits = [&](std::string_view text) {
      return pattern_ ? pattern_->fits(is_expression(text_) ? text : bare(text)) : has_words(text, words_);
    };
    const auto& attributes = scene.attributes(node);
    if ((!scene.name(node).empty() && fits(scene.name(node))) ||
        std::any_of(attributes.begin(), attributes.end(), [&](const auto& one) { return fits(one.second); }))
      return true;
    return path_pattern_ && path_pattern_->fits("/" + labels.path(node));
  }

  std::string key_, text_, words_;
  std::string value_key_, value_;  // "KEY=TEXT"; the key is empty where there is none
  std::optional<TextPattern> pattern_, value_pattern_, path_pattern_;
};

/// The number of letters to add, leave out or replace, as far as it is at most `most`; else more than that.
std::size_t difference(std::string_view a, std::string_view b, std::size_t most) {
  if (std::max(a.size(), b.size()) - std::min(a.size(), b.size()) > most) return most + 1;
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t(0));
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (lower_case(a[i]) != lower_case(b[j]));
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string_view words_of(NodeMatch match) {
  constexpr std::string_view kWords[] = {"by path", "by name", "by value", "by whole words", "by pattern"};
  return kWords[std::size_t(match)];
}

bool is_pattern(std::string_view text) {
  return text.starts_with(kExpression) || text.find_first_of("*?") != std::string_view::npos;
}

Expected<FoundNodes> find_nodes(const Scene& scene, NodeId top, std::span<const NodeCondition> conditions) {
  std::vector<Query> queries;
  for (const NodeCondition& condition : conditions) {
    auto query = Query::create(condition);
    if (!query) return tl::unexpected(query.error());
    queries.push_back(std::move(*query));
  }
  const Labels labels(scene,
                      std::any_of(queries.begin(), queries.end(), [](const Query& q) { return q.needs_numbers(); }));
  FoundNodes found;
  int best = kNowhere - 1;
  scene.for_each_node(top, [&](NodeId node, const Affine&, bool, std::uint32_t, MaterialId) {
    int rank = kWholePath;
    const Query* last = nullptr;
    for (const Query& query : queries) {
      const int one = query.rank(scene, labels, node, best);
      if (one >= rank) rank = one, last = &query;
    }
    if (rank > best) return;
    if (rank < best) found.nodes.clear();
    best = rank;
    if (last) found.match = last->match(rank);
    found.nodes.push_back(node);
  });
  return found;
}

std::vector<std::string> similar_names(const Scene& scene, NodeId top, const NodeCondition& condition,
                                       std::size_t limit) {
  std::string key = condition.key, text = condition.text;
  if (const std::size_t equals = text.find('='); key.empty() && equals != std::string::npos && equals > 0) {
    key = text.substr(0, equals);
    text.erase(0, equals + 1);
  }
  const std::string wanted(bare(text.substr(text.find_last_of('/') + 1)));
  const std::string lower = lower_case(wanted);
  const std::size_t most = std::max<std::size_t>(1, wanted.size() / 3);
  std::map<std::string, std::size_t, std::less<>> differences;
  const auto look_at = [&](std::string_view name) {
    if (name.empty() || wanted.empty() || differences.contains(name)) return;
    const std::size_t away =
        lower_case(name).find(lower) != std::string::npos ? 0 : difference(wanted, bare(name), most);
    if (away <= most) differences.emplace(name, away);
  };
  const bool names = key.empty() || same_but_for_case(key, "name");
  scene.for_each_node(top, [&](NodeId node, const auto&...) {
    if (names) look_at(scene.name(node));
    for (const auto& [other, value] : scene.attributes(node))
      if (!key.empty() && same_but_for_case(other, key)) look_at(value);
  });
  std::vector<std::tuple<std::size_t, std::size_t, std::string>> order;
  for (const auto& [name, away] : differences) order.emplace_back(away, name.size(), name);
  std::sort(order.begin(), order.end());
  std::vector<std::string> similar;
  for (std::size_t i = 0; i < std::min(limit, order.size()); ++i) similar.push_back(std::get<std::string>(order[i]));
  return similar;
}

}  // namespace sightline::core
