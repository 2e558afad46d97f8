#include "sightline/culling/occlusion/occluder_raster.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/core/internal/scratch.h"
#include "sightline/culling/occlusion/internal/inner_occluders.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/occluder_area.h"
#include "sightline/culling/occlusion/internal/polygon_area.h"
#include "sightline/culling/occlusion/internal/prisms.h"
#include "sightline/culling/occlusion/internal/raster_placement.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::culling {
namespace {

using core::Affine;
using core::dvec3;
using core::dvec4;
using raster::Corner;
using raster::cube;
using raster::kMostError;
using raster::Placement;
using raster::Point;
using raster::Prism;
using raster::prism;

// --- areas -----------------------------------------------------------------------------------------------------------

/// A convex polygon, or the outline of a convex solid, with the faces that are seen in it. The sides turn left around
/// it.
struct Polygon {
  struct Side {
    std::uint8_t from, to;
  };
  struct Face {
    const std::uint8_t* corners;
    int count;
  };
  explicit Polygon(std::span<const Corner> all) : corners(all) {}

  std::span<const Corner> corners;
  std::array<Side, OccluderArea::kMostSides> sides;
  std::array<Face, OccluderArea::kMostPlanes> faces;
  int side_count = 0, face_count = 0;  // no faces: the farthest corner counts

