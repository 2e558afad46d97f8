#include "sightline/importers/recognise/internal/recognise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "sightline/core/mesh_extras.h"
#include "sightline/importers/recognise/internal/ring_chain.h"
#include "sightline/importers/recognise/internal/shape_fit.h"
#include "sightline/importers/recognise/internal/solids.h"

namespace sightline::importers {
namespace {

using namespace recognition;

constexpr std::uint32_t kLeastTriangles = 6;  // a pyramid with its apex
constexpr std::uint32_t kLeastBoundary = 5;   // of a face that chains start from
constexpr std::size_t kMostStarts = 4;        // faces that chains are tried from
constexpr double kFlatness = 1.0 / 500.0;     // of a solid's diagonal that grid noise may bend a face by

double volume_of(const Solid& solid) {
  double sum = 0.0;
  const dvec3& origin = solid.points[0];
  for (std::uint32_t t = 0; t < solid.triangle_count(); ++t)
    sum += glm::dot(solid.area_vector(t), solid.points[solid.corners[3 * t]] - origin);
  return sum / 6.0;
}

double diagonal_of(const Solid& solid) {
  dvec3 low(1e300), high(-1e300);
  for (const dvec3& p : solid.points) low = glm::min(low, p), high = glm::max(high, p);
  return glm::length(high - low);
}

/// One face for each of the largest numbers of boundary edges.
std::vector<std::uint32_t> starts(const Faces& faces) {
  std::vector<std::uint32_t> best;
  for (std::uint32_t f = 0; f < faces.faces.size(); ++f) {
    const std::uint32_t boundary = faces.faces[f].boundary;
    if (boundary < kLeastBoundary) continue;
    const auto at = std::find_if(best.begin(), best.end(),
                                 [&](std::uint32_t other) { return faces.faces[other].boundary <= boundary; });
    if (at != best.end() && faces.faces[*at].boundary == boundary) continue;
    best.insert(at, f);
    if (best.size() > kMostStarts) best.pop_back();
  }
  return best;
}

/// A half-edge from the vertex with the most triangles around it, if these can be a pole's.
std::uint32_t pole_of(const Solid& solid) {
  std::vector<std::uint32_t> valence(solid.points.size(), 0);
  for (const std::uint32_t v : solid.corners) ++valence[v];
  const auto most = std::max_element(valence.begin(), valence.end());
  if (*most < kLeastSegments) return kNone;
  const auto pole = std::uint32_t(most - valence.begin());
  return std::uint32_t(std::find(solid.corners.begin(), solid.corners.end(), pole) - solid.corners.begin());
}

std::size_t triangles_in(const std::vector<Found>& found) {
  std::size_t sum = 0;
  for (const Found& f : found) sum += f.triangles.size();
  return sum;
}

class Recogniser {
 public:
  Recogniser(const CoordinateNoise& noise, double tolerance) : allowance_{noise, tolerance} {}

  /// Nothing found: `refusal` says why.
  std::vector<Found> look_at(const Solid& solid, Refusal& refusal) {
    refusal = Refusal::kOpen;
    if (solid.open) return {};
    refusal = Refusal::kNoStructure;
    if (solid.triangle_count() < kLeastTriangles) return {};
    const double bend = std::max(allowance_.noise.grid, allowance_.chosen);
    find_faces(solid, std::max(2.0 * allowance_.noise.rounding, std::min(2.5 * bend, kFlatness * diagonal_of(solid))),
               faces_);
    if (auto found = fit_whole(solid, faces_, allowance_)) return {std::move(*found)};
    std::vector<Found> best;
    std::size_t most = 0;
    const auto try_chain = [&] {
      if (chain_.rings.size() > 2 || chain_.whole) refusal = Refusal::kOffSurface;
      auto found = fit_chain(solid, chain_, allowance_);
      const std::size_t taken = triangles_in(found);
      if (taken > most) best = std::move(found), most = taken;
      return most == solid.triangle_count();
    };
    for (const std::uint32_t face : starts(faces_))
      if (chain_from_face(solid, faces_, face, chain_) && try_chain()) return best;
    if (const std::uint32_t pole = pole_of(solid); pole != kNone)
      if (chain_from_pole(solid, faces_, pole, chain_)) try_chain();
    return best;
  }

 private:
  Allowance allowance_;
  Faces faces_;
  RingChain chain_;
};

/// The surfaces of faces that have triangles left, or null.
std::shared_ptr<const std::vector<core::MeshSurface>> surfaces_of_rest(const core::Mesh& mesh,
                                                                       const std::vector<bool>& taken) {
  auto left = std::make_shared<std::vector<core::MeshSurface>>();
  std::uint32_t triangle = 0, count = 0;
  for (core::MeshSurface surface : core::surfaces_stored_with(mesh)) {
    const std::uint32_t before = count;
    for (; triangle < surface.end_triangle && triangle < taken.size(); ++triangle) count += taken[triangle] ? 0 : 1;
    surface.end_triangle = count;
    if (count > before) left->push_back(surface);
  }
  return left->empty() ? nullptr : left;
}

/// The triangles that are not taken, with the vertices that they use and the surfaces of their faces.
core::Mesh rest_of(const core::Mesh& mesh, const std::vector<bool>& taken) {
  core::Mesh rest;
  rest.name = mesh.name;
  std::vector<std::uint32_t> place(mesh.positions.size(), kNone);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    if (taken[i / 3]) continue;
    std::uint32_t& at = place[mesh.indices[i]];
    if (at == kNone) {
      at = std::uint32_t(rest.positions.size());
      rest.positions.push_back(mesh.positions[mesh.indices[i]]);
      if (!mesh.normals.empty()) rest.normals.push_back(mesh.normals[mesh.indices[i]]);
    }
    rest.indices.push_back(at);
  }
  if (auto surfaces = surfaces_of_rest(mesh, taken)) rest.extras = core::MeshExtrasSlot({nullptr, std::move(surfaces)});
  return rest;
}

}  // namespace

RecognisedMesh recognise(const core::Mesh& mesh, double tolerance) {
  RecognisedMesh out;
  const CoordinateNoise noise = coordinate_noise(mesh);
  Solids solids(mesh, noise);
  Recogniser recogniser(noise, tolerance);

  struct Candidate {
    std::vector<Found> found;
    std::vector<std::uint32_t> origin;
    double volume;
  };
  std::vector<Candidate> candidates;
  double volume = 0.0;
  Solid solid;
  for (std::size_t i = 0; i < solids.count(); ++i) {
    solids.get(i, solid);
    const double own = solid.open ? 0.0 : volume_of(solid);
    volume += own;
    Refusal refusal{};
    auto found = recogniser.look_at(solid, refusal);
    if (triangles_in(found) < solid.triangle_count()) ++out.refused[std::size_t(refusal)];
    if (!found.empty()) candidates.push_back({std::move(found), solid.origin, own});
  }
  out.refused[std::size_t(Refusal::kBroken)] += solids.set_aside();

  std::vector<bool> taken(mesh.indices.size() / 3, false);
  for (const Candidate& candidate : candidates) {
    if (candidate.volume * volume < 0.0) {
      ++out.refused[std::size_t(Refusal::kCavity)];
      continue;
    }
    for (const Found& found : candidate.found) {
      out.primitives.push_back({found.primitive, found.mesh_from_primitive, std::uint32_t(found.triangles.size()),
                                found.deviation, found.along});
      for (const std::uint32_t t : found.triangles) taken[candidate.origin[t]] = true;
    }
  }
  if (!out.primitives.empty()) out.rest = rest_of(mesh, taken);
  return out;
}

}  // namespace sightline::importers
