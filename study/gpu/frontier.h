// The hybrid's way to use a hierarchy on the GPU (Carlos, section 6.1.2): not from the root, but from the nodes where
// the walk of the last frame ended, all at once.
//
// What is ours: the nodes are always a *cut* of the tree, so that every leaf lies below exactly one of them and nothing
// can be lost. He keeps visible nodes, and replaces one that is found outside by its parent.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/program.h"
#include "sightline/study/method.h"
#include "sightline/study/tree.h"

namespace sightline::study {

/// What a walk found below a node of the cut.
enum class Found : std::uint8_t { kNothing, kSomething, kEverything, kTooMuch };

/// Where a walk of the tree by the CPU ends, in depth-first order: nodes outside, nodes inside, and nodes of at most
/// `few` places.
std::vector<std::uint32_t> cut_of_walk(const Tree& tree, const culling::CullPlanes& planes, std::uint32_t few);

/// The next frame's cut. Two siblings below which there was nothing, or everything, give way to their parent, one step
/// a frame. A node with too much to write does to those below it of at most `few` places, all at once: it costs what is
/// drawn needlessly.
std::vector<std::uint32_t> next_cut(const Tree& tree, std::span<const std::uint32_t> cut, std::span<const Found> found,
                                    std::uint32_t few);

/// Ranges that a node of the cut may write, at least 1. More: larger subtrees, less of them in parallel.
inline constexpr std::uint32_t kRangesPerNode = 64;

/// Each node of the cut walks its own subtree in a geometry stage and writes the visible places of the tree's order as
/// ranges, which the CPU reads back to make the answer, and the cut of the next frame.
///
/// Promise: conservative. When a node had too much to write, the rest of it is visible unseen (overflowed() counts
/// those), but not again in the same view; else needless only within rounding of a plane. With fewer ranges per node
/// than a leaf has places, a leaf may have too much for ever.
class Frontier : public Method {
 public:
  /// Borrows the tree. `boxes`: those that it was built for. Fails when the GPU has not the memory, or its geometry
  /// stage not the room.
  static core::Expected<std::unique_ptr<Frontier>> create(const gl::Context& context, const Tree& tree,
                                                          std::span<const core::Aabb> boxes,
                                                          std::uint32_t ranges_per_node = kRangesPerNode);
  ~Frontier() override;
  /// The programs of all numbers of ranges up to kRangesPerNode.
  static std::vector<gl::PipelineDescription> all_programs();

  /// Takes the cut from the CPU's walk of a view, as when the GPU takes over. The first cull() does it by itself.
  void take_over(const core::View& view);
  void cull(const core::View& view) override;
  std::uint64_t count() const override;
  std::vector<std::uint32_t> ids() const override;
  std::size_t memory_bytes() const override;

  const std::vector<std::uint32_t>& cut() const;       ///< of the next frame
  const std::vector<core::SlotRange>& ranges() const;  ///< places of Tree::order, rising, disjoint
  std::size_t overflowed() const;                      ///< nodes of the last cut with too much to write

 private:
  struct State;
  explicit Frontier(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sightline::study
