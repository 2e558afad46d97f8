#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "sightline/core/internal/srgb.h"
#include "sightline/importers/internal/face_colours.h"
#include "sightline/importers/internal/image_mean.h"
#include "sightline/importers/internal/side_files.h"
#include "sightline/importers/obj/internal/obj_model.h"

namespace sightline::importers::obj {
namespace {

namespace fs = std::filesystem;

/// Makes a mesh of a part with vertices of its own: each pair of position and normal once.
class PartMesh {
 public:
  explicit PartMesh(Model& model)
      : model_(model), file_normals_(model.normals.size()), first_(model.positions.size(), core::kNone) {}

  /// Consumes the part's corners.
  PolygonMesh make(Part& part) {
    PolygonMesh mesh;
    const auto has_normal = [](const Corner& c) { return c.normal != core::kNone; };
    const bool with_normals = std::any_of(part.corners.begin(), part.corners.end(), has_normal);
    if (with_normals) give_normals(part);
    vertices_.clear();
    mesh.corners.reserve(part.corners.size());
    for (const Corner& corner : part.corners) mesh.corners.push_back(vertex_of(corner));
    mesh.positions.reserve(vertices_.size());
    if (with_normals) mesh.normals.reserve(vertices_.size());
    for (const Vertex& vertex : vertices_) {
      mesh.positions.push_back(model_.positions[vertex.corner.position]);
      if (with_normals) mesh.normals.push_back(model_.normals[vertex.corner.normal]);
      first_[vertex.corner.position] = core::kNone;  // for the next part
    }
    mesh.face_sizes = std::move(part.face_sizes);
    part.corners = {};
    model_.normals.resize(file_normals_);
    return mesh;
  }

 private:
  struct Vertex {
    Corner corner;
    std::uint32_t next = core::kNone;  // of the same position
  };

  /// Corners without a normal get that of their face, behind the file's own ones.
  void give_normals(Part& part) {
    for_each_face(part, [&](std::size_t first, std::size_t size) {
      const std::span<Corner> face(part.corners.data() + first, size);
      const auto lacks = [](const Corner& c) { return c.normal == core::kNone; };
      if (std::none_of(face.begin(), face.end(), lacks)) return;
      const auto own = std::uint32_t(model_.normals.size());
      model_.normals.push_back(normal_of_face(face));
      for (Corner& corner : face)
        if (lacks(corner)) corner.normal = own;
    });
  }

  /// Upwards for faces without an area.
  core::vec3 normal_of_face(std::span<const Corner> face) const {
    core::dvec3 sum(0.0);
    const core::dvec3 origin = model_.positions[face[0].position];
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      sum += glm::cross(model_.positions[face[i].position] - origin, model_.positions[face[i + 1].position] - origin);
    const double length = glm::length(sum);
    return length > 0.0 && std::isfinite(length) ? core::vec3(sum / length) : core::vec3(0.0f, 0.0f, 1.0f);
  }

  std::uint32_t vertex_of(const Corner& corner) {
    std::uint32_t& first = first_[corner.position];
    for (std::uint32_t i = first; i != core::kNone; i = vertices_[i].next)
      if (vertices_[i].corner == corner) return i;
    vertices_.push_back({corner, first});
    return first = std::uint32_t(vertices_.size() - 1);
  }

  Model& model_;
  std::size_t file_normals_;
  std::vector<std::uint32_t> first_;  // latest vertex made of each position of the file
  std::vector<Vertex> vertices_;
};

/// Colours of vertices: an item shows one.
class VertexColours {
 public:
  explicit VertexColours(const Model& model) : model_(model) {
    float least = 0.0f, largest = 0.0f;
    for (const core::vec3& c : model.colours)
      for (int i = 0; i < 3; ++i) least = std::min(least, c[i]), largest = std::max(largest, c[i]);  // NaN stays out
    are_colours_ = least >= 0.0f;
    constexpr float kLargestShare = 1.5f;  // rounding may exceed 1
    if (largest <= kLargestShare) scale_ = 255.0f;
  }

  /// The mean of a part's corners; kNoColour when none has one.
  PackedColour of(const Part& part) {
    if (model_.colours.empty() || !are_colours_) return kNoColour;
    ColourSum sum;
    std::array<std::uint32_t, 3> least{255, 255, 255}, most{};
    for (const Corner& corner : part.corners) {
      if (corner.position >= model_.colours.size() || std::isnan(model_.colours[corner.position].x)) continue;
      const auto channels = bytes_of(model_.colours[corner.position]);
      for (std::size_t i = 0; i < 3; ++i)
        least[i] = std::min(least[i], channels[i]), most[i] = std::max(most[i], channels[i]);
      sum.add(pack_colour(channels[0], channels[1], channels[2]));
    }
    // Writers of the colours of some objects give others black, and a material beside.
    if (sum.count > 0 && most == std::array<std::uint32_t, 3>{} && part.place.material != core::kNone) {
      black_.add(part.offset, part.line);
      return kNoColour;
    }
    const bool differ = sum.count > 0 && (most[0] > least[0] + 1 || most[1] > least[1] + 1 || most[2] > least[2] + 1);
    if (differ) averaged_.add(part.offset, part.line);
    return sum.average();
  }

