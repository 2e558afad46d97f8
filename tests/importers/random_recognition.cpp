#include "random_recognition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/surface_area.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/recognise/internal/recognise.h"
#include "sightline/importers/recognise/internal/surface_distance.h"
#include "sightline/tests/importers/triangle_distance.h"

namespace sightline::tests {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Mesh;
using core::Primitive;
using core::vec3;
using importers::RecognisedMesh;
using importers::RecognisedPrimitive;

constexpr std::size_t kMostTriangles = 3000;  // before the last part is added
constexpr double kPi = std::numbers::pi;

// --- meshes from bytes ----------------------------------------------------------------------------------------------

/// Bytes, and the values made of them; zeros at the end.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  bool used_up() const { return at_ == end_; }
  unsigned byte() { return at_ == end_ ? 0 : *at_++; }
  unsigned below(unsigned n) { return (n <= 256 ? byte() : byte() << 8 | byte()) % n; }
  bool one_in(unsigned n) { return byte() % n == n - 1; }
  double between(double low, double high) { return low + (high - low) * double(byte() << 8 | byte()) / 65535.0; }
  float odd() {
    constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::max(),
                              -std::numeric_limits<float>::max(),
                              std::numeric_limits<float>::min(),
                              std::numeric_limits<float>::denorm_min(),
                              -0.0f,
                              1e19f,
                              1e-19f};
    return kOdd[below(10)];
  }
  float number() { return one_in(16) ? odd() : float(between(-2.0, 2.0)); }
  /// A length of a solid; now and then 0, or far from the others.
  float length() {
    constexpr float kOdd[] = {0.0f, 1e-6f, 1e-3f, 1e3f, 1e6f, -1.0f};
    return one_in(32) ? kOdd[below(6)] : float(between(0.1, 2.0));
  }
  dmat3 rotation() {
    if (one_in(4)) return dmat3(1.0);
    const double a = between(0.0, 2.0 * kPi), b = between(0.0, 2.0 * kPi);
    const dmat3 about_z(std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1);
    const dmat3 about_x(1, 0, 0, 0, std::cos(b), std::sin(b), 0, -std::sin(b), std::cos(b));
    return about_z * about_x;
  }
  dvec3 point(double reach) { return {between(-reach, reach), between(-reach, reach), between(-reach, reach)}; }

 private:
  const std::uint8_t *at_, *end_;
};

/// Scatter of a lathe: numbers as random as the seed, so that one byte of input moves all vertices.
double scatter(std::uint64_t seed) {
  seed = (seed ^ seed >> 30) * 0xbf58476d1ce4e5b9u;
  seed = (seed ^ seed >> 27) * 0x94d049bb133111ebu;
  return double((seed ^ seed >> 31) >> 11) * 0x1p-52 - 1.0;
}

Primitive primitive_from(Input& in) {
  const float r = in.length(), h = in.length(), angle = in.one_in(4) ? float(2.0 * kPi) : float(in.between(0.05, 6.2));
  const auto share = [&] { return float(in.between(-1.0, 1.0)); };
  switch (in.below(10)) {
    case 0:
      return core::Cylinder{r, h};
    case 1:
      return core::Snout{r, in.one_in(4) ? 0.0f : in.length(), h, 0, 0, 0, 0, 0, 0};
    case 2:
      return core::Snout{r, in.length(), h, share() * r, share() * r, 0, 0, 0, 0};
    case 3:
      return core::Snout{
          r, in.one_in(2) ? r : in.length(), h, 0, 0, 0.7f * share(), 0.7f * share(), 0.7f * share(), 0.7f * share()};
    case 4:
      return core::CircularTorus{r + in.length(), r, angle};
    case 5:
      return core::RectangularTorus{in.one_in(4) ? 0.0f : r, r + in.length(), h, angle};
    case 6:
      return core::Sphere{r};
    case 7:
      return core::SphericalDish{r, std::min(h, r)};
    case 8:
      return core::EllipticalDish{r, h};
    default:
      return in.one_in(2) ? Primitive(core::Box{r, h, in.length()})
                          : Primitive(core::Pyramid{r, h, in.length(), in.length(), share(), share(), in.length()});
  }
}

