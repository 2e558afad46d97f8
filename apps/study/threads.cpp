#include "sightline/apps/study/threads.h"

#include <array>
#include <atomic>
#include <memory>
#include <thread>

#include <omp.h>

namespace sightline::study {
namespace {

constexpr std::uint32_t kTaskItems = 4096;

bool worth_giving(const CompactNode& node) {
  return node.end - node.first >= kTaskItems;
}

// Recursion is as deep as tasks reach; with trees that only halve now and then that may be far, hence a limit in depth,
// too.
void task(const Frame& f, CompactNode* nodes, std::uint32_t index, WalkSubtree walk, OpenNode open_node,
          std::vector<core::VisibleSet>& parts) {
  core::VisibleSet& out = parts[std::size_t(omp_get_thread_num())];
  if (!worth_giving(nodes[index]) || nodes[index].depth > 64) {
    walk(f, nodes, index, out);
    return;
  }
  if (!open_node(f, nodes, index, out)) return;
  const std::uint32_t left = index + 1, right = nodes[left].escape;
#pragma omp task default(none) shared(f, parts) firstprivate(nodes, left, walk, open_node)
  task(f, nodes, left, walk, open_node, parts);
  task(f, nodes, right, walk, open_node, parts);
#pragma omp taskwait
}

/// One writer, one reader.
class Ring {
 public:
  bool push(std::uint32_t value) {
    const std::uint32_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == kSize) return false;
    values_[end % kSize] = value;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  bool pop(std::uint32_t& value) {
    const std::uint32_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    value = values_[begin % kSize];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }
  bool empty() const { return begin_.load(std::memory_order_acquire) == end_.load(std::memory_order_acquire); }

 private:
  static constexpr std::uint32_t kSize = 64;
  alignas(64) std::atomic<std::uint32_t> begin_{0};
  alignas(64) std::atomic<std::uint32_t> end_{0};
  std::array<std::uint32_t, kSize> values_{};
};

/// Rings from every thread to every other, and the number of subtrees not yet done.
struct Exchange {
  explicit Exchange(int count) : threads(count), rings(new Ring[std::size_t(count) * std::size_t(count)]) {}
  Ring& ring(int from, int to) { return rings[std::size_t(from) * std::size_t(threads) + std::size_t(to)]; }
  int threads;
  std::unique_ptr<Ring[]> rings;
  alignas(64) std::atomic<std::int64_t> unfinished{1};
};

/// Walks a subtree and gives parts of it away while others have nothing to do.
void walk_sharing(const Frame& f, CompactNode* nodes, std::uint32_t root, WalkSubtree walk, OpenNode open_node,
                  Exchange& exchange, int self, std::vector<std::uint32_t>& own, core::VisibleSet& out) {
  const int next = (self + 1) % exchange.threads;
  own.assign(1, root);
  while (!own.empty()) {
    const std::uint32_t index = own.back();
    own.pop_back();
    if (!worth_giving(nodes[index])) {
      walk(f, nodes, index, out);
      continue;
    }
    if (!open_node(f, nodes, index, out)) continue;
    const std::uint32_t left = index + 1, right = nodes[left].escape;
    own.push_back(right);
    if (next != self && worth_giving(nodes[right]) && exchange.ring(self, next).empty()) {
      exchange.unfinished.fetch_add(1, std::memory_order_relaxed);
      if (exchange.ring(self, next).push(right))
        own.pop_back();
      else
        exchange.unfinished.fetch_sub(1, std::memory_order_relaxed);
    }
    own.push_back(left);
  }
  exchange.unfinished.fetch_sub(1, std::memory_order_acq_rel);
}

void ring_thread(const Frame& f, CompactNode* nodes, WalkSubtree walk, OpenNode open_node, Exchange& exchange, int self,
                 core::VisibleSet& out) {
  std::vector<std::uint32_t> own;
  if (self == 0) walk_sharing(f, nodes, 0, walk, open_node, exchange, self, own, out);
  for (int idle = 0; exchange.unfinished.load(std::memory_order_acquire) > 0; ++idle) {
    for (int from = 0; from < exchange.threads; ++from) {
      std::uint32_t root = 0;
      while (exchange.ring(from, self).pop(root)) {
        walk_sharing(f, nodes, root, walk, open_node, exchange, self, own, out);
        idle = 0;
      }
    }
    if (idle > 1000) std::this_thread::yield();  // a machine with fewer cores than threads must get on, too
  }
}

}  // namespace

void walk_static(const Frame& f, CompactNode* nodes, WalkSubtree walk, int threads,
                 std::vector<core::VisibleSet>& parts) {
  std::vector<std::uint32_t> roots{0}, next;
  while (int(roots.size()) < threads) {
    next.clear();
    for (const std::uint32_t i : roots) {
      if (nodes[i].escape == i + 1) {
        next.push_back(i);
      } else {
        next.push_back(i + 1);
        next.push_back(nodes[i + 1].escape);
      }
    }
    if (next.size() == roots.size()) break;
    roots.swap(next);
  }
  for (const std::uint32_t i : roots) nodes[i].mask = kAllPlanes;
  const int count = int(roots.size());
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int i = 0; i < count; ++i) walk(f, nodes, roots[std::size_t(i)], parts[std::size_t(omp_get_thread_num())]);
}

void walk_tasks(const Frame& f, CompactNode* nodes, WalkSubtree walk, OpenNode open_node, int threads,
                std::vector<core::VisibleSet>& parts) {
#pragma omp parallel num_threads(threads)
#pragma omp single
  task(f, nodes, 0, walk, open_node, parts);
}

void walk_ring(const Frame& f, CompactNode* nodes, WalkSubtree walk, OpenNode open_node, int threads,
               std::vector<core::VisibleSet>& parts) {
  Exchange exchange(threads);
#pragma omp parallel num_threads(threads)
  {
    // Fewer threads than asked for may have come: those that did not would never empty their rings.
#pragma omp single
    exchange.threads = omp_get_num_threads();
    const int self = omp_get_thread_num();
    ring_thread(f, nodes, walk, open_node, exchange, self, parts[std::size_t(self)]);
  }
}

}  // namespace sightline::study
