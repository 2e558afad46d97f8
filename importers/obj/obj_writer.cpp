#include "sightline/importers/obj/obj_writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/core/internal/platform/files.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/internal/tessellated.h"

namespace sightline::importers {
namespace {

using core::dmat3;
using core::dvec3;
using core::MaterialId;
using core::NodeId;

constexpr std::uint64_t kMostVertices = 0x7fffffffu;  // what readers of OBJ count with
constexpr std::size_t kFlushBytes = std::size_t{1} << 20;

/// A name on one line. Readers split material names at spaces, but not object names.
std::string on_one_line(std::string_view name, bool spaces) {
  std::string line(name);
  for (char& c : line)
    if (static_cast<unsigned char>(c) < ' ' || c == 127 || (c == ' ' && !spaces)) c = '_';
  return line;
}

/// Buffers text for a file.
class TextSink {
 public:
  explicit TextSink(ByteSink& sink) : sink_(sink) {}

  TextSink& operator<<(std::string_view text) {
    buffer_.append(text);
    if (buffer_.size() >= kFlushBytes) flush();
    return *this;
  }
  TextSink& operator<<(char c) { return *this << std::string_view(&c, 1); }
  template <class Number>
  requires std::is_arithmetic_v<Number> TextSink& operator<<(Number number) {
    char digits[32];
    const auto end = std::to_chars(std::begin(digits), std::end(digits), number).ptr;
    return *this << std::string_view(digits, std::size_t(end - digits));
  }
  /// Components after spaces; -0 as 0.
  template <class Vector>
  TextSink& put(const Vector& v) {
    return *this << ' ' << v.x + 0 << ' ' << v.y + 0 << ' ' << v.z + 0 << '\n';
  }
  bool flush() {
    ok_ = ok_ && sink_.write(std::as_bytes(std::span(buffer_)));
    written_ += buffer_.size();
    buffer_.clear();
    return ok_;
  }
  bool ok() const { return ok_; }
  std::uint64_t written() const { return written_; }

 private:
  ByteSink& sink_;
  std::string buffer_;
  std::uint64_t written_ = 0;
  bool ok_ = true;
};

/// Names and text of the materials in use.
class MaterialLibrary {
 public:
  explicit MaterialLibrary(const core::Scene& scene) : scene_(scene) {}

  /// The material's name in the file. Null for an item without material, as long as no other item had one.
  const std::string* name_of(std::uint32_t material) {
    if (material == core::kNone && names_.empty()) return nullptr;
    const auto [at, added] = names_.try_emplace(material);
    if (added)
      at->second = add(material == core::kNone ? core::Material{.name = "default"}
                                               : scene_.material(scene_.material_at(material)));
    return &at->second;
  }
  const std::string& text() const { return text_; }

 private:
  std::string add(const core::Material& look) {
    const std::string wanted = on_one_line(look.name.empty() ? "material" : look.name, false);
    std::string name = wanted;
    for (std::size_t& k = last_suffix_[wanted]; !taken_.insert(name).second;) name = fmt::format("{}_{}", wanted, ++k);
    text_ +=
        fmt::format("newmtl {}\nKd {} {} {}\nd {}\n", name, look.colour.x, look.colour.y, look.colour.z, look.alpha);
    return name;
  }

  const core::Scene& scene_;
  std::map<std::uint32_t, std::string> names_;
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, std::size_t> last_suffix_;
  std::string text_;
};

/// The "/"-joined names down to the node being visited. Nodes must come parents first.
class NodePath {
 public:
  NodePath(const core::Scene& scene, NodeId top) : scene_(scene), top_(top) {}

  const std::string& enter(NodeId node) {
    if (node == top_) return path_;
    const NodeId parent = scene_.parent(node);
    while (!above_.empty() && above_.back().node != parent) above_.pop_back();
    if (above_.empty()) above_.push_back({parent, 0, 0});  // the top
    path_.resize(above_.back().length);
    const std::size_t position = above_.back().children++;
    if (!path_.empty()) path_ += '/';
    const std::string_view name = scene_.name(node);
    path_ += name.empty() ? fmt::format("#{}", position) : on_one_line(name, true);
    above_.push_back({node, path_.size(), 0});
    return path_;
  }