  void add_side(std::uint8_t from, std::uint8_t to) { sides[std::size_t(side_count++)] = {from, to}; }
  void add_face(const Face& face) { faces[std::size_t(face_count++)] = face; }
};

struct OneAtATime {};
using Area = raster::PolygonArea<OneAtATime, double, false>;

Area::Diagonals diagonals_of(std::span<const Corner> corners, const Polygon::Face& face) {
  return Area::diagonals(face.count, [&](int i) { return corners[face.corners[i]]; });
}

/// 1, -1; 0 where rounding leaves the sign of the area open.
int winding_of(std::span<const Corner> corners, const Polygon::Face& face) {
  double error = 0.0;
  for (const int i : {0, face.count / 4, face.count / 2, 3 * face.count / 4})
    error = std::max(error, corners[face.corners[i]].error);
  const Area::Diagonals diagonals = diagonals_of(corners, face);
  const double open = diagonals.open(error);
  return diagonals.area > open ? 1 : diagonals.area < -open ? -1 : 0;
}

void find_lines(const Area& found, std::span<const Area::Side> sides, OccluderArea& area) {
  area.left_count = area.right_count = 0;
  for (const Area::Side& side : sides) {
    const Area::Line line = found.line(side);
    if (!line.counts) continue;
    const OccluderArea::Side of_rows{float(line.x), float(line.slope)};
    if (line.falls)
      area.left[area.left_count++] = of_rows;
    else
      area.right[area.right_count++] = of_rows;
  }
}

void find_planes(const Area& found, const Polygon& polygon, OccluderArea& area) {
  area.plane_count = 0;
  area.least = float(found.least());
  for (int i = 0; i < polygon.face_count; ++i) {
    const Polygon::Face& face = polygon.faces[std::size_t(i)];
    const Area::Plane plane = found.plane(face.count, [&](int k) { return polygon.corners[face.corners[k]]; });
    if (!plane.usable) {
      area.plane_count = 0;
      break;
    }
    area.planes[area.plane_count++] = {float(plane.x), float(plane.y), float(plane.constant)};
  }
  if (area.plane_count == 0) area.planes[area.plane_count++] = {0.0f, 0.0f, area.least};
}

/// Fills a polygon, made smaller by `shift` pixels along both axes: what a rasteriser may move a corner.
bool cover(OccluderImage& image, const Polygon& polygon, double shift) {
  Area found;
  for (const Corner& c : polygon.corners) {
    if (!(c.error < kMostError)) return false;
    found.add(c.x, c.y, c.reciprocal_depth, c.error);
  }
  if (polygon.side_count == 0 || !found.find_pixels(image.width, image.height, shift)) return false;
  std::array<Area::Side, OccluderArea::kMostSides> sides;
  for (std::size_t i = 0; i < std::size_t(polygon.side_count); ++i) {
    const Corner &from = polygon.corners[polygon.sides[i].from], &to = polygon.corners[polygon.sides[i].to];
    sides[i] = {from.x, from.y, to.x - from.x, to.y - from.y};
    if (Area::level(sides[i])) found.limit_rows(sides[i]);
  }
  if (!found.take_rows(image.height)) return false;

  OccluderArea area;
  area.column = int(found.column()), area.row = int(found.first_row());
  area.columns = int(found.columns()), area.rows = int(found.rows());
  find_lines(found, std::span(sides).first(std::size_t(polygon.side_count)), area);
  find_planes(found, polygon, area);
  occlusion_kernels().fill_area(area, image.reciprocal_depth.data(), image.stride);
  return true;
}

constexpr std::uint8_t kInOrder[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19};
static_assert(std::size(kInOrder) == OccluderArea::kMostSides);

/// The face of all these corners, three at least.
Polygon::Face all_of(std::span<const Corner> corners) {
  return {kInOrder, int(corners.size())};
}

/// A convex polygon by itself. `turn`: its own.
bool cover_polygon(OccluderImage& image, std::span<const Corner> corners, int winding, double shift) {
  const int count = int(corners.size());
  Polygon polygon(corners);
  for (int i = 0; i < count; ++i) {
    const auto from = std::uint8_t(i), to = std::uint8_t((i + 1) % count);
    winding > 0 ? polygon.add_side(from, to) : polygon.add_side(to, from);
  }
  polygon.add_face(all_of(corners));
  return cover(image, polygon, shift);
}

// --- occluders -------------------------------------------------------------------------------------------------------

/// Whether a face lies so near to a side of the outline, or outside, that no pixel which the polygon covers can see it.
bool at_outline(const Polygon& polygon, const Polygon::Face& face, double snap) {
  const auto beyond = [&](const Polygon::Side& side) {
    const Corner &p = polygon.corners[side.from], &q = polygon.corners[side.to];
    const double dx = q.x - p.x, dy = q.y - p.y, most = 0.5 * snap * (std::abs(dx) + std::abs(dy));
    for (int i = 0; i < face.count; ++i) {
      const Corner& c = polygon.corners[face.corners[i]];
      if (!(dx * (c.y - p.y) - dy * (c.x - p.x) <= most)) return false;
    }
    return true;
  };
  return std::any_of(polygon.sides.begin(), polygon.sides.begin() + polygon.side_count, beyond);
}

/// A solid beyond the near plane. `turn`: of its front faces.
bool cover_whole(OccluderImage& image, const Prism& solid, std::span<const Corner> corners, int winding) {
  Polygon polygon(corners);
  std::array<int, Prism::kMostSides + 2> windings{};
  const auto face_of = [&](std::size_t i) { return Polygon::Face{solid.faces[i].data(), int(solid.faces[i].size())}; };
  for (std::size_t i = 0; i < solid.faces.size(); ++i) {
    windings[i] = winding_of(corners, face_of(i));
    if (windings[i] != winding) continue;
    if (polygon.face_count == OccluderArea::kMostPlanes) return false;
    polygon.add_face(face_of(i));
  }
  for (const Prism::Edge& edge : solid.edges) {
    const bool left = windings[edge.left] == winding, right = windings[edge.right] == winding;
    if (left == right) continue;
    if (polygon.side_count == OccluderArea::kMostSides) return false;
    left == (winding > 0) ? polygon.add_side(edge.from, edge.to) : polygon.add_side(edge.to, edge.from);
  }
  for (std::size_t i = 0; i < solid.faces.size(); ++i)
    if (windings[i] == 0 && !at_outline(polygon, face_of(i), image.snap)) polygon.face_count = 0;
  return cover(image, polygon, image.snap);
}

struct ClipBuffers {
  std::vector<Point> polygon, clipped;
  std::vector<Corner> corners;  // of what lies in front, in the image