/// Rings of vertices, one after the other, with flat ends or poles: what chains are walked over.
Mesh rings_from(Input& in) {
  Mesh mesh;
  const std::uint32_t n = 3 + in.below(30), rings = 2 + in.below(6);
  const double twist = in.one_in(4) ? in.between(-1.0, 1.0) : 0.0;
  dvec3 centre(0.0);
  double radius = in.length();
  dmat3 turn(1.0);
  for (std::uint32_t k = 0; k < rings; ++k) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const double a = 2.0 * kPi * i / n + twist * k;
      mesh.positions.push_back(vec3(centre + radius * (turn * dvec3(std::cos(a), std::sin(a), 0.0))));
    }
    if (in.one_in(2)) turn = turn * in.rotation();
    if (in.one_in(2)) radius = in.length();
    centre += double(in.length()) * turn[2];
  }
  const std::uint32_t last = (rings - 1) * n;
  const auto pole = std::uint32_t(mesh.positions.size());
  const bool poles[2] = {in.one_in(3), in.one_in(3)};
  if (poles[0] || poles[1]) {
    mesh.positions.push_back(mesh.positions[0] - vec3(double(in.length()) * turn[2]));
    mesh.positions.push_back(vec3(centre));
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t k = (i + 1) % n;
    for (std::uint32_t j = 0; j < last; j += n)
      mesh.indices.insert(mesh.indices.end(), {j + i, j + k, j + n + k, j + i, j + n + k, j + n + i});
    if (poles[0])
      mesh.indices.insert(mesh.indices.end(), {pole, k, i});
    else if (i > 0 && i + 1 < n)
      mesh.indices.insert(mesh.indices.end(), {0, i + 1, i});
    if (poles[1])
      mesh.indices.insert(mesh.indices.end(), {pole + 1, last + i, last + k});
    else if (i > 0 && i + 1 < n)
      mesh.indices.insert(mesh.indices.end(), {last, last + i, last + i + 1});
  }
  return mesh;
}

Mesh raw_from(Input& in) {
  Mesh mesh;
  const unsigned vertices = 1 + in.below(24), triangles = in.below(48);
  for (unsigned i = 0; i < vertices; ++i) {
    const float x = in.number(), y = in.number(), z = in.number();
    mesh.positions.emplace_back(x, y, z);
  }
  for (unsigned i = 0; i < 3 * triangles; ++i) mesh.indices.push_back(in.below(vertices));
  return mesh;
}

void place(Mesh& mesh, Input& in) {
  const double size = in.one_in(4) ? std::pow(10.0, in.between(-6.0, 6.0)) : 1.0;
  const dmat3 linear = size * in.rotation();
  const dvec3 origin = in.one_in(3) ? dvec3(0.0) : in.point((in.one_in(8) ? 1000.0 : 3.0) * size);
  for (vec3& p : mesh.positions) p = vec3(linear * dvec3(p) + origin);
  for (vec3& n : mesh.normals) n = vec3(linear * dvec3(n) / size);
}

void damage(Mesh& mesh, Input& in) {
  if (in.one_in(4)) {
    const double reach = std::pow(10.0, in.between(-7.0, -1.0));
    const std::uint64_t seed = std::uint64_t(in.byte()) << 40;
    std::uint64_t count = seed;
    for (vec3& p : mesh.positions)
      for (int k = 0; k < 3; ++k) p[k] += float(reach * scatter(++count));
  }
  const auto any = [&] { return 3 * std::ptrdiff_t(in.below(unsigned(mesh.indices.size() / 3))); };
  for (unsigned k = in.one_in(4) ? in.below(5) : 0; k > 0 && !mesh.indices.empty(); --k) {
    const auto at = mesh.indices.begin() + any();
    const std::array<std::uint32_t, 3> triangle{at[0], at[1], at[2]};
    switch (in.below(4)) {
      case 0:
        mesh.indices.erase(at, at + 3);
        break;
      case 1:
        std::swap(at[0], at[1]);
        break;
      case 2:
        mesh.indices.insert(mesh.indices.end(), triangle.begin(), triangle.end());
        break;
      default:
        mesh.positions[triangle[0]][int(in.below(3))] = in.number();
    }
  }
}

