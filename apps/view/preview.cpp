#include "sightline/apps/view/preview.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "sightline/apps/common/model.h"
#include "sightline/apps/view/camera.h"
#include "sightline/apps/view/opening_steps.h"

namespace sightline::apps {
namespace {

constexpr int kPatience = 8;  // times as long as making an image took, until the next one

/// Adds items of one scene to another, with what they share.
class PreviewCopier {
 public:
  PreviewCopier(const core::Scene& from, core::Scene& to) : from_(from), to_(to) {}

  void add(core::ItemId item, const core::Scene::ItemState& state) {
    const core::MaterialId material = material_of(state.material);
    if (int(from_.kind(item)) < core::kPrimitiveKindCount)
      to_.add_primitive(to_.root(), from_.primitive(item), state.world_from_item, material);
    else if (const core::MeshId mesh = mesh_of(from_.mesh_of(item)); mesh.valid())
      to_.add_mesh_instance(to_.root(), mesh, state.world_from_item, material);
    else
      add_box(from_.mesh_bounds(from_.mesh_of(item)), state.world_from_item, material);
  }

 private:
  core::MaterialId material_of(std::uint32_t index) {
    if (index == core::kNone) return {};
    core::MaterialId& copy = materials_[index];
    if (!copy.valid()) copy = to_.add_material(from_.material(from_.material_at(index)));
    return copy;
  }

  /// Invalid where the mesh would be too much.
  core::MeshId mesh_of(core::MeshId mesh) {
    const auto known = meshes_.find(mesh.index);
    if (known != meshes_.end()) return known->second;
    core::MeshId& copy = meshes_[mesh.index];
    const std::size_t corners = from_.mesh(mesh).indices.size();
    if (corners > corners_left_) return copy;
    corners_left_ -= corners;
    if (const auto added = to_.add_mesh(from_.mesh(mesh))) copy = *added;
    return copy;
  }

  void add_box(const core::AabbD& bounds, const core::Affine& world_from_item, core::MaterialId material) {
    if (bounds.empty()) return;
    const core::vec3 size(bounds.size());
    to_.add_primitive(to_.root(), core::Box{size.x, size.y, size.z},
                      world_from_item * core::translation(bounds.centre()), material);
  }

  const core::Scene& from_;
  core::Scene& to_;
  std::unordered_map<std::uint32_t, core::MaterialId> materials_;
  std::unordered_map<std::uint32_t, core::MeshId> meshes_;
  std::size_t corners_left_ = Preview::kMostCorners;
};

}  // namespace

Preview::Preview(const engine::EngineConfig& config) : config_(config), next_(Clock::now() + kFirst) {
  config_.culling.culler = engine::CullerChoice::kCpu;
  config_.context.application = nullptr;
  config_.context.later = true;
  config_.drawing.renderer = engine::Renderer::kGl;
  config_.losses.budget_ms = 1e3 * kPortion;
  config_.losses.lod_error = 0.0;
}

/// Lets only those into the heap that are larger than its smallest.
void Preview::look_at(const core::Scene& scene) {
  std::vector<core::ItemId> added(scene.item_slots() - to_index(seen_));
  std::iota(added.begin(), added.end(), seen_);
  seen_ = core::ItemId(scene.item_slots());
  scene.for_each_state(added, [&](core::ItemId item, const core::Scene::ItemState& state) {
    if (state.layers == 0 || !scene.can_commit(item, state.world_from_item)) return;
    const Sized sized{glm::length(scene.bounds_under(item, state.world_from_item).size()), item};
    if (largest_.size() == kMostItems) {
      if (!(sized < largest_.front())) return;
      std::pop_heap(largest_.begin(), largest_.end());
      largest_.pop_back();
    }
    largest_.push_back(sized);
    std::push_heap(largest_.begin(), largest_.end());
    more_ = true;
  });
}

std::vector<core::ItemId> Preview::largest() const {
  std::vector<core::ItemId> items;
  for (const Sized& sized : largest_) items.push_back(sized.item);
  std::sort(items.begin(), items.end());
  return items;
}

std::unique_ptr<core::Scene> Preview::copy(const core::Scene& scene) const {
  auto made = std::make_unique<core::Scene>();
  PreviewCopier copier(scene, *made);
  scene.for_each_state(largest(), [&](core::ItemId item, const auto& state) { copier.add(item, state); });
  return made;
}

bool Preview::follow(const core::Scene& scene, Clock::time_point now) {
  look_at(scene);
  if (!more_ || now < next_) return false;
  const Clock::time_point begin = Clock::now();
  auto items = copy(scene);
  auto engine = engine::Engine::create(*items, config_);
  more_ = false;
  next_ = now + std::max<Clock::duration>(kBetween, kPatience * (Clock::now() - begin));
  if (!engine) return false;
  const core::FittedBounds bounds = engine->snapshot().bounds().fitted_bounds();
  auto fresh = std::make_unique<Shown>(Shown{std::move(items), std::move(*engine), bounds});
  const std::lock_guard lock(mutex_);
  fresh_.swap(fresh);
  return true;
}

std::optional<std::uint32_t> Preview::draw(gl::Context& context, const std::array<int, 2>& size) {
  if (!incoming_) {
    const std::lock_guard lock(mutex_);
    incoming_ = std::move(fresh_);
  }
  bool failed = false;
  if (incoming_ && advance(*incoming_, context, size, failed)) shown_ = std::move(incoming_);
  if (failed) incoming_.reset();
  if (!shown_) return std::nullopt;
  failed = false;
  if (!shown_->complete || shown_->size != size) advance(*shown_, context, size, failed);
  const auto framebuffer = failed ? tl::unexpected(core::Error{}) : shown_->engine.framebuffer();
  return framebuffer ? std::optional(*framebuffer) : std::nullopt;
}

bool Preview::drawing() const {
  const std::lock_guard lock(mutex_);
  return fresh_ || incoming_ || (shown_ && !shown_->complete);
}

/// True once it is complete in that size.
bool Preview::advance(Shown& shown, gl::Context& context, const std::array<int, 2>& size, bool& failed) {
  if (!shown.in_context) {
    const auto used = shown.engine.use_context(context, kPortion);
    failed = !used;
    shown.in_context = used && *used;
    return false;
  }
  if (shown.size != size) {
    const double aspect = double(size[0]) / size[1];
    Camera camera(shown.bounds.bounds, kFovy, aspect);
    camera.show_all(shown.engine.snapshot().bounds(), core::kOverviewDirection, aspect);
    shown.view = camera.view(aspect);
    failed = !shown.engine.resize(size[0], size[1]);
    if (failed) return false;
    shown.size = size;
  }
  const auto report = shown.view ? shown.engine.frame(*shown.view) : tl::unexpected(shown.view.error());
  failed = !report || !report->drawn;
  shown.complete = !failed && report->pending == 0;
  return shown.complete;
}

}  // namespace sightline::apps
