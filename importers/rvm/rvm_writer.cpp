#include "sightline/importers/rvm/rvm_writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/triangulate.h"
#include "sightline/importers/rvm/internal/rvm_output.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"

namespace sightline::importers {
namespace {

using core::ItemId;
using core::MaterialId;
using core::NodeId;

bool is_identity(const core::Affine& a) {
  return a.linear == core::dmat3(1.0) && a.origin == core::dvec3(0.0);
}

std::string_view attribute(const core::Scene& scene, NodeId node, std::string_view key) {
  for (const auto& [name, value] : scene.attributes(node))
    if (name == key) return value;
  return {};
}

/// Parses "x y z" as the reader prints it; zeros where the text is not.
std::array<float, 3> parse_position(std::string_view text) {
  std::array<float, 3> position{};
  for (float& value : position) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    if (result.ec != std::errc{}) return {};
    text.remove_prefix(std::size_t(result.ptr - text.data()));
  }
  return position;
}

/// Colour and transparency of a group or item in RVM terms.
struct Look {
  std::uint32_t colour = 1, transparency = 0;
  friend bool operator==(const Look&, const Look&) = default;
};

using Rgb = std::array<std::uint8_t, 3>;

/// Gives every material a colour index. No two colours get the same index.
class Palette {
 public:
  Look look(const core::Scene& scene, MaterialId material) {
    if (!material.valid()) return default_look();
    const auto [at, added] = looks_.try_emplace(material.index);
    if (added) at->second = assign(scene.material(material));
    return at->second;
  }
  const std::map<std::uint32_t, Rgb>& colours() const { return colours_; }

 private:
  static std::uint8_t to_byte(float c) { return std::uint8_t(std::lround(std::clamp(c, 0.0f, 1.0f) * 255.0f)); }

  Look default_look() {
    if (!default_) default_ = Look{place(1, rvm_default_colour(1)), 0};
    return *default_;
  }

  Look assign(const core::Material& material) {
    const Rgb rgb = {to_byte(material.colour.x), to_byte(material.colour.y), to_byte(material.colour.z)};
    const float transparency = 100.0f * (1.0f - std::clamp(material.alpha, 0.0f, 1.0f));
    return {place(material.code, rgb), std::uint32_t(std::lround(transparency))};
  }

  std::uint32_t place(std::uint32_t wanted, const Rgb& rgb) {
    if (const auto at = colours_.find(wanted); at == colours_.end() || at->second == rgb) {
      colours_[wanted] = rgb;
      return wanted;
    }
    if (const auto known = replacements_.find({wanted, rgb}); known != replacements_.end()) return known->second;
    while (colours_.contains(next_free_)) ++next_free_;
    colours_[next_free_] = rgb;
    replacements_[{wanted, rgb}] = next_free_;
    return next_free_;
  }

  std::map<std::uint32_t, Look> looks_;
  std::map<std::uint32_t, Rgb> colours_;
  std::map<std::pair<std::uint32_t, Rgb>, std::uint32_t> replacements_;
  std::uint32_t next_free_ = 256;
  std::optional<Look> default_;
};

/// The items of one node still to be written, and what they inherit.
struct ItemSource {
  ItemId next = core::kNoItem;
  std::uint32_t layers = core::kLayerModel;
  MaterialId material;
  Look look;
};

/// A node on the way from the top to the present node.
struct Frame {
  NodeId node, next_child;
  core::Affine world;
  bool identity = true;
  std::vector<ItemSource>
      sources;                  ///< its own items first, then those of layer nodes (see is_layer_node) reached so far
  std::optional<Look> wrapped;  ///< look of the open unnamed group around items with a material of their own
};

class RvmWriter {
 public:
  RvmWriter(const core::Scene& scene, ByteSink& sink, const std::function<bool(double)>& progress)
      : scene_(scene), out_(sink), progress_(progress) {}