void append(Mesh& to, const Mesh& mesh) {
  const auto first = std::uint32_t(to.positions.size());
  // All vertices have normals, or none.
  const bool normals = (to.positions.empty() || !to.normals.empty()) && mesh.normals.size() == mesh.positions.size();
  to.positions.insert(to.positions.end(), mesh.positions.begin(), mesh.positions.end());
  if (normals)
    to.normals.insert(to.normals.end(), mesh.normals.begin(), mesh.normals.end());
  else
    to.normals.clear();
  for (const std::uint32_t i : mesh.indices) to.indices.push_back(first + i);
}

/// Every triangle with corners of its own, in another order.
Mesh soup(const Mesh& mesh, std::uint64_t seed) {
  std::vector<std::pair<double, std::uint32_t>> order;
  for (std::uint32_t t = 0; t < mesh.indices.size() / 3; ++t) order.emplace_back(scatter(seed + t), t);
  std::sort(order.begin(), order.end());
  Mesh out;
  for (const auto& [key, t] : order)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.indices[3 * t + (k + t) % 3];
      out.indices.push_back(std::uint32_t(out.positions.size()));
      out.positions.push_back(mesh.positions[v]);
      if (!mesh.normals.empty()) out.normals.push_back(mesh.normals[v]);
    }
  return out;
}

Mesh mesh_from(Input& in) {
  Mesh mesh, part;
  for (unsigned left = 1 + in.below(4); left > 0 && mesh.indices.size() / 3 < kMostTriangles; --left) {
    switch (in.below(8)) {
      case 0:
        part = raw_from(in);
        break;
      case 1:
        part = rings_from(in);
        break;
      case 2:  // the last one again, mostly touching it
        if (in.one_in(2))
          for (vec3& p : part.positions) p.z += in.one_in(2) ? 1.0f : in.length();
        break;
      default: {
        const Primitive primitive = primitive_from(in);
        part = gpuprims::tessellate(primitive, {.fixed_segments = int(3 + in.below(30))});
      }
    }
    place(part, in);
    damage(part, in);
    append(mesh, part);
  }
  if (in.one_in(3)) {
    const double step = std::pow(10.0, -double(in.below(6)));
    for (vec3& p : mesh.positions) p = vec3(step * glm::round(dvec3(p) / step));
  }
  return in.one_in(2) ? soup(mesh, in.byte()) : mesh;
}

Affine placement_from(Input& in) {
  Affine map{in.rotation(), in.point(10.0)};
  switch (in.below(8)) {
    case 0:
      map.linear *= in.between(-3.0, 3.0);
      break;
    case 1:
      map.linear *= std::pow(10.0, in.between(-45.0, 45.0));
      break;
    case 2:
      for (int k = 0; k < 3; ++k) map.linear[k] *= in.between(-50.0, 50.0);
      break;
    case 3:
      map.linear = map.linear * dmat3(1, 0, 0, in.between(-4.0, 4.0), 1, 0, in.between(-4.0, 4.0), 0.5, 1);
      break;
    case 4:
      map.linear[int(in.below(3))] *= in.one_in(2) ? 0.0 : 1e-30;
      break;
    case 5:
      map.linear[int(in.below(3))][int(in.below(3))] = double(in.odd());
      map.origin[int(in.below(3))] = double(in.number());
      break;
    default:
      break;
  }
  return map;
}