  void tell(ImportJob& job) const {
    if (!are_colours_) job.warn(0, "numbers behind the vertices are no colours, some are below 0: left out");
    averaged_.warn(job, "items whose vertices differ in colour show the mean");
    black_.warn(job, "items with a material whose vertices are all black: the material alone is shown");
  }

 private:
  std::array<std::uint32_t, 3> bytes_of(const core::vec3& colour) const {
    std::array<std::uint32_t, 3> channels{};
    for (int i = 0; i < 3; ++i)
      channels[std::size_t(i)] = std::uint32_t(std::lround(std::clamp(scale_ * colour[i], 0.0f, 255.0f)));
    return channels;
  }

  const Model& model_;
  bool are_colours_ = true;
  float scale_ = 1.0f;
  Noticed averaged_, black_;
};

/// The file's name at the end of what map_Kd says, behind its options.
std::string_view without_options(std::string_view arguments) {
  const auto is_number = [](std::string_view word) {
    TextScanner scanner(std::as_bytes(std::span(word)));
    double ignored = 0.0;
    return scanner.number(ignored) == TextScanner::Found::kNumber;
  };
  while (arguments.starts_with('-')) {
    TextScanner words(std::as_bytes(std::span(arguments)));
    const std::string_view option = words.word();
    const bool vector = option == "-o" || option == "-s" || option == "-t", range = option == "-mm";
    std::string_view rest = words.rest_of_line();
    for (int left = vector ? 3 : range ? 2 : 1; left > 0; --left) {
      TextScanner argument(std::as_bytes(std::span(rest)));
      const std::string_view word = argument.word();
      if (vector && !is_number(word)) break;  // the last two may be missing
      rest = argument.rest_of_line();
    }
    arguments = rest;
  }
  return arguments;
}

/// Makes materials of the scene when items ask for them.
class SceneMaterials {
 public:
  SceneMaterials(ImportJob& job, const Model& model, MaterialLibraries& libraries)
      : job_(job), model_(model), libraries_(libraries) {}

  /// `name` kNone: no material, so the tint alone counts.
  core::MaterialId of(std::uint32_t name, PackedColour tint) {
    const LibraryMaterial* source = name == core::kNone ? nullptr : library_material(name);
    const auto [at, added] = made_.try_emplace({source ? name : core::kNone, tint});
    if (!added) return at->second;
    if (source) used_ = &model_.names[name];
    at->second = source ? job_.scene().add_material(look_of(*source, tint)) : add_colour_material(job_.scene(), tint);
    return at->second;
  }

  void tell() const {
    unknown_.warn(job_, "materials are in no library");
    invisible_.warn(job_, "materials are transparent throughout (d 0 or Tr 1); shown opaque");
    unread_.warn(job_, "textures that could not be read count as none");
    black_.warn(job_, "materials are black (Kd 0 0 0) below a texture, which is shown alone");
  }

 private:
  const LibraryMaterial* library_material(std::uint32_t number) {
    const Name& name = model_.names[number];
    const LibraryMaterial* const found = libraries_.find(name.text);
    if (!found && looked_for_.insert(number).second) unknown_.add(name.offset, name.line, name.text);
    return found;
  }

  core::Material look_of(const LibraryMaterial& source, PackedColour tint) {
    core::Material material;
    material.name = source.name;
    material.colour = diffuse_of(source);
    const double opacity = source.dissolve ? *source.dissolve : 1.0 - source.transparency.value_or(0.0);
    if (opacity > 0.0)
      material.alpha = float(std::min(opacity, 1.0));
    else  // writers differ on which of 0 and 1 is opaque, and nobody writes faces to hide them
      invisible_.add(used_->offset, used_->line, source.name);
    if (tint != kNoColour && tint != pack_colour(255, 255, 255)) {
      for (int i = 0; i < 3; ++i) material.colour[i] *= float(tint >> (24 - 8 * i) & 255) / 255.0f;
      material.name += ' ' + colour_name(tint);
    }
    return material;
  }

