#include "sightline/bindings/c/internal/objects.h"

#include <array>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

namespace sightline::capi {
namespace {

enum class HandleKind : std::uint64_t {
  kNone,
  kScene,
  kEngine,
  kBoxCuller,
  kNode,
  kMesh,
  kMaterial,
  kOccluderRaster,
  kPagedEngine,
  kCount
};

// A handle: kind in 4 bits, high in 28, low in 32.
constexpr int kKindShift = 60, kHighShift = 32;
constexpr std::uint64_t kHighMask = (std::uint64_t(1) << (kKindShift - kHighShift)) - 1;

constexpr std::uint64_t make_handle(HandleKind kind, std::uint64_t high, std::uint32_t low) {
  return std::uint64_t(kind) << kKindShift | high << kHighShift | low;
}
constexpr std::uint64_t high_of(std::uint64_t handle) {
  return handle >> kHighShift & kHighMask;
}

const char* name_of(HandleKind kind) {
  constexpr std::array<const char*, std::size_t(HandleKind::kCount)> kNames = {
      "handle", "scene", "engine", "box culler", "node", "mesh", "material", "occluder raster", "paged engine"};
  return kind < HandleKind::kCount ? kNames[std::size_t(kind)] : kNames[0];
}

[[noreturn]] void refuse_handle(std::uint64_t handle, HandleKind expected) {
  const std::string name = name_of(expected);
  if (handle == 0) refuse(SL_ERROR_HANDLE, name + ": null handle");
  const auto found = HandleKind(handle >> kKindShift);
  if (found != expected) refuse(SL_ERROR_HANDLE, name + ": found the handle of another kind: " + name_of(found));
  refuse(SL_ERROR_HANDLE, name + ": stale handle");
}

/// Objects of one kind by handle. A place is used again with the next generation, and not at all after the last one.
template <class T, HandleKind kKind>
class Table {
 public:
  std::uint64_t add(std::shared_ptr<T> object) {
    if (free_.empty()) {
      free_.reserve(places_.size() + 1);  // so that remove() needs no memory
      places_.emplace_back();
      free_.push_back(std::uint32_t(places_.size() - 1));
    }
    const std::uint32_t index = free_.back();
    free_.pop_back();
    places_[index].object = std::move(object);
    return make_handle(kKind, places_[index].generation, index);
  }

  std::shared_ptr<T>& at(std::uint64_t handle) {
    const auto index = std::uint32_t(handle);
    if (handle >> kKindShift != std::uint64_t(kKind) || index >= places_.size() || !places_[index].object ||
        places_[index].generation != high_of(handle))
      refuse_handle(handle, kKind);
    return places_[index].object;
  }

  std::shared_ptr<T> remove(std::uint64_t handle) {
    std::shared_ptr<T> object = std::move(at(handle));
    const auto index = std::uint32_t(handle);
    places_[index].object.reset();
    if (places_[index].generation++ < kHighMask) free_.push_back(index);
    return object;
  }