  core::Expected<void> run(NodeId top) {
    top_ = top;
    find_first_items(top);
    write_head(top);
    push_top(top);
    while (!stack_.empty() && error_.message.empty() && out_.ok()) {
      step();
      if (!told()) return core::fail(std::string(kCancelled));
    }
    if (!error_.message.empty()) return tl::unexpected(error_);
    write_colours();
    out_.begin("END:");
    out_.u32(1);
    out_.end();
    out_.pad();
    if (out_.too_large()) return core::fail("the model takes more than 4 GiB, which an RVM file cannot hold");
    if (!out_.ok()) return core::fail("writing failed (is the disk full?)");
    return {};
  }

 private:
  /// False when the caller cancels.
  bool told() {
    constexpr std::uint64_t kItemsBetween = 4096;
    if (!progress_ || written_ < told_ + kItemsBetween) return true;
    told_ = written_;
    return progress_(double(written_) / double(scene_.item_count()));
  }

  /// Items and child groups may alternate in a file: a child comes before any item inserted after the first item in it
  /// or in a later sibling. This finds that first item's id, by node index.
  void find_first_items(NodeId top) {
    std::vector<NodeId> order;
    scene_.for_each_node(top, [&](NodeId node, const core::Affine&, bool, std::uint32_t, MaterialId) {
      order.push_back(node);
      if (node.index >= first_item_from_.size()) first_item_from_.resize(node.index + 1, core::kNoItem);
      first_item_from_[node.index] = scene_.first_item(node);
    });
    for (std::size_t i = order.size(); i-- > 1;) {
      ItemId& first = first_item_from_[order[i].index];
      if (const NodeId later = scene_.next_sibling(order[i]); later.valid())
        first = std::min(first, first_item_from_[later.index]);
      ItemId& above = first_item_from_[scene_.parent(order[i]).index];
      above = std::min(above, first);
    }
  }

  void write_head(NodeId top) {
    const auto text = [&](std::string_view key) { return attribute(scene_, top, key); };
    out_.begin("HEAD");
    out_.u32(2);
    for (const auto key : {rvm::kInfoKey, rvm::kNoteKey, rvm::kDateKey, rvm::kUserKey, rvm::kEncodingKey})
      out_.string(text(key));
    out_.end();
    out_.begin("MODL");
    out_.u32(1);
    for (const auto key : {rvm::kProjectKey, rvm::kModelKey}) out_.string(text(key));
    out_.end();
  }

  void write_colours() {
    for (const auto& [index, rgb] : palette_.colours()) {
      out_.begin("COLR");
      out_.u32(1);
      out_.u32(index);
      out_.u32(std::uint32_t(rgb[0]) << 24 | std::uint32_t(rgb[1]) << 16 | std::uint32_t(rgb[2]) << 8);
      out_.end();
    }
  }

  void open_group(std::string_view name, const std::array<float, 3>& position, const Look& look) {
    out_.begin("CNTB");
    out_.u32(look.transparency == 0 ? 2 : 3);
    out_.string(name);
    for (const float value : position) out_.f32(value);
    out_.u32(look.colour);
    if (look.transparency != 0) out_.u32(look.transparency << 24);
    out_.end();
  }
  void close_group() {
    out_.begin("CNTE");
    out_.u32(2);
    out_.end();
  }
  void close_wrapped(Frame& frame) {
    if (frame.wrapped) close_group();
    frame.wrapped.reset();
  }

  /// Whether the node is the reader's form of OBST and INSU: an unnamed node on that layer alone, with nothing but
  /// items. It gets no group.
  bool is_layer_node(NodeId node, const Frame& above, const Look& look) const {
    const std::uint32_t layers = scene_.layers(node);
    return (layers == core::kLayerObstruction || layers == core::kLayerInsulation) && above.node != top_ &&
           scene_.name(node).empty() && !scene_.first_child(node).valid() && scene_.first_item(node) != core::kNoItem &&
           scene_.attributes(node).empty() && is_identity(scene_.transform(node)) &&
           look.colour == above.sources[0].look.colour;
  }