  /// Kd times the mean of the texture, as far as there are any.
  core::vec3 diffuse_of(const LibraryMaterial& source) {
    const auto mean = source.texture.empty() ? std::nullopt : mean_of(source);
    core::vec3 diffuse = source.diffuse.value_or(core::vec3(mean ? 1.0f : kDefaultDiffuse));
    if (!source.texture.empty() && diffuse == core::vec3(0.0f)) {
      black_.add(used_->offset, used_->line, source.name);
      diffuse = core::vec3(mean ? 1.0f : kDefaultDiffuse);
    }
    if (!mean) return diffuse;
    for (int i = 0; i < 3; ++i)
      diffuse[i] = float(core::srgb_from_linear((*mean)[i] * core::linear_from_srgb(double(diffuse[i]))));
    return diffuse;
  }

  /// In linear light. Each image is looked at once.
  std::optional<core::dvec3> mean_of(const LibraryMaterial& source) {
    const auto [at, added] = means_.try_emplace(source.texture);
    if (!added) return at->second;
    const auto mean = image_of(source.texture);
    if (mean) return at->second = *mean;
    unread_.add(used_->offset, used_->line);
    if (unread_.count == 1) unread_.first = utf8_by_guess(mean.error().message);
    return {};
  }

  core::Expected<core::dvec3> image_of([[maybe_unused]] const std::string& arguments) {
#ifdef SIGHTLINE_HAVE_GLTF
    const auto path = path_of(arguments);
    if (!path) return tl::unexpected(path.error());
    const auto [at, added] = images_.try_emplace(*path, core::fail("not read"));
    if (!added) return at->second;
    const auto bytes = read_side_file(libraries_.model(), path->string());
    if (!bytes) return at->second = tl::unexpected(bytes.error());
    std::uint64_t left = kPixelsPerByte * bytes->size();
    at->second = image_mean(*bytes, false, left).map([](const ImageMean& image) { return image.colour; });
    if (!at->second) at->second.error().message.insert(0, path->filename().string() + ": ");
    return at->second;
#else
    return core::fail("this build reads no images");
#endif
  }

  /// The name alone, or with what looks like options.
  core::Expected<fs::path> path_of(const std::string& arguments) {
    if (auto whole = find_named_file(libraries_.model(), arguments)) return whole;
    const std::string_view name = without_options(arguments);
    auto path = find_named_file(libraries_.model(), name);
    if (path) return path;
    auto similar = find_similar_file(libraries_.model(), name);
    if (!similar) return path;
    job_.warn(used_->offset, fmt::format("line {}: texture {} not found; {} is read", used_->line, excerpt(name),
                                         excerpt(similar->filename().string())));
    return similar;
  }

  ImportJob& job_;
  const Model& model_;
  MaterialLibraries& libraries_;
  std::map<std::pair<std::uint32_t, PackedColour>, core::MaterialId> made_;
  std::set<std::uint32_t> looked_for_;                       // names of no library
  std::map<std::string, std::optional<core::dvec3>> means_;  // by arguments of map_Kd
  std::map<fs::path, core::Expected<core::dvec3>> images_;
  const Name* used_ = nullptr;  // where the latest material is first named
  Noticed unread_, black_, unknown_, invisible_;
};

/// Nodes of objects, and below them those of their groups.
class Nodes {
 public:
  Nodes(ImportJob& job, const Model& model) : job_(job), model_(model) {}

  core::NodeId of(const Place& place) {
    const core::NodeId object = child(job_.file_node(), {place.object, core::kNone}, place.object);
    // A group that only repeats its object's name says nothing more.
    return place.group == place.object ? object : child(object, {place.object, place.group}, place.group);
  }
  std::string_view name(const Place& place) const {
    const std::uint32_t number = place.group != core::kNone ? place.group : place.object;
    return number == core::kNone ? std::string_view() : model_.names[number].text;
  }

 private:
  using Key = std::pair<std::uint32_t, std::uint32_t>;  // object and group

  core::NodeId child(core::NodeId parent, const Key& key, std::uint32_t name) {
    if (name == core::kNone) return parent;
    const auto [at, added] = made_.try_emplace(key);
    if (added) at->second = job_.scene().add_node(parent, model_.names[name].text);
    return at->second;
  }

  ImportJob& job_;
  const Model& model_;
  std::map<Key, core::NodeId> made_;
};

}  // namespace

core::Expected<void> add_to_scene(ImportJob& job, Model& model, MaterialLibraries& libraries) {
  Nodes nodes(job, model);
  SceneMaterials materials(job, model, libraries);
  VertexColours colours(model);
  PartMesh part_mesh(model);
  std::size_t done = 0;
  for (Part& part : model.parts) {
    if (auto asked = job.progress(0.9 + 0.1 * double(done++) / double(model.parts.size())); !asked) return asked;
    const core::MaterialId material = materials.of(part.place.material, colours.of(part));
    job.add_mesh(nodes.of(part.place), part_mesh.make(part), nodes.name(part.place), {}, material, part.offset);
  }
  colours.tell(job);
  materials.tell();
  return {};
}

}  // namespace sightline::importers::obj