  std::size_t memory_bytes() const { return core::bytes_of(polygon, clipped, corners); }
};

/// Finds the corners of what lies in front of the polygon. Changes the polygon.
void clip(const Placement& placement, ClipBuffers& buffers) {
  auto& [polygon, clipped, corners] = buffers;
  for (int k = 0; k < Placement::kClipPlanes; ++k) {
    clipped.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double from = placement.inside(k, a), to = placement.inside(k, b), s = from / (from - to);
      const auto between = [s](double low, double high) { return low + s * (high - low); };
      if (from > 0.0) clipped.push_back(a);
      if ((from > 0.0) != (to > 0.0))
        clipped.push_back({between(a.x, b.x), between(a.y, b.y), between(a.z, b.z), between(a.near, b.near)});
    }
    polygon.swap(clipped);
  }
  corners.clear();
  for (const Point& p : polygon) corners.push_back(placement.project(p));
}

/// Lines of sight through a face of a solid enter the solid made `growth` times as large about the middle of its
/// corners at this part of the distance, or farther away.
double entry_of(std::span<const std::uint8_t> face, std::span<const Point> corners, double growth) {
  const auto place = [](const Point& p) { return dvec3(p.x, p.y, p.z); };
  dvec3 middle(0.0);
  for (const Point& p : corners) middle += place(p) / double(corners.size());
  // Six times the volume of the tetrahedron from the eye: as far as the face's plane is, for equal triangles.
  const auto volume = [&](double times) {
    const auto at = [&](std::size_t i) { return middle + times * (place(corners[face[i]]) - middle); };
    return glm::dot(at(0), glm::cross(at(1), at(2)));
  };
  return volume(growth) / (growth * growth * volume(1.0)) - 0x1p-30;
}

/// The front faces of a solid that the near plane cuts, each by itself. `points`: of the corners and the bulges. A side
/// whose bulge is cut hides nothing: what is drawn is open there. What is drawn lies within the solid made `growth`
/// times as large: 1, or in perspective views more.
bool cover_cut(OccluderImage& image, const Prism& solid, const Placement& placement, std::span<const Point> points,
               int winding, double growth) {
  const core::Scratch<ClipBuffers> scratch;
  std::vector<Point>& polygon = scratch->polygon;
  const std::vector<Corner>& corners = scratch->corners;
  bool covers = false;
  const double at_eye = placement.near_at_eye();
  for (std::size_t i = 0; i < solid.faces.size(); ++i) {
    const double entry = growth == 1.0 ? 1.0 : entry_of(solid.faces[i], points, growth);
    polygon.clear();
    for (const std::uint8_t k : solid.faces[i]) {
      polygon.push_back(points[k]);
      if (growth != 1.0) polygon.back().near = std::lerp(at_eye, points[k].near, entry);
    }
    if (2 * i < solid.bulges.size()) {
      const auto in_front = [&](const Point& p) { return placement.in_front(p); };
      const std::span<const Point> bulge = points.subspan(solid.corners.size() + 2 * i, 2);
      if (!std::all_of(bulge.begin(), bulge.end(), in_front) || !std::all_of(polygon.begin(), polygon.end(), in_front))
        continue;
    }
    clip(placement, *scratch);
    if (corners.size() < 3) continue;
    if (winding_of(corners, all_of(corners)) == winding) covers |= cover_polygon(image, corners, winding, image.snap);
  }
  return covers;
}

/// Whether the near plane leaves a solid whole that is made `growth` times as large about the middle of its corners.
bool all_in_front(const Placement& placement, std::span<const dvec3> corners, double growth) {
  dvec3 middle(0.0);
  for (const dvec3& p : corners) middle += p / double(corners.size());
  return std::all_of(corners.begin(), corners.end(),
                     [&](const dvec3& p) { return placement.in_front(placement(middle + growth * (p - middle))); });
}