  void push_top(NodeId top) {
    Frame frame;
    frame.node = top;
    frame.next_child = scene_.first_child(top);
    frame.world = scene_.world_from_node(top);
    frame.identity = is_identity(frame.world);
    ItemSource own{scene_.first_item(top), 0, {}, {}};
    for (NodeId up = top; up.valid(); up = scene_.parent(up)) {
      if (!own.material.valid()) own.material = scene_.material(up);
      if (own.layers == 0) own.layers = scene_.layers(up);
    }
    frame.sources.push_back(own);
    stack_.push_back(std::move(frame));
  }

  void enter(NodeId node) {
    Frame& above = stack_.back();
    ItemSource own{scene_.first_item(node), scene_.layers(node), scene_.material(node), {}};
    if (!own.material.valid()) own.material = above.sources[0].material;
    if (own.layers == 0) own.layers = above.sources[0].layers;
    own.look = palette_.look(scene_, own.material);
    if (is_layer_node(node, above, own.look)) {
      above.sources.push_back(own);
      return;
    }
    Frame frame;
    frame.node = node;
    frame.next_child = scene_.first_child(node);
    const bool moved = !is_identity(scene_.transform(node));
    frame.world = moved ? above.world * scene_.transform(node) : above.world;
    frame.identity = above.identity && !moved;
    frame.sources.push_back(own);
    open_group(scene_.name(node), parse_position(attribute(scene_, node, rvm::kPositionKey)), own.look);
    stack_.push_back(std::move(frame));
  }

  void step() {
    Frame& frame = stack_.back();
    ItemSource& source = *std::min_element(frame.sources.begin(), frame.sources.end(),
                                           [](const ItemSource& a, const ItemSource& b) { return a.next < b.next; });
    const NodeId child = frame.next_child;
    if (source.next != core::kNoItem && !(child.valid() && first_item_from_[child.index] < source.next)) {
      const ItemId item = source.next;
      source.next = scene_.next_item(item);
      write_item_in_frame(frame, source, item);
    } else if (child.valid()) {
      close_wrapped(frame);
      frame.next_child = scene_.next_sibling(child);
      enter(child);  // invalidates frame
    } else {
      close_wrapped(frame);
      if (frame.node != top_) close_group();
      stack_.pop_back();
    }
  }

  void write_item_in_frame(Frame& frame, const ItemSource& source, ItemId item) {
    const MaterialId own = scene_.item_material(item);
    const Look look = palette_.look(scene_, own.valid() ? own : source.material);
    const bool at_top = frame.node == top_;
    const bool needs_group = at_top || look != source.look;
    if (frame.wrapped && (!needs_group || *frame.wrapped != look)) close_wrapped(frame);
    if (needs_group && !frame.wrapped) {
      open_group(at_top ? scene_.name(top_) : std::string_view{}, {}, look);
      frame.wrapped = look;
    }
    write_item(frame, source.layers, item, look);
  }

  void write_item(const Frame& frame, std::uint32_t layers, ItemId item, const Look& look) {
    ++written_;
    const bool model = (layers & core::kLayerModel) != 0;
    const bool obstruction = !model && (layers & core::kLayerObstruction) != 0;
    const bool insulation = !model && !obstruction && (layers & core::kLayerInsulation) != 0;
    const core::Kind kind = scene_.kind(item);
    const bool mesh = int(kind) >= core::kPrimitiveKindCount;
    out_.begin(obstruction ? "OBST" : insulation ? "INSU" : "PRIM");
    out_.u32(1);
    out_.u32(mesh ? rvm::kFacetGroupKind : std::uint32_t(kind) + 1);
    const core::Affine placement = scene_.placement(item);
    write_matrix(frame.identity ? placement : frame.world * placement, item);
    write_box(mesh ? scene_.mesh_bounds(scene_.mesh_of(item)) : core::bounds(scene_.primitive(item), {}));
    if (obstruction || insulation) out_.u32(look.transparency << 24);
    if (mesh) {
      write_facets(scene_.mesh(scene_.mesh_of(item)));
    } else {
      const core::Primitive primitive = scene_.primitive(item);
      for (const float value : core::parameters(primitive)) out_.f32(value);
    }
    out_.end();
  }

