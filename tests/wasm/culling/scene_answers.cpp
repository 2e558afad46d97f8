#include <map>

#include "box_answers.h"
#include "recorded_view.h"
#include "sightline/bindings/wasm/visibility.h"
#include "sightline/core/find_nodes.h"
#include "sightline/culling/occlusion/solid_occluders.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/internal/rvm_attributes.h"
#include "sightline/importers/rvm/internal/rvm_reader.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/raytrace/tracer.h"
#include "sightline/tests/culling/scenes.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests {
namespace {

using core::AabbD;
using core::dvec3;
using Bytes = std::vector<std::byte>;

Bytes bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> letters(std::istreambuf_iterator<char>(in), {});
  const auto bytes = std::as_bytes(std::span(letters));
  return {bytes.begin(), bytes.end()};
}

/// A scene here and, by what it records, there.
class BothScenes {
 public:
  explicit BothScenes(RecordWriter& out) : out_(&out) {}

  bool read(const Bytes& bytes, const std::string& name, bool anew) {
    if (anew) {
      scene_ = std::make_unique<core::Scene>();
      nodes_.clear();
      number_of_.clear();
      find_nodes();
      out_->text("scene");
    }
    const std::string extension = std::filesystem::path(name).extension().string();
    const core::NodeId root = scene_->root();
    auto report = extension == ".rvm"   ? importers::read_rvm(bytes, name, *scene_, root)
                  : extension == ".slc" ? importers::read_slc(bytes, name, *scene_, root, {})
                                        : importers::read_rvm_attributes(bytes, name, *scene_, root);
    out_->text("read");
    out_->text(name);
    out_->array(std::span(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    out_->text(report ? "" : report.error().message);
    if (!report) return false;
    std::vector<double> numbers{report->metres_per_unit, double(report->degenerate), double(report->attributed),
                                double(report->warnings.size())};
    numbers.insert(numbers.end(), report->items.begin(), report->items.end());
    out_->array(numbers);
    find_nodes();
    return true;
  }

  /// The scene cache of this scene.
  Bytes cache(const std::filesystem::path& beside) const {
    std::filesystem::path file = beside;
    file.replace_extension(".slc");
    if (!importers::write_slc(*scene_, file)) return {};
    Bytes bytes = bytes_of(file);
    std::filesystem::remove(file);
    return bytes;
  }

  /// Commits, and makes a new snapshot.
  void commit() {
    out_->text("commit");
    snapshot_.reset();
    if (!scene_->commit()) return;
    make();
  }
  /// Commits, and lets the snapshot follow.
  void follow() {
    out_->text("commit");
    const auto delta = scene_->commit();
    if (!delta) return;
    const auto touched = snapshot_->apply(*delta);
    culler_->update(touched, &threads_);
    if (const auto updated = tracer_->update(touched); !updated) out_->text(updated.error().message);
  }

  void record_content() {
    out_->text("content");
    std::string names;
    std::vector<std::uint32_t> parents, item_nodes;
    std::vector<std::uint8_t> kinds;
    for (const core::NodeId node : nodes_) {
      names.append(scene_->name(node)).push_back('\0');
      const core::NodeId parent = scene_->parent(node);
      parents.push_back(parent.valid() ? number_of_.at(parent.index) : core::kNone);
    }
    for (std::uint32_t i = 0; i < scene_->item_slots(); ++i) {
      const core::ItemId item{i};
      const bool there = scene_->contains_item(item);
      item_nodes.push_back(there ? number_of_.at(scene_->node_of(item).index) : core::kNone);
      kinds.push_back(there ? std::uint8_t(scene_->kind(item)) : std::uint8_t(0xff));
    }
    out_->text(names);
    out_->array(parents);
    out_->array(item_nodes);
    out_->array(kinds);
    record_boxes();
  }
  void record_attributes() {
    for (std::size_t i = 0; i < nodes_.size(); i += 1 + nodes_.size() / 300) {
      std::string text;
      for (const auto& [key, value] : scene_->attributes(nodes_[i])) {
        text.append(key).push_back('\0');
        text.append(value).push_back('\0');
      }
      out_->text("attributes");
      out_->numbers({double(i)});
      out_->text(text);
    }
  }
  /// Exact names, whole words and patterns of some nodes, and what is none.
  void record_found() {
    std::vector<std::string> texts{"Name=", "*1*", "PIPE", "re:\\d$", "re:("};
    for (std::size_t i = 0; i < nodes_.size(); i += 1 + nodes_.size() / 10) {
      texts.emplace_back(scene_->name(nodes_[i]));
      texts.push_back(scene_->path(nodes_[i]));
    }
    for (const std::string& text : texts) {
      const core::NodeCondition condition{"", text};
      const auto found = core::find_nodes(*scene_, scene_->root(), {&condition, 1});
      std::vector<std::uint32_t> numbers;
      if (found)
        for (const core::NodeId node : found->nodes) numbers.push_back(number_of_.at(node.index));
      out_->text("find");
      out_->text(text);
      out_->text(found ? "" : found.error().message);
      out_->array(numbers);
    }
  }
  void record_boxes() {
    boxes_.assign(scene_->item_slots(), AabbD());
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
      const core::Slot slot = snapshot_->slot(core::ItemId(i));
      if (slot == core::kNone || snapshot_->vacant(slot)) continue;
      const core::Aabb local = snapshot_->bounds().box(slot);
      boxes_[i] = {dvec3(local.min) + snapshot_->bounds().origin, dvec3(local.max) + snapshot_->bounds().origin};
    }
    out_->array(numbers_of(boxes_));
  }

  void look(const core::View& view, int width, int height) {
    view_.emplace(wasm::ViewObject{view, width, height});
    out_->text("view");
    write_view(*out_, view, width, height);
  }
  void visible(bool behind, float least_area) {
    core::VisibleSet set;
    wasm::find_visible(snapshot_->bounds(), *culler_, *view_, {behind ? &pyramid_ : nullptr, least_area}, nullptr, set);
    std::vector<std::uint32_t> items;
    set.for_each_slot([&](core::Slot slot) {
      if (!snapshot_->vacant(slot)) items.push_back(core::to_index(snapshot_->item(slot)));
    });
    out_->text("sceneVisible");
    out_->numbers({behind ? 1.0 : 0.0, double(least_area)});
    out_->array(items);
  }
  void occlude(float least_area) {
    out_->text("occlude");
    out_->numbers({double(least_area)});
    core::VisibleSet set;
    wasm::find_visible(snapshot_->bounds(), *culler_, *view_, {nullptr, least_area}, nullptr, set);
    solids_.begin(*snapshot_, view_->view, view_->width, view_->height);
    solids_.add(set, &threads_);
    solids_.build(pyramid_, {}, &threads_);
  }
  void pick(const core::Ray& ray, bool all, bool in_view) {
    const raytrace::RayFilter filter = in_view ? raytrace::filter_of(view_->view) : raytrace::RayFilter();
    std::vector<raytrace::Hit> hits;
    if (!tracer_->all(ray, hits, filter)) hits.clear();
    // Where surfaces lie in each other, any of them may be the first: the order of slots decides.
    if (!all && !hits.empty()) {
      constexpr double kSame = 1e-9;
      const double last = hits.front().t + kSame * std::max(1.0, std::abs(hits.front().t));
      std::erase_if(hits, [&](const raytrace::Hit& hit) { return hit.t > last; });
    }
    std::vector<double> numbers;
    std::string faces;
    for (const raytrace::Hit& hit : hits) {
      numbers.insert(numbers.end(),
                     {double(core::to_index(hit.item)), double(number_of_.at(scene_->node_of(hit.item).index)),
                      hit.triangle == core::kNone ? -1.0 : double(hit.triangle), hit.t, hit.point.x, hit.point.y,
                      hit.point.z, hit.normal.x, hit.normal.y, hit.normal.z});
      faces.append(core::name_of(hit.face)).push_back('\0');
    }
    out_->text("pick");
    out_->numbers({ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z,
                   ray.t_min, ray.t_max, all ? 1.0 : 0.0, in_view ? 1.0 : 0.0});
    out_->array(numbers);
    out_->text(faces);
  }

  void edit(Random& random) {
    for (int i = 0; i < 30; ++i) {
      const core::ItemId item{std::uint32_t(whole(random, 0, int(scene_->item_slots()) - 1))};
      if (!scene_->contains_item(item)) continue;
      const int what = whole(random, 0, 2);
      core::Affine placement;
      placement.origin = point(random, 30.0);
      core::dmat4 matrix(1.0);
      matrix[3] = core::dvec4(placement.origin, 1.0);
      if (what == 0) scene_->remove_item(item);
      if (what == 1) scene_->set_visible(item, false);
      if (what == 2) scene_->set_placement(item, placement);
      out_->text("edit");
      out_->numbers({double(what), double(core::to_index(item))});
      out_->array(numbers_of(matrix));
    }
  }

  const std::vector<AabbD>& boxes() const { return boxes_; }
  const core::Scene& scene() const { return *scene_; }
  const std::vector<core::NodeId>& nodes() const { return nodes_; }

 private:
  void find_nodes() {
    scene_->for_each_node(scene_->root(), [&](core::NodeId node, const auto&...) {
      if (number_of_.try_emplace(node.index, std::uint32_t(nodes_.size())).second) nodes_.push_back(node);
    });
  }
  void make() {
    tracer_.reset();
    culler_.reset();
    snapshot_ = std::make_unique<core::Snapshot>(*scene_);
    culler_.emplace(snapshot_->bounds());
    tracer_.emplace(std::move(*raytrace::Tracer::create(*snapshot_)));
  }

  RecordWriter* out_;
  std::unique_ptr<core::Scene> scene_;
  std::vector<core::NodeId> nodes_;
  std::map<std::uint32_t, std::uint32_t> number_of_;
  std::unique_ptr<core::Snapshot> snapshot_;
  std::optional<culling::CpuCuller> culler_;
  std::optional<raytrace::Tracer> tracer_;
  core::ThreadPool threads_;
  culling::SolidOccluders solids_;
  culling::DepthPyramid pyramid_;
  std::optional<wasm::ViewObject> view_;
  std::vector<AabbD> boxes_;
};

/// Attributes of some groups, with the path of each from the file's node down.
std::string attribute_file(const core::Scene& scene, core::NodeId file) {
  std::string text = "CADC_Attributes_File v1.0 , start: NEW , end: END , name_end: := , sep: &end&\n";
  int groups = 0;
  const auto write = [&](const auto& self, core::NodeId node, int depth) -> void {
    for (core::NodeId child = scene.first_child(node); child.valid(); child = scene.next_sibling(child)) {
      if (scene.name(child).empty() || ++groups > 400) continue;
      text.append("NEW ")
          .append(scene.name(child))
          .append("\nBore:= 100 &end& Spec:= 'Ä")
          .append(std::to_string(groups));
      text += "'\n";
      if (depth < 8) self(self, child, depth + 1);
      text += "END\n";
    }
  };
  write(write, file, 0);
  return text;
}

void record_views_and_rays(BothScenes& both, Random& random, int views, int rays) {
  AabbD all;
  for (const AabbD& box : both.boxes())
    if (!box.empty()) all.grow(box);
  const double half = 0.5 * glm::length(all.size());
  for (int i = 0; i < views; ++i) {
    core::View view = random_view(random, all.centre(), 0.5 * half);
    if (i % 3 == 2) add_sections(random, all.centre(), 0.5 * half, view);
    both.look(view, whole(random, 64, 640), whole(random, 64, 360));
    both.visible(false, 0.0f);
    both.occlude(i % 2 ? 0.0f : float(magnitude(random, 1.0, 300.0)));
    both.visible(true, 0.0f);
    both.visible(true, 4.0f);
    for (int k = 0; k < rays; ++k) {
      core::Ray ray{.origin = all.centre() + point(random, half), .direction = {}};
      const AabbD& aim = both.boxes()[std::size_t(whole(random, 0, int(both.boxes().size()) - 1))];
      const dvec3 target = aim.empty() ? all.centre() : aim.centre();
      ray.direction = chance(random, 0.2) ? point(random, 1.0) : target - ray.origin;
      ray.t_min = 0.0;
      ray.t_max = chance(random, 0.2) ? 0.5 : std::numeric_limits<double>::infinity();
      both.pick(ray, k % 4 == 0, i % 3 == 2 && k % 2 == 0);
    }
  }
}

}  // namespace