 private:
  struct Place {
    std::shared_ptr<T> object;
    std::uint64_t generation = 0;
  };
  std::vector<Place> places_;
  std::vector<std::uint32_t> free_;
};

struct Tables {
  std::mutex mutex;  // guards SceneObject::owner, too
  Table<SceneObject, HandleKind::kScene> scenes;
  Table<EngineObject, HandleKind::kEngine> engines;
  Table<BoxCullerObject, HandleKind::kBoxCuller> box_cullers;
  Table<OccluderRasterObject, HandleKind::kOccluderRaster> occluder_rasters;
#if SIGHTLINE_CAPI_HAS_PAGES
  Table<PagedEngineObject, HandleKind::kPagedEngine> paged_engines;
#endif
};

/// Never destroyed: handles may be used while the process ends.
Tables& tables() {
  static Tables& all = *new Tables;
  return all;
}

std::uint64_t this_thread() {
  static std::atomic<std::uint64_t> threads{0};
  thread_local const std::uint64_t number = ++threads;
  return number;
}

/// The scene and the engine that this thread used last. It owns both, so no other thread can destroy them.
template <class T>
struct Recent {
  std::uint64_t handle = 0;
  T* object = nullptr;
};
thread_local Recent<SceneObject> recent_scene;
thread_local Recent<EngineObject> recent_engine;
thread_local SceneObject* interrupted = nullptr;

void take(SceneObject& scene) {
  if (scene.owner == 0) scene.owner = this_thread();
  if (scene.owner != this_thread())
    refuse(SL_ERROR_THREAD, "the scene belongs to another thread: that one must call sl_scene_hand_over()");
}

SceneObject& find(sl_scene handle) {
  if (handle.id == 0 || handle.id != recent_scene.handle) {
    const std::lock_guard lock(tables().mutex);
    SceneObject& scene = *tables().scenes.at(handle.id);
    take(scene);
    recent_scene = {handle.id, &scene};
  }
  return *recent_scene.object;
}

EngineObject& find(sl_engine handle) {
  if (handle.id == 0 || handle.id != recent_engine.handle) {
    const std::lock_guard lock(tables().mutex);
    EngineObject& engine = *tables().engines.at(handle.id);
    take(*engine.scene);
    recent_engine = {handle.id, &engine};
  }
  return *recent_engine.object;
}

template <HandleKind kKind, class Id>
Id id_in(const core::Scene& scene, std::uint64_t handle) {
  const Id id{std::uint32_t(high_of(handle)), std::uint32_t(handle)};
  if (handle >> kKindShift != std::uint64_t(kKind) || !scene.contains(id)) refuse_handle(handle, kKind);
  return id;
}

template <HandleKind kKind, class Id>
std::uint64_t handle_in_scene(Id id) {
  if (!id.valid()) return 0;
  if (id.index >= kMostPerScene)
    throw Failure{SL_ERROR_FAILED, std::string("no handle is left for a ") + name_of(kKind)};
  return make_handle(kKind, id.index, id.generation);
}

}  // namespace

sl_scene add_scene(std::shared_ptr<SceneObject> scene) {
  scene->owner = this_thread();
  const std::lock_guard lock(tables().mutex);
  return {tables().scenes.add(std::move(scene))};
}
sl_engine add_engine(std::shared_ptr<EngineObject> engine) {
  const std::lock_guard lock(tables().mutex);
  return {tables().engines.add(std::move(engine))};
}
sl_box_culler add_box_culler(std::shared_ptr<BoxCullerObject> culler) {
  const std::lock_guard lock(tables().mutex);
  return {tables().box_cullers.add(std::move(culler))};
}
sl_occluder_raster add_occluder_raster(std::shared_ptr<OccluderRasterObject> raster) {
  const std::lock_guard lock(tables().mutex);
  return {tables().occluder_rasters.add(std::move(raster))};
}

std::shared_ptr<SceneObject> remove(sl_scene handle) {
  recent_scene = {};
  const std::lock_guard lock(tables().mutex);
  return tables().scenes.remove(handle.id);
}
std::shared_ptr<EngineObject> remove(sl_engine handle) {
  recent_engine = {};
  const std::lock_guard lock(tables().mutex);
  return tables().engines.remove(handle.id);
}
std::shared_ptr<BoxCullerObject> remove(sl_box_culler handle) {
  const std::lock_guard lock(tables().mutex);
  return tables().box_cullers.remove(handle.id);
}
std::shared_ptr<OccluderRasterObject> remove(sl_occluder_raster handle) {
  const std::lock_guard lock(tables().mutex);
  return tables().occluder_rasters.remove(handle.id);
}

std::shared_ptr<BoxCullerObject> find(sl_box_culler handle) {
  const std::lock_guard lock(tables().mutex);
  return tables().box_cullers.at(handle.id);
}

std::shared_ptr<OccluderRasterObject> find(sl_occluder_raster handle) {
  const std::lock_guard lock(tables().mutex);
  return tables().occluder_rasters.at(handle.id);
}

#if SIGHTLINE_CAPI_HAS_PAGES
sl_paged_engine add_paged_engine(std::shared_ptr<PagedEngineObject> engine) {
  const std::lock_guard lock(tables().mutex);
  return {tables().paged_engines.add(std::move(engine))};
}
std::shared_ptr<PagedEngineObject> remove(sl_paged_engine handle) {
  const std::lock_guard lock(tables().mutex);
  return tables().paged_engines.remove(handle.id);
}
std::shared_ptr<PagedEngineObject> find(sl_paged_engine handle) {
  const std::lock_guard lock(tables().mutex);
  return tables().paged_engines.at(handle.id);
}

PagedEngineUse::PagedEngineUse(PagedEngineObject& object) : object_(object) {
  if (object.user == std::this_thread::get_id())
    refuse(SL_ERROR_BUSY, "the engine is in use by the call that this one is made within");
  object.mutex.lock();
  object.user = std::this_thread::get_id();
}
PagedEngineUse::~PagedEngineUse() {
  object_.user = std::thread::id();
  object_.mutex.unlock();
}
#endif

std::shared_ptr<SceneObject> share(sl_scene handle) {
  const std::lock_guard lock(tables().mutex);
  return tables().scenes.at(handle.id);
}

void hand_over(SceneObject& scene) {
  recent_scene = {};
  const std::lock_guard lock(tables().mutex);
  scene.owner = 0;
}

// --- uses ------------------------------------------------------------------------------------------------------------

SceneUse::SceneUse(sl_scene handle, Access access) : SceneUse(find(handle), access) {}

SceneUse::SceneUse(SceneObject& object, Access access)
    : object_(&object), edits_(access == Access::kEdit), exceptions_(std::uncaught_exceptions()) {
  if (object.busy) refuse(SL_ERROR_BUSY, "the scene is in use by the call that this one is made within");
  if (object.broken && access != Access::kDestroy)
    refuse(SL_ERROR_MEMORY, "memory ran out in an earlier call: destroy the scene and its engines");
  object.busy = true;
}

SceneUse::~SceneUse() {
  object_->busy = false;
  if (edits_ && std::uncaught_exceptions() > exceptions_) interrupted = object_;
}

void break_interrupted() noexcept {
  if (SceneObject* scene = std::exchange(interrupted, nullptr)) scene->broken = true;
}
void forget_interrupted() noexcept {
  interrupted = nullptr;
}

core::NodeId SceneUse::id(sl_node node) const {
  return id_in<HandleKind::kNode, core::NodeId>(object_->scene, node.id);
}
core::MeshId SceneUse::id(sl_mesh mesh) const {
  return id_in<HandleKind::kMesh, core::MeshId>(object_->scene, mesh.id);
}
core::MaterialId SceneUse::id(sl_material material) const {
  return id_in<HandleKind::kMaterial, core::MaterialId>(object_->scene, material.id);
}
core::ItemId SceneUse::id(sl_item item) const {
  if (!object_->scene.contains_item(core::ItemId{item}))
    refuse(SL_ERROR_HANDLE, "item " + std::to_string(item) + ": not in the scene");
  return core::ItemId{item};
}

EngineUse::EngineUse(sl_engine handle, Access access) : object_(&find(handle)), scene_(*object_->scene, access) {}

sl_node handle_of(core::NodeId id) {
  return {handle_in_scene<HandleKind::kNode>(id)};
}
sl_mesh handle_of(core::MeshId id) {
  return {handle_in_scene<HandleKind::kMesh>(id)};
}
sl_material handle_of(core::MaterialId id) {
  return {handle_in_scene<HandleKind::kMaterial>(id)};
}

}  // namespace sightline::capi