/// `own`: the solid's corners. `growth`: see cover_cut().
bool add_solid(OccluderImage& image, const Prism& solid, std::span<const dvec3> own, const Placement& placement,
               double growth = 1.0) {
  std::array<Point, 4 * Prism::kMostSides> points;
  const std::size_t count = own.size(), all = count + solid.bulges.size();
  std::size_t in_front = 0;
  unsigned kept = ~0u;
  for (std::size_t i = 0; i < all; ++i) {
    const dvec3& p = i < count ? own[i] : solid.bulges[i - count];
    points[i] = placement(p);
    in_front += placement.in_front(points[i]);
    kept &= placement.kept(p);
  }
  if (!placement.whole(kept)) return false;
  const int winding = placement.handedness() > 0.0 ? -1 : 1;
  if (in_front < all || (growth != 1.0 && !all_in_front(placement, own, growth)))
    return cover_cut(image, solid, placement, std::span(points).first(all), winding, growth);
  std::array<Corner, 2 * Prism::kMostSides> corners;
  for (std::size_t i = 0; i < count; ++i) corners[i] = placement.project(points[i]);
  return cover_whole(image, solid, std::span(corners).first(count), winding);
}

bool add_solid(OccluderImage& image, const Prism& solid, const Affine& eye_from_solid) {
  if (!image.usable) return false;
  const dvec3 magnitudes(solid.bulges.empty() ? 1.0 : Prism::kMostBulge);
  return add_solid(image, solid, solid.corners, Placement(image, eye_from_solid, magnitudes));
}

dvec3 magnitudes_of(std::span<const dvec3> points) {
  dvec3 magnitudes(0.0);
  for (const dvec3& p : points) magnitudes = glm::max(magnitudes, glm::abs(p));
  return magnitudes;
}

/// A polygon of fewer corners has some of them twice: sides without length limit nothing. The diagonals remain.
template <int kCorners>
void append(std::span<const dvec3> corners, const dvec3& magnitudes, PolygonBatch<kCorners>& batch) {
  assert(corners.size() <= kCorners);
  const auto i = std::size_t(batch.count++);
  for (std::size_t k = 0; k < kCorners; ++k) {
    const dvec3& corner = corners[corners.size() * k / kCorners];
    batch.x[k][i] = corner.x, batch.y[k][i] = corner.y, batch.z[k][i] = corner.z;
  }
  for (int axis = 0; axis < 3; ++axis) batch.magnitudes[axis][i] = magnitudes[axis];
}

/// Polygons that wait until there are enough to be rasterised at once.
template <int kCorners>
class PolygonQueue {
 public:
  using Cover = unsigned (*)(const OccluderImage& image, const PolygonBatch<kCorners>& polygons, float* pixels);

  PolygonQueue(OccluderImage& image, Cover kernel) : image_(image), kernel_(kernel) {}

  void add(std::span<const dvec3> corners, const dvec3& magnitudes) {
    append(corners, magnitudes, batch_);
    if (batch_.count == kPolygonsAtOnce) cover();
  }
  /// Whether any of them covers anything.
  bool finish() {
    if (batch_.count > 0) cover();
    return covers_;
  }

 private:
  void cover() {
    covers_ |= kernel_(image_, batch_, image_.reciprocal_depth.data()) != 0;
    batch_.count = 0;
  }

  OccluderImage& image_;
  Cover kernel_;
  PolygonBatch<kCorners> batch_{};
  bool covers_ = false;
};