bool write_scene_answers(const std::filesystem::path& file) {
  RecordWriter out(file);
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Random random(seed);
    core::Scene plant;
    if (!importers::generate_plant({.items = std::uint64_t(5000) * seed, .seed = seed}, plant)) return false;
    const auto model = importers::write_rvm(plant, plant.root());
    if (!model) return false;
    BothScenes both(out);
    out.text("case");
    out.text("plant, seed " + std::to_string(seed));
    if (!both.read(*model, "plant.rvm", true)) return false;
    const std::string attributes = attribute_file(both.scene(), both.nodes()[1]);
    const auto bytes = std::as_bytes(std::span(attributes));
    if (!both.read({bytes.begin(), bytes.end()}, "plant.txt", false)) return false;
    both.commit();
    both.record_content();
    both.record_attributes();
    both.record_found();
    record_views_and_rays(both, random, 6, repeated(1000));
    both.edit(random);
    both.follow();
    both.record_content();
    record_views_and_rays(both, random, 3, repeated(200));

    const Bytes cache = both.cache(file);
    out.text("case");
    out.text("scene cache of plant, seed " + std::to_string(seed));
    if (!both.read(cache, "plant.slc", true)) return false;
    both.commit();
    both.record_content();
    both.record_attributes();
    record_views_and_rays(both, random, 3, repeated(200));

    // Damaged and foreign bytes: the words of the refusal count, and the scene that was there.
    out.text("case");
    out.text("refused bytes, seed " + std::to_string(seed));
    Bytes half(model->begin(), model->begin() + std::ptrdiff_t(model->size() / 2));
    both.read(half, "half.rvm", true);
    both.read(Bytes(100), "zeros.slc", false);
    both.read(Bytes(100), "zeros.txt", false);
    both.commit();
    both.record_content();
  }
  return out.close();
}

}  // namespace sightline::tests