// --- what must hold -------------------------------------------------------------------------------------------------

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same(const RecognisedMesh& a, const RecognisedMesh& b) {
  if (a.primitives.size() != b.primitives.size() || a.refused != b.refused) return false;
  for (std::size_t i = 0; i < a.primitives.size(); ++i) {
    const RecognisedPrimitive &p = a.primitives[i], &q = b.primitives[i];
    const auto x = core::parameters(p.primitive), y = core::parameters(q.primitive);
    if (core::kind_of(p.primitive) != core::kind_of(q.primitive) || !std::equal(x.begin(), x.end(), y.begin()) ||
        p.mesh_from_primitive.linear != q.mesh_from_primitive.linear || p.triangles != q.triangles ||
        p.mesh_from_primitive.origin != q.mesh_from_primitive.origin || p.deviation != q.deviation ||
        p.along != q.along)
      return false;
  }
  return same_bits(a.rest.positions, b.rest.positions) && same_bits(a.rest.normals, b.rest.normals) &&
         same_bits(a.rest.indices, b.rest.indices);
}

/// The triangles of the mesh that are not in the rest; nothing if the rest is not part of the mesh, in its order.
std::optional<std::vector<std::uint32_t>> removed_from(const Mesh& mesh, const Mesh& rest) {
  if (!core::validate(rest) || rest.normals.size() != (mesh.normals.empty() ? 0 : rest.positions.size())) return {};
  const auto same_corner = [&](std::size_t i, std::size_t j) {
    const std::uint32_t v = mesh.indices[i], w = rest.indices[j];
    return std::memcmp(&mesh.positions[v], &rest.positions[w], sizeof(vec3)) == 0 &&
           (mesh.normals.empty() || std::memcmp(&mesh.normals[v], &rest.normals[w], sizeof(vec3)) == 0);
  };
  std::vector<std::uint32_t> removed;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    if (kept < rest.indices.size() && same_corner(i, kept) && same_corner(i + 1, kept + 1) &&
        same_corner(i + 2, kept + 2))
      kept += 3;
    else
      removed.push_back(std::uint32_t(i / 3));
  }
  return kept == rest.indices.size() ? std::optional(std::move(removed)) : std::nullopt;
}

/// What is left of the surface without ends that need no triangles: those between two pieces of a pipe.
double area_of_ends(const Primitive& primitive) {
  const auto disc = [](double radius) { return kPi * radius * radius; };
  if (const auto* c = std::get_if<core::Cylinder>(&primitive)) return 2.0 * disc(c->radius);
  if (const auto* s = std::get_if<core::Snout>(&primitive)) {
    const auto slanted = [&](double radius, double x, double y) {
      return disc(radius) * std::sqrt(1.0 + std::tan(x) * std::tan(x) + std::tan(y) * std::tan(y));
    };
    return slanted(s->bottom_radius, s->bottom_shear_x, s->bottom_shear_y) +
           slanted(s->top_radius, s->top_shear_x, s->top_shear_y);
  }
  if (const auto* t = std::get_if<core::CircularTorus>(&primitive)) return 2.0 * disc(t->tube_radius);
  if (const auto* d = std::get_if<core::SphericalDish>(&primitive)) return disc(d->base_radius);
  if (const auto* d = std::get_if<core::EllipticalDish>(&primitive)) return disc(d->base_radius);
  return 0.0;
}

class MeshCheck {
 public:
  MeshCheck(const Mesh& mesh, const RecognisedMesh& found) : mesh_(mesh), found_(found) {
    double size = 0.0;
    for (const vec3& p : mesh.positions)
      for (int k = 0; k < 3; ++k)
        if (std::isfinite(p[k])) size = std::max(size, std::fabs(double(p[k])));
    slack_ = 1e-6 * size;  // vertices within the rounding of floats are one
  }