  void write_matrix(const core::Affine& placement, ItemId item) {
    bool finite = true;
    const auto put = [&](double value) {
      const float single = float(value);
      finite = finite && std::isfinite(single);
      out_.f32(single);
    };
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row) put(placement.linear[column][row]);
    for (int row = 0; row < 3; ++row) put(placement.origin[row]);
    if (!finite)
      error_ = {fmt::format("{}: an item's placement does not fit into the single precision of RVM",
                            scene_.path(scene_.node_of(item)))};
  }

  void write_box(const core::AabbD& box) {
    for (int i = 0; i < 3; ++i) out_.f32(box.empty() ? 0.0f : core::round_down(box.min[i]));
    for (int i = 0; i < 3; ++i) out_.f32(box.empty() ? 0.0f : core::round_up(box.max[i]));
  }

  void write_vertex(const core::vec3& position, const core::vec3& normal) {
    for (int i = 0; i < 3; ++i) out_.f32(position[i]);
    for (int i = 0; i < 3; ++i) out_.f32(normal[i]);
  }

  static core::vec3 unit(const core::dvec3& v) {
    const double length = glm::length(v);
    return length > 0.0 ? core::vec3(v / length) : core::vec3(0.0f);
  }

  void write_facets(const core::Mesh& mesh) {
    if (!mesh.is_facet_group()) return write_triangles(mesh);
    out_.u32(std::uint32_t(mesh.polygon_contours.size()));
    std::size_t contour = 0, vertex = 0;
    for (const std::uint32_t contours : mesh.polygon_contours) {
      out_.u32(contours);
      const core::vec3 flat =
          contours > 0 ? unit(newell_normal(std::span(mesh.positions).subspan(vertex, mesh.contour_sizes[contour])))
                       : core::vec3(0.0f);
      for (std::uint32_t c = 0; c < contours; ++c, ++contour) {
        out_.u32(mesh.contour_sizes[contour]);
        for (std::uint32_t v = 0; v < mesh.contour_sizes[contour]; ++v, ++vertex)
          write_vertex(mesh.positions[vertex], mesh.normals.empty() ? flat : mesh.normals[vertex]);
      }
    }
  }

  void write_triangles(const core::Mesh& mesh) {
    out_.u32(std::uint32_t(mesh.indices.size() / 3));
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      out_.u32(1);
      out_.u32(3);
      const std::array<std::uint32_t, 3> corners = {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
      const std::array<core::vec3, 3> points = {mesh.positions[corners[0]], mesh.positions[corners[1]],
                                                mesh.positions[corners[2]]};
      const core::vec3 flat = unit(newell_normal(points));
      for (const std::uint32_t corner : corners)
        write_vertex(mesh.positions[corner], mesh.normals.empty() ? flat : mesh.normals[corner]);
    }
  }

  const core::Scene& scene_;
  rvm::ChunkWriter out_;
  const std::function<bool(double)>& progress_;
  std::uint64_t written_ = 0, told_ = 0;  // items
  NodeId top_;
  Palette palette_;
  std::vector<Frame> stack_;
  std::vector<ItemId> first_item_from_;  // by node index
  core::Error error_;
};

}  // namespace

core::Expected<void> write_rvm(const core::Scene& scene, NodeId node, const std::filesystem::path& path,
                               const std::function<bool(double)>& progress) {
  auto file = core::AtomicFile::create(path);
  if (!file) return tl::unexpected(file.error());
  FileSink sink(*file);
  if (auto written = RvmWriter(scene, sink, progress).run(node); !written) {
    if (written.error().message == kCancelled) return written;
    if (file->failed()) return file->commit();
    return core::fail(fmt::format("{}: {}", path.string(), written.error().message));
  }
  return file->commit();
}

core::Expected<std::vector<std::byte>> write_rvm(const core::Scene& scene, NodeId node) {
  VectorSink sink;
  if (auto written = RvmWriter(scene, sink, {}).run(node); !written) return tl::unexpected(written.error());
  return std::move(sink.bytes);
}

}  // namespace sightline::importers