/// How large a box looks: the solid angle of the faces towards the eye, or their projected area; roughly. 0: not at
/// all.
double apparent_size(const OccluderImage& image, const core::AabbD& box) {
  if (box.empty()) return 0.0;
  for (const core::Plane& plane : image.frustum) {
    double most = plane.offset;
    for (int i = 0; i < 3; ++i) most += std::max(plane.normal[i] * box.min[i], plane.normal[i] * box.max[i]);
    if (most < 0.0) return 0.0;
  }
  const dvec3 size = box.size();
  if (!image.perspective)
    return std::abs(image.forward.x) * size.y * size.z + std::abs(image.forward.y) * size.z * size.x +
           std::abs(image.forward.z) * size.x * size.y;
  const dvec3 to = glm::clamp(image.eye, box.min, box.max) - image.eye;
  const double distance = glm::length(to);
  if (distance == 0.0) return 0.0;  // the eye is in it
  // Only the part of a large face that lies about the nearest point counts.
  const dvec3 near = glm::min(size, dvec3(4.0 * distance));
  return (std::abs(to.x) * near.y * near.z + std::abs(to.y) * near.z * near.x + std::abs(to.z) * near.x * near.y) /
         (distance * distance * distance);
}

/// a + b, and what rounding takes from it. (D. Knuth)
std::pair<double, double> two_sum(double a, double b) {
  const double sum = a + b, of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// A form at the eye, in twice the digits of double: its terms are large and mostly cancel.
EyeForm form_at(const dvec3& eye, const dvec3& normal, double constant) {
  double sum = constant, rest = 0.0, sizes = std::abs(constant);
  for (int i = 0; i < 3; ++i) {
    const double product = normal[i] * eye[i];
    const auto [next, lost] = two_sum(sum, product);
    sum = next;
    rest += lost + std::fma(normal[i], eye[i], -product);
    sizes += std::abs(product);
  }
  const double value = sum + rest;
  return {normal, glm::abs(normal), value, 0x1p-52 * std::abs(value) + 0x1p-98 * sizes};
}

EyeForm sum(double f, const EyeForm& a, double g, const EyeForm& b) {
  const double at_a = f * a.at_eye, at_b = g * b.at_eye;
  return {f * a.normal + g * b.normal, std::abs(f) * a.sizes + std::abs(g) * b.sizes, at_a + at_b,
          std::abs(f) * a.lost + std::abs(g) * b.lost + 0x1p-50 * (std::abs(at_a) + std::abs(at_b))};
}

Affine from(const dvec3& eye, const Affine& world_from_own) {
  return {world_from_own.linear, world_from_own.origin - eye};
}

struct MeshVertex {
  Point point;
  Corner corner;  // if the point lies in front
  unsigned kept;
};

struct MeshBuffers {
  std::vector<MeshVertex> vertices;
  ClipBuffers clipped;
  std::size_t memory_bytes() const { return core::bytes_of(vertices, clipped); }
};

struct SizedBox {
  double size;
  std::size_t index;
};

struct LargestBuffers {
  std::vector<SizedBox> candidates;
  std::size_t memory_bytes() const { return core::bytes_of(candidates); }
};

struct RowBuffers {
  std::vector<const float*> rows;
  std::size_t memory_bytes() const { return core::bytes_of(rows); }
};

}  // namespace

void OccluderRaster::begin(const core::View& view, int width, int height, float snap) {
  assert(width > 0 && width <= kMostPixels && height > 0 && height <= kMostPixels);
  OccluderImage& image = image_;
  image.width = width, image.height = height;
  image.snap = double(snap);
  image.stride = (width + kLanes - 1) / kLanes * kLanes;
  image.perspective = !view.orthographic();
  image.reciprocal_depth.assign(std::size_t(image.stride) * std::size_t(height),
                                image.perspective ? 0.0f : -std::numeric_limits<float>::infinity());
  image.eye = view.eye();
  const core::dmat4 clip = glm::transpose(view.clip_from_world()), eye = glm::transpose(view.eye_from_world());
  const auto of_row = [&](const dvec4& row) { return form_at(image.eye, dvec3(row), row.w); };
  const EyeForm w = of_row(clip[3]);
  image.z = of_row(-eye[2]);
  image.forward = image.z.normal;
  // w = scale z, or w = scale.
  const double scale =
      image.perspective ? glm::dot(w.normal, image.forward) / glm::dot(image.forward, image.forward) : clip[3].w;
  image.usable = scale > 0.0 && std::isfinite(scale);
  if (image.perspective)
    for (int i = 0; i < 4; ++i)
      image.usable = image.usable && std::abs(clip[3][i] + scale * eye[2][i]) <= 0x1p-51 * std::abs(clip[3][i]);
  const auto place = [&](int axis, int size) {
    return sum(0.5 * size / scale, of_row(clip[axis]), (0.5 * size - 0.5) / scale, w);  // pixel centres at integers
  };
  image.x = place(0, width);
  image.y = place(1, height);
  const double near = core::near_depth(view.clip_depth());
  const double sign = core::far_depth(view.clip_depth()) > near ? 1.0 : -1.0;
  image.near = sum(-sign * near, w, sign, of_row(clip[2]));
  image.frustum = core::frustum_planes(view.clip_from_world(), view.clip_depth());
  image.sections.clear();
  for (const core::Plane& plane : view.sections)
    if (plane.normal != dvec3(0.0)) image.sections.push_back(form_at(image.eye, plane.normal, plane.offset));
  assert(image.sections.size() <= core::kMaxSectionPlanes);
  image.section_mode = view.section_mode;
}