 private:
  struct Above {
    NodeId node;
    std::size_t length, children;  // of its joined names; so far
  };
  const core::Scene& scene_;
  NodeId top_;
  std::vector<Above> above_;
  std::string path_;
};

class ObjWriter {
 public:
  ObjWriter(const core::Scene& scene, const ObjWriteOptions& options, ByteSink& sink, std::string library)
      : scene_(scene), options_(options), out_(sink), library_(std::move(library)), materials_(scene) {}

  core::Expected<ObjWriteReport> run(NodeId top) {
    std::uint64_t items = 0;
    scene_.for_each_node(top, [&](NodeId node, const core::Affine&, bool, std::uint32_t, MaterialId) {
      for (core::ItemId item = scene_.first_item(node); item != core::kNoItem; item = scene_.next_item(item)) ++items;
    });
    progress_step_ = 1.0 / double(std::max<std::uint64_t>(1, items));
    out_ << "# metres, z up\n";  // readers of OBJ have no other way to know
    NodePath path(scene_, top);
    scene_.for_each_node(
        top, [&](NodeId node, const core::Affine& world, bool visible, std::uint32_t layers, MaterialId material) {
          const std::string& name = path.enter(node);
          if (error_.message.empty()) write_node(node, name, world, visible, layers, material);
        });
    if (error_.message.empty() && !out_.flush()) error_.message = "writing failed (is the disk full?)";
    if (!error_.message.empty()) return tl::unexpected(error_);
    report_.bytes = out_.written() + materials_.text().size();
    return report_;
  }
  const std::string& materials() const { return materials_.text(); }

 private:
  void write_node(NodeId node, const std::string& name, const core::Affine& world, bool visible, std::uint32_t layers,
                  MaterialId material) {
    bool named = false;
    for (core::ItemId item = scene_.first_item(node); item != core::kNoItem && error_.message.empty();
         item = scene_.next_item(item)) {
      if (!report_progress()) return;
      const core::Scene::ItemState state = scene_.state(item, world, visible, layers, material);
      if ((state.layers & core::kDefaultLayerMask) == 0) {
        ++report_.left_out;
        continue;
      }
      if (!named) out_ << "o " << (name.empty() ? on_one_line(scene_.name(node), true) : name) << '\n';
      named = true;
      write_item(item, state);
    }
  }

  bool report_progress() {
    if (options_.progress && !options_.progress(progress_step_ * double(done_++))) error_.message = kCancelled;
    if (!out_.ok()) error_.message = "writing failed (is the disk full?)";
    return error_.message.empty();
  }

  void write_item(core::ItemId item, const core::Scene::ItemState& state) {
    const core::Kind kind = scene_.kind(item);
    bool written = false;
    if (kind == core::Kind::kLine) {
      written = write_line(std::get<core::Line>(scene_.primitive(item)), state);
    } else if (int(kind) < core::kPrimitiveKindCount) {
      const double scale = largest_scale(state.world_from_item.linear);
      const core::Mesh mesh = gpuprims::tessellate(
          scene_.primitive(item), {.chord_tolerance = options_.tolerance / scale, .max_segments = kObjMostSegments});
      report_.largest_chord_error = std::max(report_.largest_chord_error, scale * chord_error(mesh));
      written = write_triangles(mesh, state);
    } else {
      written = write_triangles(scene_.mesh(scene_.mesh_of(item)), state);
    }
    ++(written ? report_.items[std::size_t(kind)] : report_.left_out);
  }