  std::string run() {
    if (found_.primitives.empty()) return found_.rest.indices.empty() ? "" : "no rest where nothing was recognised";
    const auto removed = removed_from(mesh_, found_.rest);
    if (!removed) return "a rest that is part of the mesh, in order";
    std::size_t claimed = 0;
    for (const RecognisedPrimitive& p : found_.primitives) {
      claimed += p.triangles;
      if (!sound(p)) return "a primitive with a place";
    }
    if (claimed != removed->size()) return "as many triangles taken away as the primitives replace";
    for (const std::uint32_t t : *removed) {
      std::array<dvec3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) corners[k] = dvec3(mesh_.positions[mesh_.indices[3 * t + k]]);
      triangles_.push_back(corners);
      area_ += 0.5 * glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
    }
    if (!triangles_on_primitives()) return "triangles within the deviation of what replaces them";
    if (!areas_agree()) return "primitives as large as the triangles that they replace";
    if (!primitives_on_triangles()) return "primitives within the deviation of the triangles that they replace";
    return {};
  }

 private:
  static bool sound(const RecognisedPrimitive& p) {
    if (!core::is_finite(p.mesh_from_primitive) || !(p.deviation >= 0.0) || !std::isfinite(p.deviation)) return false;
    for (const float value : core::parameters(p.primitive))
      if (!std::isfinite(value)) return false;
    const dmat3& turn = p.mesh_from_primitive.linear;
    const dmat3 one = glm::transpose(turn) * turn;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r)
        if (std::fabs(one[c][r] - (c == r ? 1.0 : 0.0)) > 1e-9) return false;
    return glm::determinant(turn) > 0.0 && !core::is_degenerate(p.primitive);
  }

  bool triangles_on_primitives() const {
    std::vector<importers::recognition::SurfaceDistance> distances;
    for (const RecognisedPrimitive& p : found_.primitives)
      distances.push_back(importers::recognition::surface_distance(p.primitive));
    return std::all_of(triangles_.begin(), triangles_.end(), [&](const std::array<dvec3, 3>& t) {
      for (std::size_t i = 0; i < distances.size(); ++i) {
        const RecognisedPrimitive& p = found_.primitives[i];
        const dmat3 turn = glm::transpose(p.mesh_from_primitive.linear);
        const auto off = [&](const dvec3& q) { return distances[i](turn * (q - p.mesh_from_primitive.origin)); };
        double most = 0.0;
        for (std::size_t k = 0; k < 3; ++k) most = std::max({most, off(t[k]), off(0.5 * (t[k] + t[(k + 1) % 3]))});
        most = std::max(most, off((t[0] + t[1] + t[2]) / 3.0));
        if (most <= p.deviation + slack_) return true;
      }
      return false;
    });
  }

  bool areas_agree() const {
    double least = 0.0, most = 0.0;
    for (const RecognisedPrimitive& p : found_.primitives) {
      const double area = core::surface_area(p.primitive);
      least += std::max(0.0, 0.75 * area - 1.06 * area_of_ends(p.primitive));
      most += 1.05 * area;
    }
    double slack = 0.0;
    for (const auto& t : triangles_) slack += slack_ * (glm::length(t[1] - t[0]) + glm::length(t[2] - t[0]));
    return area_ >= least - slack && area_ <= most + slack;
  }

  bool primitives_on_triangles() const {
    constexpr std::size_t kMostPairs = 400'000;
    std::size_t pairs = 0;
    for (const RecognisedPrimitive& p : found_.primitives) {
      // Without ends that need no triangles. Vertices lie on the surface, and where it is flat so do centres.
      const Mesh surface = gpuprims::tessellate(p.primitive, {.fixed_segments = 8}, {.bottom = false, .top = false});
      std::vector<vec3> points = surface.positions;
      if (std::holds_alternative<core::Box>(p.primitive) || std::holds_alternative<core::Pyramid>(p.primitive))
        for (std::size_t i = 0; i < surface.indices.size(); i += 3)
          points.push_back((surface.positions[surface.indices[i]] + surface.positions[surface.indices[i + 1]] +
                            surface.positions[surface.indices[i + 2]]) /
                           3.0f);
      for (const vec3& point : points) {
        if ((pairs += triangles_.size()) > kMostPairs) return true;
        const dvec3 q = core::transform_point(p.mesh_from_primitive, dvec3(point));
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& t : triangles_) nearest = std::min(nearest, distance_to_triangle(q, t));
        if (!(nearest <= 2.0 * p.deviation + slack_)) return false;
      }
    }
    return true;
  }

  const Mesh& mesh_;
  const RecognisedMesh& found_;
  std::vector<std::array<dvec3, 3>> triangles_;  // that were taken away
  double area_ = 0.0, slack_ = 0.0;
};

}  // namespace

