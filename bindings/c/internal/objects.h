// The objects behind handles. A handle is a number: its kind, and then place and generation, in a table or in the
// scene. It is no pointer, so any number may come from outside.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "sightline/bindings/c/internal/call.h"
#include "sightline/core/scene.h"
#include "sightline/culling/box_culler.h"
#include "sightline/culling/occlusion/occluder_raster.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/paged/paged_engine.h"
#include "sightline/sightline.h"
#if SIGHTLINE_HAS_GL
#include "sightline/gl/context.h"
#endif
#define SIGHTLINE_CAPI_HAS_PAGES (SIGHTLINE_HAS_GL && SIGHTLINE_HAS_IMPORTERS)

namespace sightline::capi {

/// A scene, and what it shares with its engines: they belong to one thread, and are used by one call at a time.
struct SceneObject {
  core::Scene scene;
  std::uint64_t owner = 0;  ///< number of the thread; 0: the next thread that uses it
  bool busy = false;        ///< within a call
  bool broken = false;      ///< an edit was interrupted, by lack of memory
  bool committed = false;
  int engines = 0;
};

struct EngineObject {
  explicit EngineObject(std::shared_ptr<SceneObject> of) : scene(std::move(of)) { ++scene->engines; }
  ~EngineObject() { --scene->engines; }

  std::shared_ptr<SceneObject> scene;
#if SIGHTLINE_HAS_GL
  std::unique_ptr<gl::Context> context;       ///< the application's
  std::unique_ptr<gl::Context> next_context;  ///< the application's next one, taken in portions
  bool context_in_use = false;                ///< neither dropped nor abandoned
#endif
  std::string gl_errors;  ///< taken from the engine, and not yet told
  std::optional<engine::Engine> engine;
};

struct BoxCullerObject {
  explicit BoxCullerObject(culling::BoxCuller made) : culler(std::move(made)) {}

  culling::BoxCuller culler;
};

/// One thread at a time.
struct OccluderRasterObject {
  std::mutex mutex;
  culling::OccluderRaster raster;
  culling::DepthPyramid pyramid;  ///< of the image, where `built`
  int width = 0, height = 0;      ///< 0: there is no image yet, or memory ran out while it was drawn
  bool built = false;
};

#if SIGHTLINE_CAPI_HAS_PAGES
/// One call at a time: PagedEngineUse.
struct PagedEngineObject {
  std::mutex mutex;
  std::atomic<std::thread::id> user{};  ///< the thread whose call uses it
  engine::PagedConfig config;
  bool drawn = false;             ///< it has an image
  std::string errors, gl_errors;  ///< taken from the engine, and not yet told
  std::optional<engine::PagedEngine> engine;
};

/// A call's use of a paged engine. Waits for those of other threads, and refuses calls within the call itself.
class PagedEngineUse {
 public:
  explicit PagedEngineUse(PagedEngineObject& object);
  ~PagedEngineUse();
  PagedEngineUse(const PagedEngineUse&) = delete;
  PagedEngineUse& operator=(const PagedEngineUse&) = delete;

 private:
  PagedEngineObject& object_;
};
#endif

sl_scene add_scene(std::shared_ptr<SceneObject> scene);  ///< owned by this thread
sl_engine add_engine(std::shared_ptr<EngineObject> engine);
sl_box_culler add_box_culler(std::shared_ptr<BoxCullerObject> culler);
sl_occluder_raster add_occluder_raster(std::shared_ptr<OccluderRasterObject> raster);
#if SIGHTLINE_CAPI_HAS_PAGES
sl_paged_engine add_paged_engine(std::shared_ptr<PagedEngineObject> engine);
std::shared_ptr<PagedEngineObject> remove(sl_paged_engine handle);
std::shared_ptr<PagedEngineObject> find(sl_paged_engine handle);
#endif
/// Takes the object out of the table. The caller has used the handle before, on this thread.
std::shared_ptr<SceneObject> remove(sl_scene handle);
std::shared_ptr<EngineObject> remove(sl_engine handle);
std::shared_ptr<BoxCullerObject> remove(sl_box_culler handle);
std::shared_ptr<OccluderRasterObject> remove(sl_occluder_raster handle);

std::shared_ptr<BoxCullerObject> find(sl_box_culler handle);
std::shared_ptr<OccluderRasterObject> find(sl_occluder_raster handle);
/// For an engine to keep. The caller has used the handle before, on this thread.
std::shared_ptr<SceneObject> share(sl_scene handle);
/// Leaves the scene to the next thread that uses it.
void hand_over(SceneObject& scene);

enum class Access : std::uint8_t {
  kRead,
  kEdit,     ///< an exception other than Failure leaves the scene and its engines broken
  kDestroy,  ///< allowed when they are broken
};

/// A call's use of a scene. Refuses handles that are not alive, other threads, and scenes that are in use or broken.
class SceneUse {
 public:
  SceneUse(sl_scene handle, Access access);
  SceneUse(SceneObject& object, Access access);
  ~SceneUse();
  SceneUse(const SceneUse&) = delete;
  SceneUse& operator=(const SceneUse&) = delete;

  core::Scene* operator->() const { return &object_->scene; }
  core::Scene& operator*() const { return object_->scene; }
  SceneObject& object() const { return *object_; }

  core::NodeId id(sl_node node) const;
  core::MeshId id(sl_mesh mesh) const;
  core::MaterialId id(sl_material material) const;
  core::MaterialId id_or_none(sl_material material) const { return material.id ? id(material) : core::MaterialId(); }
  core::ItemId id(sl_item item) const;

 private:
  SceneObject* object_;
  const bool edits_;
  const int exceptions_;
};

/// A call's use of an engine and its scene.
class EngineUse {
 public:
  EngineUse(sl_engine handle, Access access);

  engine::Engine* operator->() const { return &*object_->engine; }
  EngineObject& object() const { return *object_; }
  const SceneUse& scene() const { return scene_; }

 private:
  EngineObject* object_;
  SceneUse scene_;
};

/// What becomes of the scene whose edit an exception has interrupted.
void break_interrupted() noexcept;
void forget_interrupted() noexcept;

/// A null handle for an invalid id.
sl_node handle_of(core::NodeId id);
sl_mesh handle_of(core::MeshId id);
sl_material handle_of(core::MaterialId id);
/// Nodes, meshes and materials of a scene are below this: handles have no room for more.
inline constexpr std::size_t kMostPerScene = std::size_t(1) << 28;

}  // namespace sightline::capi
