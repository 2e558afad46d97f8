#include "sightline/importers/rvm/internal/rvm_chunks.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sightline/importers/internal/triangulate.h"

namespace sightline::importers::rvm {
namespace {

constexpr std::uint64_t kVertexBytes = 24;

void note_number(Item& item, float value) {
  item.finite = item.finite && std::isfinite(value);
}

void read_matrix(ByteCursor& cursor, Item& item) {
  for (float& value : item.matrix) value = cursor.f32("matrix");
}

using StoredBox = std::array<float, 6>;
StoredBox read_box(ByteCursor& cursor) {
  StoredBox box{};
  for (float& value : box) value = cursor.f32("bounding box");
  return box;
}

bool is_finite(const core::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

core::vec3 read_vector(ByteCursor& cursor, const char* what) {
  core::vec3 v(0.0f);
  for (int i = 0; i < 3; ++i) v[i] = cursor.f32(what);
  return v;
}

/// Box and largest coordinate of a facet group's vertices, without polygons that are dropped.
struct FacetScan {
  core::AabbD box;
  double largest = 0.0;
};

/// A polygon with a vertex that is not finite is dropped, a normal that is not finite left out: read_facets() does so.
FacetScan scan_facets(ByteCursor& cursor, Item& item) {
  FacetScan scan;
  item.facets = cursor.position();
  item.facet_polygons = cursor.count(4, "polygon count");
  for (std::uint64_t p = 0; p < item.facet_polygons && cursor.ok(); ++p) {
    const std::uint32_t contours = cursor.count(4, "contour count");
    item.facet_contours += contours;
    core::AabbD box;
    bool finite = true;
    for (std::uint32_t c = 0; c < contours && cursor.ok(); ++c) {
      const std::uint32_t vertices = cursor.count(kVertexBytes, "vertex count");
      item.facet_vertices += vertices;
      for (std::uint32_t v = 0; v < vertices; ++v) {
        const core::vec3 position = read_vector(cursor, "vertex");
        finite = finite && is_finite(position);
        if (!is_finite(read_vector(cursor, "normal"))) ++item.bad_normals;
        box.grow(core::dvec3(position));
      }
    }
    if (!finite) ++item.bad_polygons;
    if (!finite || box.empty()) continue;
    scan.box.grow(box);
    for (int i = 0; i < 3; ++i) scan.largest = std::max({scan.largest, std::abs(box.min[i]), std::abs(box.max[i])});
  }
  if (item.bad_polygons > 0 && item.bad_polygons == item.facet_polygons) item.finite = false;
  return scan;
}

/// Largest difference between a stored box and the item's own, relative to the latter's size. Files store boxes that do
/// not fit exactly, but a box read one word off is wrong by much more.
double box_misfit(const StoredBox& stored, const core::AabbD& own) {
  if (own.empty()) return 0.0;
  const core::dvec3 size = own.size();
  const double scale = std::max({size.x, size.y, size.z, 1e-6});
  double misfit = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    misfit = std::max(misfit, std::abs(double(stored[i]) - own.min[int(i)]) / scale);
    misfit = std::max(misfit, std::abs(double(stored[i + 3]) - own.max[int(i)]) / scale);
  }
  return std::isfinite(misfit) ? misfit : std::numeric_limits<double>::infinity();
}

std::uint32_t transparency_of(std::uint32_t word) {
  return std::min(word >> 24, kMaxTransparency);
}

/// The extra word holds the transparency in its first byte and nothing else.
bool plausible_extra(std::uint32_t word) {
  return (word & 0x00ffffffu) == 0 && (word >> 24) <= kMaxTransparency;
}

/// One reading of the words between kind and parameters of an OBST or INSU.
struct Layout {
  std::array<float, 12> matrix{};
  std::uint32_t extra = 0;
  double misfit = 0.0;
};

Layout read_layout(std::span<const std::byte> file, std::uint64_t at, std::uint64_t limit, bool extra_first,
                   const core::AabbD& own) {
  ByteCursor cursor(file, at, limit);
  Layout layout;
  Item item;
  if (extra_first) layout.extra = cursor.u32("extra word");
  read_matrix(cursor, item);
  const StoredBox box = read_box(cursor);
  if (!extra_first) layout.extra = cursor.u32("extra word");
  layout.matrix = item.matrix;
  layout.misfit = box_misfit(box, own);
  for (const float value : layout.matrix)
    if (!std::isfinite(value)) layout.misfit = std::numeric_limits<double>::infinity();
  if (!plausible_extra(layout.extra)) layout.misfit += 1.0;
  return layout;
}

/// Public readers differ on where the extra word is. Both layouts have the same length and put the parameters in the
/// same place, so the stored box decides: the box that fits the parameters was read from the right place.
void choose_layout(std::span<const std::byte> file, std::uint64_t at, std::uint64_t limit, const core::AabbD& own,
                   Item& item) {
  constexpr double kFits = 0.25;
  const Layout last = read_layout(file, at, limit, false, own), first = read_layout(file, at, limit, true, own);
  const Layout& chosen = first.misfit < last.misfit ? first : last;
  item.ambiguous = !(chosen.misfit <= kFits);
  item.matrix = item.ambiguous ? last.matrix : chosen.matrix;
  item.transparency = transparency_of(item.ambiguous ? last.extra : chosen.extra);
}

double largest_scale(const std::array<float, 12>& m) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 9; ++i) sum += std::abs(double(m[i]));
  return sum;
}

}  // namespace