bool OccluderRaster::add_box(const core::AabbD& box) {
  if (box.empty()) return false;
  const dvec3 low = box.min - image_.eye, high = box.max - image_.eye, half = 0.5 * (high - low);
  return add_solid(image_, cube(), {{{half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z}}, 0.5 * (low + high)});
}

bool OccluderRaster::add_cube(const Affine& world_from_cube) {
  return add_solid(image_, cube(), from(image_.eye, world_from_cube));
}

bool OccluderRaster::add_cylinder(const Affine& world_from_cylinder, int sides) {
  assert(sides >= 3 && sides <= Prism::kMostSides);
  return add_solid(image_, prism(sides), from(image_.eye, world_from_cylinder));
}

bool OccluderRaster::add_within(std::span<const WholeSolid> solids, std::span<const OccluderPolygon> polygons) {
  if (!image_.usable) return false;
  bool covers = false;
  PolygonQueue<4> quads(image_, occlusion_kernels().cover_quads);
  PolygonQueue<8> octagons(image_, occlusion_kernels().cover_octagons);
  for (const WholeSolid& solid : solids) {
    const std::span<const OccluderPolygon> own = polygons.first(solid.polygons);
    polygons = polygons.subspan(solid.polygons);
    const std::array<dvec3, 2> ends{solid.box.min, solid.box.max};
    const dvec3 magnitudes = magnitudes_of(ends);
    const Placement placement(image_, magnitudes);
    const bool whole = placement.leaves_whole(solid.box.min, solid.box.max);
    for (const OccluderPolygon& polygon : own) {
      if (!whole && !(polygon.hexahedron && polygon.growth > 0.0 && image_.perspective)) continue;
      if (polygon.hexahedron)
        covers |= add_solid(image_, cube(), polygon.corners, placement, whole ? 1.0 : polygon.growth);
      else if (polygon.count == 4)
        quads.add(polygon.points(), magnitudes);
      else
        octagons.add(polygon.points(), magnitudes);
    }
  }
  covers |= quads.finish();
  covers |= octagons.finish();
  return covers;
}

void OccluderRaster::find_seen(std::span<const OccluderPolygon> quads, const DepthPyramid& pyramid, double error,
                               std::vector<std::uint8_t>& seen) const {
  assert(pyramid.width() == image_.width && pyramid.height() == image_.height);
  seen.assign(quads.size(), 1);
  if (!image_.usable) return;
  PolygonBatch<4> batch{};
  for (std::size_t first = 0; first < quads.size(); first += kPolygonsAtOnce) {
    batch.count = 0;
    for (const OccluderPolygon& quad :
         quads.subspan(first, std::min<std::size_t>(kPolygonsAtOnce, quads.size() - first)))
      append(quad.points(), magnitudes_of(quad.points()), batch);
    const unsigned bits =
        occlusion_kernels().seen_quads(image_, batch, pyramid.blocks(), {OcclusionTest::kDistanceMargin, float(error)});
    for (int i = 0; i < batch.count; ++i) seen[first + std::size_t(i)] = bits >> i & 1u;
  }
}

