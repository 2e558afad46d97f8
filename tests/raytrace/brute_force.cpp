#include "sightline/tests/raytrace/brute_force.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::raytrace {
namespace {

using core::Affine;
using core::dvec3;
using core::Ray;
using core::Slot;
using core::Snapshot;
using core::vec3;

/// Whether the planes keep a point; doubtful within `error`.
enum class Kept { kNo, kMaybe, kYes };
Kept kept(const RayFilter& filter, const dvec3& p, double error) {
  bool any = false, all = true, maybe_any = false, maybe_all = true, planes = false;
  for (const core::Plane& plane : filter.sections) {
    if (plane.normal == dvec3(0.0)) continue;
    planes = true;
    const double value = core::evaluate(plane, p), doubt = error * glm::length(plane.normal);
    any |= value > doubt;
    all &= value > doubt;
    maybe_any |= value >= -doubt;
    maybe_all &= value >= -doubt;
  }
  if (!planes) return Kept::kYes;
  const bool sure = filter.section_mode == core::SectionMode::kUnion ? any : all;
  const bool maybe = filter.section_mode == core::SectionMode::kUnion ? maybe_any : maybe_all;
  return sure ? Kept::kYes : maybe ? Kept::kMaybe : Kept::kNo;
}

/// A ray that passes within rounding of an edge, or grazes the surface, may hit or not. So rays beside it are cast,
/// too.
void solid_crossings(const Snapshot& snapshot, Slot slot, const Ray& ray, std::vector<Crossing>& out) {
  const Affine world = snapshot.world_from_item(slot);
  const core::dmat3 inverse = glm::inverse(world.linear);
  const core::Primitive solid = snapshot.primitive(slot);
  const double length = glm::length(ray.direction);
  const auto cast = [&](const dvec3& beside) {
    return gpuprims::intersect(solid,
                               core::Ray{inverse * (ray.origin + beside - world.origin), inverse * ray.direction});
  };
  const dvec3 along = ray.direction / length;
  const dvec3 u = glm::normalize(glm::cross(along, std::abs(along.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const core::AabbD box = core::bounds(solid, world);
  const double size = glm::length(ray.origin) + glm::length(world.origin) + glm::length(box.size());
  const double step = 0.25 * kSolidError * size;
  const dvec3 sides[] = {dvec3(0.0), step * u, -step * u, step * glm::cross(along, u), -step * glm::cross(along, u)};
  gpuprims::Hits hits[5];
  for (int i = 0; i < 5; ++i) hits[i] = cast(sides[i]);
  for (const gpuprims::Hits& around : hits)
    for (int i = 0; i < around.count; ++i) {
      const double t = around.hit[i].t;
      const dvec3 n = glm::normalize(glm::transpose(inverse) * around.hit[i].normal);
      const double sine = std::abs(glm::dot(n, along));
      const double error = kSolidError * size / length / std::max(sine, 1e-6);
      const bool sure = sine > 1e-4 && std::all_of(std::begin(hits), std::end(hits), [&](const gpuprims::Hits& other) {
                          return std::any_of(other.hit.begin(), other.hit.begin() + other.count,
                                             [&](const gpuprims::Hit& h) { return std::abs(h.t - t) <= error; });
                        });
      out.push_back({slot, t, error, sure});
    }
}

/// T. Moeller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
void mesh_crossings(const Snapshot& snapshot, Slot slot, const Ray& ray, std::vector<Crossing>& out) {
  const Affine world = snapshot.world_from_item(slot);
  const core::Mesh& mesh = snapshot.mesh(slot);
  const core::dmat3 inverse = glm::inverse(world.linear);
  const dvec3 origin = inverse * (ray.origin - world.origin), direction = inverse * ray.direction;
  core::AabbD box;
  for (const vec3& p : mesh.positions) box.grow(dvec3(p));
  const dvec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
  const double size = std::max({reach.x, reach.y, reach.z, 2.0 * glm::length(box.size())});
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const dvec3 a(mesh.positions[mesh.indices[i]]);
    const dvec3 u = dvec3(mesh.positions[mesh.indices[i + 1]]) - a, v = dvec3(mesh.positions[mesh.indices[i + 2]]) - a;
    const dvec3 p = glm::cross(direction, v), n = glm::cross(u, v);
    const double determinant = glm::dot(u, p);
    if (determinant == 0.0) continue;
    const dvec3 to = origin - a, q = glm::cross(to, u);
    const double b = glm::dot(to, p) / determinant, c = glm::dot(direction, q) / determinant;
    // How far a displacement by the stated error moves the barycentric coordinates.
    const double sine = std::abs(glm::dot(glm::normalize(n), glm::normalize(direction)));
    const double shift = kMeshError * size + 1e-15 * glm::length(origin);
    const double longest = std::max({glm::length(u), glm::length(v), glm::length(u - v)});
    const double doubt = shift * longest / glm::length(n) / sine;
    if (b < -doubt || c < -doubt || b + c > 1.0 + doubt) continue;
    const double t = glm::dot(v, q) / determinant;
    const double error = shift / glm::length(direction) / sine + 1e-15 * std::abs(t);
    const bool sure = b > doubt && c > doubt && b + c < 1.0 - doubt && sine > 1e-4;
    out.push_back({slot, t, error, sure});
  }
}

/// Where the ray comes into what the planes keep. Several planes at one place make it doubtful.
std::vector<Crossing> cut_places(const Ray& ray, const RayFilter& filter) {
  std::vector<Crossing> planes, places;
  for (const core::Plane& plane : filter.sections) {
    const double slope = glm::dot(plane.normal, ray.direction);
    if (slope == 0.0) continue;
    const double size = glm::length(ray.origin) * glm::length(plane.normal) + std::abs(plane.offset);
    planes.push_back({0, -core::evaluate(plane, ray.origin) / slope, kSolidError * size / std::abs(slope), true});
  }
  std::sort(planes.begin(), planes.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  for (std::size_t i = 0; i < planes.size(); ++i) {
    Crossing here = planes[i];
    const double before = i > 0 ? planes[i - 1].t : here.t - 1.0 / glm::length(ray.direction);
    const double after = i + 1 < planes.size() ? planes[i + 1].t : here.t + 1.0 / glm::length(ray.direction);
    const auto keeps = [&](double t) { return kept(filter, ray.origin + t * ray.direction, 0.0) == Kept::kYes; };
    here.sure = here.t - before > 2.0 * here.error && after - here.t > 2.0 * here.error;
    if (!here.sure || (!keeps(0.5 * (before + here.t)) && keeps(0.5 * (here.t + after)))) places.push_back(here);
  }
  return places;
}

/// The cut of a closed item at a place, if it is there or may be. `crossings`: all of the item along the whole line.
void add_cut(const Snapshot& snapshot, Slot slot, const Ray& ray, const Crossing& place,
             const std::vector<Crossing>& crossings, std::vector<Crossing>& out) {
  if (!(place.t > ray.t_min - place.error && place.t < ray.t_max + place.error)) return;
  Crossing cut = place;
  cut.slot = slot;
  cut.sure &= place.t > ray.t_min + place.error && place.t < ray.t_max - place.error;
  int before = 0;
  for (const Crossing& c : crossings) {
    before += c.t < place.t;
    cut.sure &= c.sure && std::abs(c.t - place.t) > c.error + place.error;
  }
  if (int(snapshot.kind(slot)) < core::kPrimitiveKindCount) before /= 5;  // of five rays
  if (!cut.sure || before % 2 == 1) out.push_back(cut);
}

}  // namespace

std::vector<Crossing> brute_force(const Snapshot& snapshot, const Ray& ray, const RayFilter& filter) {
  std::vector<Crossing> found, result, places;
  if (filter.cuts) places = cut_places(ray, filter);
  for (Slot slot = 0; slot < snapshot.size(); ++slot) {
    if (snapshot.vacant(slot) || (snapshot.bounds().layers(slot) & filter.layers) == 0) continue;
    const std::size_t first = found.size();
    if (int(snapshot.kind(slot)) < core::kPrimitiveKindCount)
      solid_crossings(snapshot, slot, ray, found);
    else
      mesh_crossings(snapshot, slot, ray, found);
    for (const Crossing& place : places)
      add_cut(snapshot, slot, ray, place, {found.begin() + std::ptrdiff_t(first), found.end()}, result);
  }
  for (Crossing c : found) {
    if (c.t < ray.t_min - c.error || c.t > ray.t_max + c.error) continue;
    c.sure &= c.t > ray.t_min + c.error && c.t < ray.t_max - c.error;
    const double shift = c.error * glm::length(ray.direction);
    const Kept keep = kept(filter, ray.origin + c.t * ray.direction, shift + 1e-12 * glm::length(ray.origin));
    if (keep == Kept::kNo) continue;
    c.sure &= keep == Kept::kYes;
    result.push_back(c);
  }
  return result;
}

}  // namespace sightline::raytrace