bool ByteCursor::require(std::uint64_t bytes, const char* what) {
  if (!ok()) return false;
  if (bytes <= remaining()) return true;
  refuse(position_, fmt::format("expected {} ({} bytes), found {} bytes up to the chunk's or file's end", what, bytes,
                                remaining()));
  return false;
}

std::uint32_t ByteCursor::count(std::uint64_t bytes_each, const char* what) {
  const std::uint64_t at = position_;
  const std::uint32_t n = u32(what);
  if (!ok()) return 0;
  if (n <= remaining() / bytes_each) return n;
  refuse(at, fmt::format("expected a {} of at most {} in the {} bytes left, found {}", what, remaining() / bytes_each,
                         remaining(), n));
  return 0;
}

std::string_view ByteCursor::string(const char* what) {
  const std::uint64_t bytes = std::uint64_t(count(4, what)) * 4;
  if (!ok()) return {};
  const std::string_view text(reinterpret_cast<const char*>(file_.data() + position_), bytes);
  position_ += bytes;
  return text.substr(0, text.find('\0'));
}

void ByteCursor::refuse(std::uint64_t offset, std::string message) {
  if (!ok()) return;
  error_offset_ = offset;
  error_ = std::move(message);
}

std::optional<ChunkHeader> read_header(std::span<const std::byte> file, std::uint64_t offset) {
  if (offset > file.size() || file.size() - offset < kHeaderBytes) return {};
  ByteCursor cursor(file, offset, file.size());
  ChunkHeader header;
  header.offset = offset;
  for (char& c : header.tag) {
    const std::uint32_t word = cursor.u32("tag");
    if (word < 0x20 || word > 0x7e) return {};
    c = char(word);
  }
  header.next = cursor.u32("next chunk");
  return header;
}

bool is_known_tag(std::string_view tag) {
  constexpr std::array<std::string_view, 9> kTags = {"HEAD", "MODL", "CNTB", "CNTE", "PRIM",
                                                     "OBST", "INSU", "COLR", "END:"};
  return std::find(kTags.begin(), kTags.end(), tag) != kTags.end();
}

Head read_head(ByteCursor& cursor) {
  Head head;
  const std::uint32_t version = cursor.u32("version");
  head.info = cursor.string("info string");
  head.note = cursor.string("note string");
  head.date = cursor.string("date string");
  head.user = cursor.string("user string");
  if (version >= 2) head.encoding = cursor.string("encoding string");
  return head;
}

Model read_model(ByteCursor& cursor) {
  Model model;
  cursor.u32("version");
  model.project = cursor.string("project string");
  model.name = cursor.string("model name");
  return model;
}

Group read_group(ByteCursor& cursor) {
  Group group;
  const std::uint64_t at = cursor.position();
  const std::uint32_t version = cursor.u32("version");
  if (version < 1 || version > 4) cursor.refuse(at, fmt::format("expected a group version 1 to 4, found {}", version));
  group.name = cursor.string("group name");
  for (float& value : group.position) value = cursor.f32("reference point");
  group.colour = cursor.u32("colour index");
  if (version >= 3) group.transparency = transparency_of(cursor.u32("transparency"));
  if (version == 4) cursor.skip(24, "rest of a version 4 group");
  return group;
}

Colour read_colour(ByteCursor& cursor) {
  Colour colour;
  cursor.u32("colour kind");
  colour.index = cursor.u32("colour index");
  const std::uint32_t rgb = cursor.u32("red, green, blue");
  colour.rgb = {std::uint8_t(rgb >> 24), std::uint8_t(rgb >> 16), std::uint8_t(rgb >> 8)};
  return colour;
}