RecognitionInput recognition_input(const std::uint8_t* data, std::size_t size) {
  Input in(data, size);
  RecognitionInput input;
  // Placements come first, so that what is appended to an input changes the mesh alone.
  if (in.one_in(3)) input.node = placement_from(in);
  for (unsigned left = 1 + in.below(3); left > 0; --left) input.placements.push_back(placement_from(in));
  input.stop_after = in.below(8);
  if (in.one_in(4)) input.tolerance = std::pow(10.0, in.between(-6.0, 1.0));
  input.mesh = mesh_from(in);
  return input;
}

std::string check_mesh(const RecognitionInput& input) {
  const RecognisedMesh found = importers::recognise(input.mesh, input.tolerance);
  if (!same(found, importers::recognise(input.mesh, input.tolerance))) return "the same result twice";
  return MeshCheck(input.mesh, found).run();
}

std::string check_items(const RecognitionInput& input) {
  core::Scene scene;
  const core::NodeId node = scene.add_node(scene.root(), "node");
  if (core::is_finite(input.node)) scene.set_transform(node, input.node);
  const auto mesh = scene.add_mesh(input.mesh);
  const bool valid =
      std::ranges::all_of(input.mesh.positions, [](const core::vec3& p) { return core::is_finite(dvec3(p)); });
  if (mesh.has_value() != valid)
    return valid ? "a valid mesh: " + mesh.error().message : "a position that is not finite";
  if (!valid) return "";
  std::size_t items = 0;
  for (const Affine& placement : input.placements) {
    const core::ItemId item = scene.add_mesh_instance(node, *mesh, placement);
    if (scene.can_commit(item, scene.state(item).world_from_item))
      ++items;
    else
      scene.remove_item(item);  // as importers do
  }
  importers::RecognitionReport report;
  unsigned calls = 0;
  const bool done = importers::recognise_items(
      scene, core::ItemId{0}, input.tolerance,
      [&](double) { return input.stop_after == 0 || ++calls < input.stop_after; }, report);
  if (!done && input.stop_after == 0) return "an end that nobody asked for";
  std::uint64_t primitives = 0, triangles = 0, made = 0;
  for (core::ItemId i{0}; to_index(i) < scene.item_slots(); ++i)
    primitives += scene.contains_item(i) && int(scene.kind(i)) < core::kPrimitiveKindCount;
  for (std::size_t i = 0; i < scene.mesh_slots(); ++i)
    if (const core::MeshId id = scene.mesh_at(i); id.valid()) triangles += scene.mesh(id).indices.size() / 3;
  for (const std::uint64_t of_kind : report.items) made += of_kind;
  if (made != primitives) return "as many primitives as reported";
  if (done && items > 0 && report.triangles_before != input.mesh.indices.size() / 3) return "triangles before";
  if (done && items > 0 && report.triangles_after != triangles) return "triangles after";
  if (primitives == 0 && scene.item_count() != items) return "the items as they were";
  if (!(report.largest_deviation >= 0.0)) return "a deviation";
  if (const auto committed = scene.commit(); !committed)
    return "a scene that can be committed: " + committed.error().message;
  if (core::Snapshot(scene).size() != scene.item_count()) return "a snapshot of all items";
  return {};
}

}  // namespace sightline::tests
