#include "sightline/importers/gltf/internal/gltf_geometry.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sightline/core/internal/sort_unique.h"
#include "sightline/core/internal/srgb.h"

namespace sightline::importers {
namespace {

constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;

std::vector<std::uint32_t> vertex_order(GltfDocument& document, const GltfSources& sources, std::uint64_t vertices,
                                        const std::string& where) {
  const GltfAccessor* indices =
      sources.indices == core::kNone ? nullptr : &document.accessor(sources.indices, where + "/indices");
  if (indices && (indices->components != 1 || indices->type == NumberType::kFloat))
    gltf_fail("{}/indices: expected whole numbers, found another type", where);
  const std::uint64_t count = indices ? indices->count : vertices;
  const std::uint64_t corners = sources.mode == kTriangles ? count : count < 3 ? 0 : 3 * (count - 2);
  if (!document.take_corners(corners))
    gltf_fail("{}: more triangles than a file of {} bytes may hold", where, document.bytes_read());
  std::vector<std::uint32_t> order(count);
  if (!indices) {
    for (std::uint64_t i = 0; i < count; ++i) order[i] = std::uint32_t(i);
    return order;
  }
  constexpr std::uint64_t kBlock = 1024;
  double block[kBlock];
  for (std::uint64_t first = 0; first < count; first += kBlock) {
    const std::uint64_t n = std::min(kBlock, count - first);
    indices->read(first, n, block);
    for (std::uint64_t i = 0; i < n; ++i)
      order[first + i] = block[i] >= 0.0 ? std::uint32_t(block[i]) : core::kNone;  // negative: no vertex
  }
  return order;
}

/// Calls visit(a, b, c) for each triangle (glTF 2.0, 3.7.2.1).
template <class Visit>
void for_each_triangle(const std::vector<std::uint32_t>& order, std::uint64_t mode, Visit&& visit) {
  const std::size_t n = order.size();
  if (mode == kTriangles)
    for (std::size_t i = 0; i + 2 < n; i += 3) visit(order[i], order[i + 1], order[i + 2]);
  if (mode == kStrip)
    for (std::size_t i = 0; i + 2 < n; ++i) visit(order[i], order[i + 1 + i % 2], order[i + 2 - i % 2]);
  if (mode == kFan)
    for (std::size_t i = 0; i + 2 < n; ++i) visit(order[i + 1], order[i + 2], order[0]);
}

const GltfAccessor& vectors(GltfDocument& document, std::uint64_t index, const std::string& where) {
  const GltfAccessor& found = document.accessor(index, where);
  if (found.components != 3) gltf_fail("{}: expected VEC3, found another type", where);
  return found;
}

/// Renumbers corners from 0 and returns the vertices that they referred to, in rising order. Empty: all vertices from
/// `first` on.
std::vector<std::uint32_t> compact(std::vector<std::uint32_t>& corners, std::uint32_t& first, std::uint32_t& count) {
  const auto [low, high] = std::minmax_element(corners.begin(), corners.end());
  first = *low;
  count = *high - *low + 1;
  std::vector<std::uint32_t> used;
  // Several primitives may share one long list of vertices: the cost of each must follow its own corners.
  if (count > corners.size()) {
    used = corners;
    core::sort_unique(used);
    for (std::uint32_t& corner : corners)
      corner = std::uint32_t(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
    count = std::uint32_t(used.size());
  } else {
    for (std::uint32_t& corner : corners) corner -= first;
  }
  return used;
}

}  // namespace

GltfSources gltf_sources(const Json& primitive, const std::string& where) {
  GltfSources sources;
  sources.mode = gltf_index(primitive, "mode", where, kTriangles);
  if (sources.mode > kFan) gltf_fail("{}/mode: expected 0 … 6, found {}", where, sources.mode);
  if (!sources.draws_triangles()) return sources;
  const Json* attributes = gltf_find(primitive, "attributes");
  sources.positions = core::kNone;
  if (!attributes || !gltf_find(*attributes, "POSITION")) return sources;  // nothing to be drawn (glTF 2.0, 3.7.2.1)
  const std::string at = where + "/attributes";
  sources.positions = gltf_index(*attributes, "POSITION", at);
  sources.normals = gltf_index(*attributes, "NORMAL", at, core::kNone);
  sources.colours = gltf_index(*attributes, "COLOR_0", at, core::kNone);
  sources.indices = gltf_indices(primitive, where);
  return sources;
}

std::vector<std::uint32_t> gltf_triangles(ImportJob& job, GltfDocument& document, const GltfSources& sources,
                                          const std::string& where) {
  const std::uint64_t vertices = vectors(document, sources.positions, where + "/attributes/POSITION").count;
  const std::vector<std::uint32_t> order = vertex_order(document, sources, vertices, where);
  std::vector<std::uint32_t> corners;
  corners.reserve(sources.mode == kTriangles ? order.size() : 3 * order.size());
  std::uint64_t beyond = 0;
  for_each_triangle(order, sources.mode, [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (std::max({a, b, c}) >= vertices)
      ++beyond;
    else if (sources.mode == kTriangles || (a != b && b != c && c != a))  // strips are stitched with empty triangles
      corners.insert(corners.end(), {a, b, c});
  });
  if (beyond > 0)
    refuse_or_warn(job, fmt::format("{}/indices: expected indices below the {} vertices, found {} triangles beyond",
                                    where, vertices, beyond));
  else if (sources.mode == kTriangles && order.size() % 3 != 0)
    refuse_or_warn(job,
                   fmt::format("{}: expected three corners for each triangle, found {} corners", where, order.size()));
  return corners;
}

double gltf_colour_channel(double value, const GltfAccessor& of) {
  double most = 1.0;
  if (!of.normalized && of.type == NumberType::kUint8) most = 255.0;
  if (!of.normalized && of.type == NumberType::kUint16) most = 65535.0;
  return std::clamp(std::isfinite(value) ? value / most : 1.0, 0.0, 1.0);
}

std::vector<PackedColour> gltf_face_colours(GltfDocument& document, const GltfSources& sources,
                                            const std::vector<std::uint32_t>& corners, const std::string& where) {
  std::vector<PackedColour> colours;
  if (sources.colours == core::kNone) return colours;
  const std::string here = where + "/attributes/COLOR_0";
  const GltfAccessor& accessor = document.accessor(sources.colours, here);
  const std::uint64_t vertices = document.accessor(sources.positions, where + "/attributes/POSITION").count;
  if (accessor.components != 3 && accessor.components != 4)
    gltf_fail("{}: expected VEC3 or VEC4, found another type", here);
  if (accessor.count != vertices) gltf_fail("{}: expected {} colours, found {}", here, vertices, accessor.count);
  colours.reserve(corners.size() / 3);
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    for (std::size_t k = i; k < i + 3; ++k) {
      double colour[4] = {1.0, 1.0, 1.0, 1.0};
      accessor.read(corners[k], 1, colour);
      for (int c = 0; c < accessor.components; ++c) sum[c] += gltf_colour_channel(colour[c], accessor);
      if (accessor.components == 3) sum[3] += 1.0;
    }
    std::uint32_t bytes[4];
    for (int c = 0; c < 4; ++c)
      bytes[c] = std::uint32_t(std::lround(255.0 * (c < 3 ? core::srgb_from_linear(sum[c] / 3.0) : sum[c] / 3.0)));
    // Invisible black would stand for no colour.
    colours.push_back(pack_colour(bytes[0], bytes[1], bytes[2], std::max(bytes[3], 1u)));
  }
  return colours;
}

namespace {

/// Null where there are none, or where they do not fit: then there is a warning.
const GltfAccessor* usable_normals(ImportJob& job, GltfDocument& document, const GltfSources& sources,
                                   std::uint64_t vertices, const std::string& where) {
  if (sources.normals == core::kNone) return nullptr;
  const GltfAccessor* found = nullptr;
  const bool usable = or_warn(job, "normals left out", [&] {
    const std::string here = where + "/attributes/NORMAL";
    found = &vectors(document, sources.normals, here);
    if (found->count != vertices) gltf_fail("{}: expected {} normals, found {}", here, vertices, found->count);
  });
  return usable ? found : nullptr;
}

}  // namespace

PolygonMesh gltf_mesh(ImportJob& job, GltfDocument& document, const GltfSources& sources,
                      std::vector<std::uint32_t> corners, const std::string& where) {
  PolygonMesh mesh;
  if (corners.empty()) return mesh;
  const GltfAccessor& positions = vectors(document, sources.positions, where + "/attributes/POSITION");
  const GltfAccessor* normals = usable_normals(job, document, sources, positions.count, where);
  std::uint32_t first = 0, count = 0;
  const std::vector<std::uint32_t> used = compact(corners, first, count);
  static_assert(sizeof(core::dvec3) == 3 * sizeof(double));
  mesh.positions.resize(count);
  if (used.empty()) positions.read(first, count, &mesh.positions[0].x);
  for (std::size_t i = 0; i < used.size(); ++i) positions.read(used[i], 1, &mesh.positions[i].x);
  if (normals) mesh.normals.reserve(count);
  for (std::uint32_t i = 0; normals && i < count; ++i) {
    core::dvec3 normal(0.0);
    normals->read(used.empty() ? first + i : used[i], 1, &normal.x);
    mesh.normals.emplace_back(normal);
  }
  mesh.corners = std::move(corners);
  return mesh;
}

void GltfTable::open(GltfDocument& document, const Json& attributes, std::span<const Column> columns,
                     const std::string& where) {
  accessors_.assign(columns.size(), nullptr);
  blocks_.assign(columns.size(), {});
  bool any = false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = columns[i];
    if (!gltf_find(attributes, column.name) && !column.required) continue;
    const std::string here = fmt::format("{}/{}", where, column.name);
    const GltfAccessor& found = document.accessor(gltf_index(attributes, column.name, where), here);
    if (found.components != column.components)
      gltf_fail("{}: expected {} numbers for each instance, found {}", here, column.components, found.components);
    if (any && found.count != count_)
      gltf_fail("{}: expected {} instances as the attributes before it, found {}", here, count_, found.count);
    accessors_[i] = &found;
    count_ = found.count;
    any = true;
  }
}

std::uint64_t GltfTable::load(std::uint64_t first) {
  const std::uint64_t n = std::min(kBlock, count_ - first);
  for (std::size_t i = 0; i < accessors_.size(); ++i) {
    if (!accessors_[i]) continue;
    blocks_[i].resize(n * std::uint64_t(accessors_[i]->components));
    accessors_[i]->read(first, n, blocks_[i].data());
  }
  return n;
}

core::Affine gltf_affine(const double* m) {
  return {core::dmat3(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]), {m[12], m[13], m[14]}};
}

core::Affine gltf_affine(const double* translation, const double* rotation, const double* scale) {
  core::Affine map;
  if (translation) map.origin = {translation[0], translation[1], translation[2]};
  const double length =
      rotation ? std::hypot(std::hypot(rotation[0], rotation[1]), std::hypot(rotation[2], rotation[3])) : 0.0;
  if (length > 0.0) {
    const double x = rotation[0] / length, y = rotation[1] / length, z = rotation[2] / length, w = rotation[3] / length;
    map.linear = core::dmat3(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),  //
                             2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w),  //
                             2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y));
  }
  for (int i = 0; scale && i < 3; ++i) map.linear[i] *= scale[i];
  return map;
}

}  // namespace sightline::importers