Item read_item(ByteCursor& cursor, std::span<const std::byte> file, bool extra_word) {
  Item item;
  cursor.u32("version");
  const std::uint64_t kind_at = cursor.position();
  const std::uint32_t kind = cursor.u32("primitive kind");
  if (cursor.ok() && (kind < 1 || kind > kFacetGroupKind))
    cursor.refuse(kind_at, fmt::format("expected a primitive kind 1 to {}, found {}", kFacetGroupKind, kind));
  if (!cursor.ok()) return item;
  static_assert(int(core::Kind::kPyramid) == 0 && int(core::Kind::kFacetGroup) == 10, "RVM numbers kinds from 1 to 11");
  item.kind = core::Kind(kind - 1);
  const std::uint64_t placement_at = cursor.position();
  read_matrix(cursor, item);
  read_box(cursor);
  if (extra_word) cursor.u32("extra word");
  double largest = 0.0;
  core::AabbD own;
  if (item.kind == core::Kind::kFacetGroup) {
    const FacetScan scan = scan_facets(cursor, item);
    own = scan.box, largest = scan.largest;
  } else {
    const std::size_t count = std::size_t(core::parameter_count(item.kind));
    for (std::size_t i = 0; i < count; ++i) {
      item.parameters[i] = cursor.f32("parameter");
      note_number(item, item.parameters[i]);
      largest += std::abs(double(item.parameters[i]));
    }
    if (extra_word && cursor.ok() && item.finite)
      own = core::bounds(core::make_primitive(item.kind, {item.parameters.data(), count}), {});
  }
  if (!cursor.ok()) return item;
  if (extra_word) choose_layout(file, placement_at, cursor.position(), own, item);
  for (const float value : item.matrix) note_number(item, value);
  item.reach = largest * largest_scale(item.matrix);
  for (const float entry : item.matrix) item.reach = std::max(item.reach, std::abs(double(entry)));
  return item;
}

core::Mesh read_facets(std::span<const std::byte> file, const Item& item) {
  core::Mesh mesh;
  mesh.positions.reserve(item.facet_vertices);
  mesh.normals.reserve(item.facet_vertices);
  mesh.contour_sizes.reserve(item.facet_contours);
  mesh.polygon_contours.reserve(item.facet_polygons);
  ByteCursor cursor(file, item.facets, file.size());
  const std::uint32_t polygons = cursor.u32("polygon count");
  for (std::uint32_t p = 0; p < polygons; ++p) {
    const auto first = std::uint32_t(mesh.positions.size());
    const std::size_t first_contour = mesh.contour_sizes.size(), first_index = mesh.indices.size();
    mesh.polygon_contours.push_back(cursor.u32("contour count"));
    bool finite = true;
    for (std::uint32_t c = 0; c < mesh.polygon_contours.back(); ++c) {
      mesh.contour_sizes.push_back(cursor.u32("vertex count"));
      for (std::uint32_t v = 0; v < mesh.contour_sizes.back(); ++v) {
        mesh.positions.push_back(read_vector(cursor, "vertex"));
        const core::vec3 normal = read_vector(cursor, "normal");
        mesh.normals.push_back(is_finite(normal) ? normal : core::vec3(0.0f));
        finite = finite && is_finite(mesh.positions.back());
      }
    }
    if (!finite) {
      mesh.positions.resize(first), mesh.normals.resize(first);
      mesh.contour_sizes.resize(first_contour), mesh.polygon_contours.pop_back();
      continue;
    }
    triangulate_polygon(std::span(mesh.positions).subspan(first), std::span(mesh.contour_sizes).subspan(first_contour),
                        first, mesh.indices);
    // Outside is where the stored normals point: files do not always run their outlines counter-clockwise about them.
    for (std::size_t i = first_index; i + 2 < mesh.indices.size(); i += 3) {
      std::uint32_t* t = &mesh.indices[i];
      const std::array<core::vec3, 3> corners = {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
      const core::dvec3 stored =
          core::dvec3(mesh.normals[t[0]]) + core::dvec3(mesh.normals[t[1]]) + core::dvec3(mesh.normals[t[2]]);
      if (glm::dot(newell_normal(corners), stored) < 0.0) std::swap(t[1], t[2]);
    }
  }
  return mesh;
}

}  // namespace sightline::importers::rvm