void OccluderRaster::add_mesh(std::span<const core::vec3> positions, std::span<const std::uint32_t> indices,
                              const Affine& world_from_mesh) {
  assert(indices.size() % 3 == 0);
  if (!image_.usable) return;
  const core::Scratch<MeshBuffers> scratch;
  auto& [vertices, clipped] = *scratch;
  dvec3 magnitudes(0.0);
  for (const core::vec3& p : positions) magnitudes = glm::max(magnitudes, glm::abs(dvec3(p)));
  const Placement placement(image_, from(image_.eye, world_from_mesh), magnitudes);
  vertices.clear();
  for (const core::vec3& p : positions) {
    const Point point = placement(dvec3(p));
    vertices.push_back(
        {point, placement.in_front(point) ? placement.project(point) : Corner{}, placement.kept(dvec3(p))});
  }
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const MeshVertex &a = vertices[indices[i]], &b = vertices[indices[i + 1]], &c = vertices[indices[i + 2]];
    if (!placement.whole(a.kept & b.kept & c.kept)) continue;
    const int in_front = placement.in_front(a.point) + placement.in_front(b.point) + placement.in_front(c.point);
    const Corner corners[] = {a.corner, b.corner, c.corner};
    std::span<const Corner> triangle = corners;
    if (in_front < 3) {
      clipped.polygon = {a.point, b.point, c.point};
      clip(placement, clipped);
      if (clipped.corners.size() < 3) continue;
      triangle = clipped.corners;
    }
    if (const int winding = winding_of(triangle, all_of(triangle)); winding != 0)
      cover_polygon(image_, triangle, winding, 0.0);
  }
}

std::size_t OccluderRaster::add_largest(std::span<const core::AabbD> solids, std::size_t count) {
  const core::Scratch<LargestBuffers> scratch;
  std::vector<SizedBox>& candidates = scratch->candidates;
  candidates.clear();
  for (std::size_t i = 0; i < solids.size(); ++i)
    if (const double size = apparent_size(image_, solids[i]); size > 0.0) candidates.push_back({size, i});
  count = std::min(count, candidates.size());
  std::nth_element(candidates.begin(), candidates.begin() + std::ptrdiff_t(count), candidates.end(),
                   [](const SizedBox& a, const SizedBox& b) { return a.size > b.size; });
  std::size_t added = 0;
  for (std::size_t i = 0; i < count; ++i) added += add_box(solids[candidates[i].index]);
  return added;
}

void OccluderRaster::distances(std::span<float> out, std::span<const OccluderRaster* const> others) const {
  distances_of_rows(0, image_.height, out, others);
}

void OccluderRaster::distances_of_rows(int first_row, int end_row, std::span<float> out,
                                       std::span<const OccluderRaster* const> others) const {
  assert(0 <= first_row && end_row <= image_.height);
  assert(out.size() == std::size_t(image_.width) * std::size_t(image_.height));
  const core::Scratch<RowBuffers> scratch;
  std::vector<const float*>& rows = scratch->rows;
  for (int y = first_row; y < end_row; ++y) {
    const std::size_t first = std::size_t(y) * std::size_t(image_.stride);
    rows.assign(1, image_.reciprocal_depth.data() + first);
    for (const OccluderRaster* other : others) {
      assert(other->image_.width == image_.width && other->image_.height == image_.height);
      rows.push_back(other->image_.reciprocal_depth.data() + first);
    }
    occlusion_kernels().distances(rows.data(), int(rows.size()), image_.perspective, image_.width,
                                  out.data() + std::size_t(y) * std::size_t(image_.width));
  }
}

void OccluderRaster::build(DepthPyramid& pyramid) const {
  distances(pyramid.begin(image_.width, image_.height));
  pyramid.finish();
}

}  // namespace sightline::culling
