#include "sightline/lod/internal/cluster_groups.h"

#include <algorithm>

#include "sightline/core/conventions.h"

namespace sightline::lod {
namespace {

struct Neighbour {
  std::uint32_t cluster, edges;
};

/// Neighbours of each cluster in one list.
class Neighbours {
 public:
  Neighbours(std::uint32_t count, std::span<const Contact> contacts) : first_(count + 1), list_(2 * contacts.size()) {
    for (const Contact& c : contacts) ++first_[c.a], ++first_[c.b];
    std::uint32_t sum = 0;
    for (std::uint32_t& first : first_) sum += first, first = sum;
    for (std::size_t i = contacts.size(); i-- > 0;) {
      const Contact& c = contacts[i];
      list_[--first_[c.a]] = {c.b, c.edges};
      list_[--first_[c.b]] = {c.a, c.edges};
    }
  }
  std::span<const Neighbour> of(std::uint32_t cluster) const {
    return std::span(list_).subspan(first_[cluster], first_[cluster + 1] - first_[cluster]);
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<Neighbour> list_;
};

/// Grows one group after another from its first cluster, always by the cluster that shares most edges with it.
class Growth {
 public:
  Growth(std::uint32_t count, std::span<const Contact> contacts)
      : neighbours_(count, contacts), groups_(count, core::kNone), shared_(count, 0) {}

  std::vector<std::uint32_t> grow(std::uint32_t most) {
    std::uint32_t number = 0, open = core::kNone, open_count = 0;  // a group of clusters without free neighbours
    for (std::uint32_t first = 0; first < groups_.size(); ++first) {
      if (groups_[first] != core::kNone) continue;
      if (!has_free_neighbour(first)) {
        if (open == core::kNone || open_count == most) open = number++, open_count = 0;
        groups_[first] = open;
        ++open_count;
        continue;
      }
      grow_from(first, number++, most);
    }
    return std::move(groups_);
  }

 private:
  bool has_free_neighbour(std::uint32_t cluster) const {
    return std::ranges::any_of(neighbours_.of(cluster),
                               [&](const Neighbour& n) { return groups_[n.cluster] == core::kNone; });
  }
  void grow_from(std::uint32_t first, std::uint32_t number, std::uint32_t most) {
    candidates_.clear();
    for (std::uint32_t size = 1, cluster = first;; ++size) {
      groups_[cluster] = number;
      for (const Neighbour& n : neighbours_.of(cluster)) {
        if (groups_[n.cluster] != core::kNone) continue;
        if (shared_[n.cluster] == 0) candidates_.push_back(n.cluster);
        shared_[n.cluster] += n.edges;
      }
      std::erase(candidates_, cluster);
      if (size == most || candidates_.empty()) break;
      // The oldest among equal ones, so that groups grow round and not long.
      cluster = *std::ranges::max_element(candidates_, {}, [&](std::uint32_t candidate) { return shared_[candidate]; });
    }
    for (const std::uint32_t candidate : candidates_) shared_[candidate] = 0;
  }

  Neighbours neighbours_;
  std::vector<std::uint32_t> groups_, shared_, candidates_;
};

}  // namespace

std::vector<std::uint32_t> group_clusters(std::uint32_t count, std::span<const Contact> contacts, std::uint32_t most) {
  return Growth(count, contacts).grow(most);
}

}  // namespace sightline::lod
