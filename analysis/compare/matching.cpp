#include "sightline/analysis/compare/internal/matching.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "sightline/analysis/compare/internal/cells.h"
#include "sightline/core/internal/hash.h"

namespace sightline::compare {
namespace {

constexpr int kMostRefused = 64;

std::uint64_t hash_of_kind(const Geometry& geometry) {
  return core::mixed(geometry.topology + std::uint64_t(geometry.kind) + 1);
}

/// The free entries of one side in chains by hash, each chain in tree order.
class FreeEntries {
 public:
  template <class Hash>
  FreeEntries(const std::vector<Entry>& entries, const Hash& hash) : entries_(&entries) {
    heads_.assign(std::bit_ceil(entries.size() + 1), kFree);
    hashes_.resize(entries.size());
    next_.assign(entries.size(), kFree);
    for (std::uint32_t i = std::uint32_t(entries.size()); i-- > 0;) {
      if (entries[i].partner != kFree) continue;
      hashes_[i] = hash(entries[i]);
      next_[i] = std::exchange(head(hashes_[i]), i);
    }
  }

  /// The first entry with this hash that `accept` takes, or kFree. Gives up after kMostRefused others.
  template <class Accept>
  std::uint32_t first(std::uint64_t hash, const Accept& accept) {
    int refused = 0;
    for (std::uint32_t* link = &head(hash); *link != kFree;) {
      const std::uint32_t i = *link;
      if ((*entries_)[i].partner != kFree) {
        *link = next_[i];
        continue;
      }
      if (hashes_[i] == hash) {
        if (accept(i)) return i;
        if (++refused == kMostRefused) break;
      }
      link = &next_[i];
    }
    return kFree;
  }

 private:
  std::uint32_t& head(std::uint64_t hash) { return heads_[hash & (heads_.size() - 1)]; }

  const std::vector<Entry>* entries_;
  std::vector<std::uint64_t> hashes_;
  std::vector<std::uint32_t> heads_, next_;
};

/// Cells of a grid over up to four coordinates. What agrees within a tolerance lies in the same cell or across a
/// border, so a search looks on the near sides of the borders, too.
class Cells {
 public:
  Cells(bool by_place, double tolerance) : by_place_(by_place), tolerance_(tolerance) {}

  std::uint64_t hash_in(std::uint64_t hash, const Geometry& g) const {
    for (int c = 0; c < coordinates(); ++c) hash = with_cell(hash, cell(value(g, c)));
    return hash;
  }

  template <class Visit>
  void each_near(std::uint64_t hash, const Geometry& g, const Visit& visit, int c = 0) const {
    if (c == coordinates()) return visit(hash);
    const double reach = 2.0 * allowance(g, tolerance_), at = value(g, c), own = cell(at);
    const double cells[] = {std::max(cell(at - reach), own - 1.0), own, std::min(cell(at + reach), own + 1.0)};
    for (int i = 0; i < 3; ++i)
      if (i == 0 || cells[i] != cells[i - 1]) each_near(with_cell(hash, cells[i]), g, visit, c + 1);
  }

 private:
  int coordinates() const { return by_place_ ? 4 : 1; }
  static double value(const Geometry& g, int c) { return c == 0 ? g.size : g.centre[c - 1]; }
  double cell(double x) const { return std::floor(x / std::max(32.0 * tolerance_, 1e-6)); }

  bool by_place_;
  double tolerance_;
};

void pair(Side& before, std::uint32_t i, Side& after, std::uint32_t j) {
  before.entries[i].partner = j;
  after.entries[j].partner = i;
}

std::size_t count_free(const Side& side) {
  return std::size_t(
      std::count_if(side.entries.begin(), side.entries.end(), [](const Entry& e) { return e.partner == kFree; }));
}

/// Pairs free entries of the same kind and the same value of `group` that lie in near cells and pass `accept`.
template <class Group, class Accept>
void match_near(Side& before, Side& after, Progress& progress, const Cells& cells, const Group& group,
                const Accept& accept) {
  if (count_free(before) == 0 || count_free(after) == 0) return;
  const auto start = [&](const Entry& e) { return core::mixed(group(e)) ^ hash_of_kind(e.geometry); };
  FreeEntries free(before.entries, [&](const Entry& e) { return cells.hash_in(start(e), e.geometry); });
  for (std::uint32_t j = 0; j < after.entries.size() && progress.go_on(j, after.entries.size()); ++j) {
    const Entry& entry = after.entries[j];
    if (entry.partner != kFree) continue;
    std::uint32_t best = kFree;
    cells.each_near(start(entry), entry.geometry, [&](std::uint64_t hash) {
      best = std::min(best, free.first(hash, [&](std::uint32_t i) { return accept(before.shown(i), after.shown(j)); }));
    });
    if (best != kFree) pair(before, best, after, j);
  }
}

void match_keys(Side& before, Side& after, Progress& progress) {
  if (count_free(before) == 0 || count_free(after) == 0) return;
  FreeEntries free(before.entries, [](const Entry& e) { return e.key; });
  for (std::uint32_t j = 0; j < after.entries.size() && progress.go_on(j, after.entries.size()); ++j) {
    if (after.entries[j].partner != kFree) continue;
    const std::uint32_t i = free.first(after.entries[j].key, [](std::uint32_t) { return true; });
    if (i != kFree) pair(before, i, after, j);
  }
}

}  // namespace

void match(Side& before, Side& after, double tolerance, Progress& progress, double share) {
  const Cells places(true, tolerance), sizes(false, tolerance);
  const auto alike = [&](const Shown& a, const Shown& b) {
    const Likeness l = likeness(a, b, tolerance);
    return l.same_shape && l.same_place;
  };
  const auto same_shape = [&](const Shown& a, const Shown& b) { return likeness(a, b, tolerance).same_shape; };
  progress.begin(0.25 * share);
  match_near(
      before, after, progress, places, [](const Entry& e) { return e.path; }, alike);
  progress.begin(0.25 * share);
  match_keys(before, after, progress);
  progress.begin(0.25 * share);
  match_near(
      before, after, progress, places, [](const Entry&) { return std::uint64_t{0}; }, alike);
  progress.begin(0.25 * share);
  match_near(
      before, after, progress, sizes, [](const Entry& e) { return e.parent_path; }, same_shape);
}

}  // namespace sightline::compare
