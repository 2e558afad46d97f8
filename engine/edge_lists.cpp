#include "sightline/engine/internal/edge_lists.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sightline/core/mesh_edges.h"
#include "sightline/gpuprims/internal/edges.h"
#include "sightline/gpuprims/internal/view_block.h"

namespace sightline::engine {
namespace {

constexpr double kMostCovered = 0.25;  // share of the square over an item that lines may cover before they are fainter
constexpr double kFaintest = 0.1;      // strength: what is fainter is not drawn
constexpr double kChordError = 0.1;    // pixels between a curve and its segments
constexpr std::uint32_t kMostParts = 512;

bool has_mesh(core::Kind kind) {
  return kind == core::Kind::kMesh || kind == core::Kind::kFacetGroup;
}

double length_of(const gpuprims::PrimitiveEdge& edge) {
  const double u = glm::length(edge.u), v = glm::length(edge.v);
  return edge.straight() ? 2.0 * u : edge.sweep * 0.5 * (u + v);
}

/// Segments of a curve: a power of two, so that many have as many.
std::uint32_t parts_of(const gpuprims::PrimitiveEdge& edge, double pixels_per_metre) {
  if (edge.straight()) return 1;
  const double radius = pixels_per_metre * std::max(glm::length(edge.u), glm::length(edge.v)),
               parts = edge.sweep / std::sqrt(8.0 * kChordError / std::max(radius, kChordError));
  return std::bit_ceil(std::uint32_t(std::clamp(parts, 4.0, double(kMostParts))));
}

std::vector<render::EdgeSegment> segments_of(const core::Mesh& mesh, EdgeChoice which) {
  const auto edges =
      core::edges_of(mesh, which == EdgeChoice::kAll ? core::MeshEdges::kAll : core::MeshEdges::kFeature);
  std::vector<render::EdgeSegment> segments;
  segments.reserve(edges.size());
  for (const auto& [from, to] : edges) segments.push_back({mesh.positions[from], mesh.positions[to]});
  return segments;
}

}  // namespace

/// How large items are in the image.
class EdgeLists::Sizes {
 public:
  Sizes(const core::View& view, const core::ItemBounds& bounds, int height, double line_width)
      : bounds_(bounds),
        eye_from_world_(view.eye_from_world()),
        pixels_at_one_(0.5 * height * gpuprims::reversed_clip_from_eye(view)[1][1]),
        orthographic_(view.orthographic()),
        line_width_(line_width) {}

  const core::dmat4& eye_from_world() const { return eye_from_world_; }

  struct OfItem {
    double diagonal;          // of its box, metres
    double pixels_per_metre;  // at its centre, or at the distance of its diagonal if that is more
  };
  OfItem of(core::Slot slot) const {
    const core::Aabb box = bounds_.box(slot);
    const core::dvec3 low(box.min), high(box.max), centre = bounds_.origin + 0.5 * (low + high);
    const double diagonal = glm::length(high - low), depth = -(eye_from_world_ * core::dvec4(centre, 1.0)).z;
    return {diagonal, orthographic_ ? pixels_at_one_ : pixels_at_one_ / std::max({depth, diagonal, 1e-30})};
  }
  /// Strength of lines of an item that are so long together, metres; 0: too faint.
  double strength(const OfItem& item, double length) const {
    const double cover = length * line_width_, square = item.diagonal * item.diagonal * item.pixels_per_metre;
    const double strength = cover > 0.0 ? std::min(1.0, kMostCovered * square / cover) : 0.0;
    return strength < kFaintest ? 0.0 : strength;
  }

