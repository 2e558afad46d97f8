#include "sightline/importers/internal/face_colours.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "sightline/core/internal/srgb.h"

namespace sightline::importers {
namespace {

std::uint32_t channel(PackedColour colour, int i) {
  return colour >> (24 - 8 * i) & 0xff;
}

/// Numbers colours by first appearance, up to the limit.
class ColourTable {
 public:
  /// kNone when there are too many.
  std::uint32_t number_of(PackedColour colour) {
    if (!distinct.empty() && colour == distinct[last_]) return last_;
    auto at = std::lower_bound(sorted_.begin(), sorted_.end(), colour,
                               [&](std::uint32_t number, PackedColour c) { return distinct[number] < c; });
    if (at == sorted_.end() || distinct[*at] != colour) {
      if (distinct.size() == kMostFaceColours) return core::kNone;
      distinct.push_back(colour);
      at = sorted_.insert(at, std::uint32_t(distinct.size() - 1));
    }
    return last_ = *at;
  }
  std::vector<PackedColour> distinct;

 private:
  std::vector<std::uint32_t> sorted_;  // numbers, by colour
  std::uint32_t last_ = 0;
};

/// Splits a mesh into one mesh per colour, with vertices of its own.
class Splitter {
 public:
  Splitter(const PolygonMesh& from, const std::vector<PackedColour>& colours, ColourTable& table)
      : from_(from), place_(from.positions.size(), core::kNone), parts_(table.distinct.size()) {
    // Counting sort of faces by colour: the count of each colour, where each begins, then each face to its place.
    faces_of_.assign(table.distinct.size() + 1, 0);
    for (const PackedColour colour : colours) ++faces_of_[table.number_of(colour) + 1];
    for (std::size_t i = 1; i < faces_of_.size(); ++i) faces_of_[i] += faces_of_[i - 1];
    faces_.resize(colours.size());
    std::vector<std::size_t> next(faces_of_.begin(), faces_of_.end() - 1);
    std::size_t face = 0;
    for_each_face(from, [&](std::size_t first, std::uint32_t size) {
      faces_[next[table.number_of(colours[face++])]++] = {first, size};
    });
  }

  std::size_t parts() const { return parts_; }

  PolygonMesh part(std::size_t colour) {
    PolygonMesh to;
    used_.clear();
    for (std::size_t f = faces_of_[colour]; f < faces_of_[colour + 1]; ++f) {
      for (std::size_t c = faces_[f].first; c < faces_[f].first + faces_[f].size; ++c)
        to.corners.push_back(place_of(from_.corners[c]));
      end_face(to, faces_[f].size);
    }
    to.positions.reserve(used_.size());
    if (!from_.normals.empty()) to.normals.reserve(used_.size());
    for (const std::uint32_t vertex : used_) {
      to.positions.push_back(from_.positions[vertex]);
      if (!from_.normals.empty()) to.normals.push_back(from_.normals[vertex]);
      place_[vertex] = core::kNone;  // for the next part
    }
    return to;
  }

 private:
  struct Face {
    std::size_t first;
    std::uint32_t size;
  };

  std::uint32_t place_of(std::uint32_t vertex) {
    if (place_[vertex] == core::kNone) {
      place_[vertex] = std::uint32_t(used_.size());
      used_.push_back(vertex);
    }
    return place_[vertex];
  }

  const PolygonMesh& from_;
  std::vector<std::uint32_t> place_, used_;
  std::vector<std::size_t> faces_of_;  // first face of each colour in faces_
  std::vector<Face> faces_;
  std::size_t parts_;
};

}  // namespace

namespace {

PackedColour linear_mean(std::span<const std::uint32_t> corners, const std::vector<PackedColour>& of_vertices) {
  PackedColour first = kNoColour;
  bool same = true;
  double sums[4] = {}, count = 0.0;
  for (const std::uint32_t corner : corners) {
    const PackedColour colour = of_vertices[corner];
    if (colour == kNoColour) continue;
    if (first == kNoColour) first = colour;
    same = same && colour == first;
    for (int i = 0; i < 3; ++i) sums[i] += core::linear_from_srgb(channel(colour, i) / 255.0);
    sums[3] += channel(colour, 3);
    ++count;
  }
  if (same) return first;
  std::uint32_t bytes[4];
  for (int i = 0; i < 3; ++i) bytes[i] = std::uint32_t(std::lround(255.0 * core::srgb_from_linear(sums[i] / count)));
  bytes[3] = std::uint32_t(std::lround(sums[3] / count));
  return pack_colour(bytes[0], bytes[1], bytes[2], bytes[3]);
}

}  // namespace

void ColourSum::add(PackedColour colour) {
  for (int i = 0; i < 4; ++i) channels[i] += channel(colour, i);
  ++count;
}

PackedColour ColourSum::average() const {
  if (count == 0) return kNoColour;
  const auto mean = [&](int i) { return std::uint32_t((channels[i] + count / 2) / count); };
  return pack_colour(mean(0), mean(1), mean(2), channels[3] > 0 ? mean(3) : 255);
}

std::string colour_name(PackedColour colour) {
  return channel(colour, 3) == 255 ? fmt::format("#{:06x}", colour >> 8) : fmt::format("#{:08x}", colour);
}

core::MaterialId add_colour_material(core::Scene& scene, PackedColour colour) {
  if (colour == kNoColour) return {};
  core::Material material;
  for (int i = 0; i < 3; ++i) material.colour[i] = float(channel(colour, i)) / 255.0f;
  material.alpha = float(channel(colour, 3)) / 255.0f;
  material.name = colour_name(colour);
  return scene.add_material(std::move(material));
}

void for_each_colour(ImportJob& job, const PolygonMesh& polygons, const std::vector<PackedColour>& colours,
                     const std::function<void(const PolygonMesh&, PackedColour)>& visit) {
  ColourTable table;
  ColourSum sum;
  bool few = true;
  for (const PackedColour colour : colours) {
    few = few && table.number_of(colour) != core::kNone;
    if (colour != kNoColour) sum.add(colour);
  }
  if (!few) {
    job.warn(0, fmt::format("more than {} colours of faces: their average is shown", kMostFaceColours));
    visit(polygons, sum.average());
    return;
  }
  const auto shown = [&](PackedColour colour) {
    const bool no_alpha = sum.channels[3] == 0 && colour != kNoColour;
    return no_alpha ? colour | 255 : colour;
  };
  if (table.distinct.size() <= 1) {
    visit(polygons, table.distinct.empty() ? kNoColour : shown(table.distinct[0]));
    return;
  }
  Splitter splitter(polygons, colours, table);
  for (std::size_t i = 0; i < splitter.parts(); ++i) visit(splitter.part(i), shown(table.distinct[i]));
}

std::vector<PackedColour> colours_from_vertices(const PolygonMesh& polygons,
                                                const std::vector<PackedColour>& of_vertices) {
  std::vector<PackedColour> colours;
  colours.reserve(polygons.face_count());
  for_each_face(polygons, [&](std::size_t first, std::uint32_t size) {
    colours.push_back(linear_mean(std::span(polygons.corners).subspan(first, size), of_vertices));
  });
  return colours;
}

void add_coloured_meshes(ImportJob& job, core::NodeId node, const PolygonMesh& polygons,
                         const std::vector<PackedColour>& colours, std::string_view name) {
  for_each_colour(job, polygons, colours, [&](const PolygonMesh& part, PackedColour colour) {
    job.add_mesh(node, part, name, {}, add_colour_material(job.scene(), colour));
  });
}

}  // namespace sightline::importers