  bool write_line(const core::Line& line, const core::Scene::ItemState& state) {
    use_material(state.material);
    for (const float x : {line.from, line.to})
      out_ << 'v', out_.put(core::transform_point(state.world_from_item, dvec3(x, 0, 0)));
    out_ << "l " << report_.vertices + 1 << ' ' << report_.vertices + 2 << '\n';
    count_vertices(2);
    return true;
  }

  bool write_triangles(const core::Mesh& mesh, const core::Scene::ItemState& state) {
    if (mesh.indices.empty()) return false;
    use_material(state.material);
    const core::Affine& world = state.world_from_item;
    for (const core::vec3& p : mesh.positions) out_ << 'v', out_.put(core::transform_point(world, dvec3(p)));
    const dmat3 map_normal = normal_map(world.linear);
    const bool mirrored = glm::determinant(world.linear) < 0.0;
    for (const core::vec3& n : mesh.normals) {
      const dvec3 normal = map_normal * dvec3(n);
      const double length = glm::length(normal);
      out_ << "vn", out_.put(length > 0.0 ? core::vec3(normal / length) : core::vec3(0.0f, 0.0f, 1.0f));
    }
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const auto [b, c] = mirrored ? std::pair(i + 2, i + 1) : std::pair(i + 1, i + 2);
      out_ << 'f';
      for (const std::size_t corner : {i, b, c}) write_corner(mesh.indices[corner], !mesh.normals.empty());
      out_ << '\n';
    }
    report_.triangles += mesh.indices.size() / 3;
    normals_ += mesh.normals.size();
    count_vertices(mesh.positions.size());
    return true;
  }

  void write_corner(std::uint32_t vertex, bool with_normal) {
    out_ << ' ' << report_.vertices + vertex + 1;
    if (with_normal) out_ << "//" << normals_ + vertex + 1;
  }

  void count_vertices(std::size_t added) {
    report_.vertices += added;
    if (report_.vertices > kMostVertices)
      error_.message =
          fmt::format("the model takes more than {} vertices, which readers of OBJ cannot count", kMostVertices);
  }

  void use_material(std::uint32_t material) {
    const std::string* const name = materials_.name_of(material);
    if (!name || name == used_) return;
    if (!used_) out_ << "mtllib " << library_ << '\n';
    out_ << "usemtl " << *name << '\n';
    used_ = name;
  }

  const core::Scene& scene_;
  const ObjWriteOptions& options_;
  TextSink out_;
  std::string library_;  // the MTL file's name
  MaterialLibrary materials_;
  const std::string* used_ = nullptr;  // name of the present material
  ObjWriteReport report_;
  std::uint64_t normals_ = 0, done_ = 0;
  double progress_step_ = 1.0;
  core::Error error_;
};

}  // namespace

core::Expected<ObjWriteReport> write_obj(const core::Scene& scene, NodeId node, const std::filesystem::path& path,
                                         const ObjWriteOptions& options) {
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance))
    return core::fail(fmt::format("expected a tolerance above 0 m, found {}", options.tolerance));
  std::filesystem::path library = path;
  library.replace_filename(core::platform::path_of(
      on_one_line(std::filesystem::path(path.filename()).replace_extension(".mtl").string(), false)));
  if (library == path) return core::fail(fmt::format("{}: expected another extension than .mtl", path.string()));

  auto file = core::AtomicFile::create(path);
  if (!file) return tl::unexpected(file.error());
  FileSink sink(*file);
  ObjWriter writer(scene, options, sink, library.filename().string());
  auto report = writer.run(node);
  if (file->failed()) return tl::unexpected(file->commit().error());
  if (!report) {
    if (report.error().message != kCancelled)
      report.error().message = fmt::format("{}: {}", path.string(), report.error().message);
    return report;
  }
  if (!writer.materials().empty())
    if (auto done = core::write_file(library, {std::as_bytes(std::span(writer.materials()))}); !done)
      return tl::unexpected(done.error());
  if (auto done = file->commit(); !done) return tl::unexpected(done.error());
  return report;
}

}  // namespace sightline::importers