 private:
  const core::ItemBounds& bounds_;
  core::dmat4 eye_from_world_;
  double pixels_at_one_;  // per metre, at the distance of 1 in perspective views
  bool orthographic_;
  double line_width_;  // pixels
};

/// Meshes that are gone leave their segments behind; when most are such, all are found anew.
void EdgeLists::forget_gone(EdgeChoice which) {
  std::size_t left = 0;
  std::erase_if(known_, [&](const auto& entry) { return entry.second.mesh.expired(); });
  for (const auto& [mesh, of] : known_) left += of.count;
  if (which == which_ && 2 * left >= segments_.size()) return;
  which_ = which;
  known_.clear();
  segments_.clear();
  ++generation_;
}

void EdgeLists::add_meshes(const core::Snapshot& snapshot, std::span<const core::Slot> slots,
                           core::ThreadPool& threads) {
  std::vector<std::shared_ptr<const core::Mesh>> added;
  for (const core::Slot slot : slots) {
    if (!has_mesh(snapshot.kind(slot)) || known_.contains(&snapshot.mesh(slot))) continue;
    auto mesh = snapshot.share_mesh(slot);
    if (!mesh) continue;
    known_[mesh.get()].mesh = mesh;
    added.push_back(std::move(mesh));
  }
  std::vector<std::vector<render::EdgeSegment>> found(added.size());
  threads.run(std::uint32_t(added.size()), [&](std::uint32_t i) { found[i] = segments_of(*added[i], which_); });
  for (std::size_t i = 0; i < added.size(); ++i) {
    OfMesh& of = known_[added[i].get()];
    of.first = std::uint32_t(segments_.size());
    of.count = std::uint32_t(found[i].size());
    for (const render::EdgeSegment& segment : found[i]) of.length += double(glm::distance(segment.from, segment.to));
    segments_.insert(segments_.end(), found[i].begin(), found[i].end());
  }
}

void EdgeLists::list_mesh(const core::Snapshot& snapshot, core::Slot slot, const Sizes& sizes) {
  const auto known = known_.find(&snapshot.mesh(slot));
  if (known == known_.end() || known->second.count == 0) return;
  const core::Affine placed = snapshot.world_from_item(slot);
  const double scale = std::cbrt(std::abs(glm::determinant(placed.linear)));
  const double strength = sizes.strength(sizes.of(slot), scale * known->second.length);
  if (strength == 0.0) return;
  core::dmat4 world_from_mesh(placed.linear);
  world_from_mesh[3] = core::dvec4(placed.origin, 1.0);
  meshes_.push_back(
      {known->second.first, known->second.count, glm::mat4(sizes.eye_from_world() * world_from_mesh), float(strength)});
}

void EdgeLists::list_primitive(const core::Snapshot& snapshot, core::Slot slot, const Sizes& sizes) {
  const gpuprims::PrimitiveEdges edges = gpuprims::edges_of(snapshot.primitive(slot), snapshot.world_from_item(slot));
  double length = 0.0;
  for (const gpuprims::PrimitiveEdge& edge : edges) length += length_of(edge);
  const Sizes::OfItem item = sizes.of(slot);
  const double strength = sizes.strength(item, length);
  if (strength == 0.0) return;
  const auto in_eye = [&](const core::dvec3& v, double w) {
    return glm::vec3(sizes.eye_from_world() * core::dvec4(v, w));
  };
  for (const gpuprims::PrimitiveEdge& edge : edges)
    curves_.push_back({in_eye(edge.centre, 1.0), in_eye(edge.u, 0.0), in_eye(edge.v, 0.0), float(edge.sweep),
                       float(strength), parts_of(edge, item.pixels_per_metre)});
}

void EdgeLists::update(const core::Snapshot& snapshot, std::span<const core::Slot> slots, const core::View& view,
                       int height, const Edges& edges, core::ThreadPool& threads) {
  forget_gone(edges.which);
  add_meshes(snapshot, slots, threads);
  meshes_.clear();
  curves_.clear();
  const Sizes sizes(view, snapshot.bounds(), height, double(edges.width));
  for (const core::Slot slot : slots)
    if (has_mesh(snapshot.kind(slot)))
      list_mesh(snapshot, slot, sizes);
    else
      list_primitive(snapshot, slot, sizes);
  std::stable_sort(curves_.begin(), curves_.end(),
                   [](const render::CurvedLine& a, const render::CurvedLine& b) { return a.parts < b.parts; });
}

}  // namespace sightline::engine
