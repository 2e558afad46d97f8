// Draws scenes that are larger than memory (core/paged_scene.h), within a limit for CPU and GPU together.
//
//   auto scene = importers::open_paged_scene("plant.slc");
//   auto engine = engine::PagedEngine::create(std::move(*scene), {.memory_limit = 2ull << 30});
//   do { report = engine->frame(view); } while (report && !report->complete);
//   image::write_png(engine->read_colour(), "out.png");
//
// Each frame shows what is in memory. For pages that are not, it shows their meshes by the coarsest of their levels of
// detail, where the scene cache has levels (importers::SlcWriteOptions::levels), and else a splat for each leaf. Pages
// are read by the size that their leaves have in the image, and ahead of the camera. A view that stays is completed
// frame by frame, page after page, also where it needs more than memory holds: what is drawn stays in the image when
// its page goes. Complete images of one scene cache are to the bit what Engine draws of it, with the same lod_error,
// but where two items have the very same surface: there either shows. Parts of a folder keep the origins that they were
// written with. Those of a scene that was joined in memory are others, so last bits of depths and of colours on edges
// may differ.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/paged_scene.h"
#include "sightline/core/view.h"
#include "sightline/engine/engine_config.h"

namespace sightline::gl {
class Context;
}  // namespace sightline::gl
namespace sightline::image {
struct DepthImage;
struct IdImage;
struct Image;
}  // namespace sightline::image

namespace sightline::engine {

/// The groups are those of EngineConfig. create() fails where a setting is not its default that a paged engine lacks:
/// it draws drawing.ids and drawing.looks, with losses.lod_error by levels of detail that the scene cache has, and
/// makes its own context. Pages that the coarsest levels show well enough are read in these alone. With
/// losses.budget_ms, frames of a view that has changed are traced within that time: PagedEngine::frame().
struct PagedConfig {
  int width = 1280, height = 720;  ///< pixels
  int threads = 0;                 ///< as EngineConfig has it: that trace a frame
  DrawingConfig drawing = {};
  LossConfig losses = {};
  ContextConfig context = {};
  /// Bytes that the whole process may have in memory, and its buffers on a GPU where that is main memory. Pages get
  /// what the program, its drivers and the boxes of all leaves leave of it, less room to read each image once (11 bytes
  /// a pixel, 15 with ids), less a tenth, and 32 MiB at least, for what changes while frames are drawn. Where more than
  /// that is taken, by drivers or the application, pages get less, down to one at a time: nothing else can be given
  /// back. PagedReport::memory says what all takes. A GPU with memory of its own is not asked: pages count what they
  /// take there, but images and drivers are not seen. The files that pages are read from do not count: they stay with
  /// the system, which takes their memory back when it is needed.
  std::size_t memory_limit = 0;
  /// Milliseconds for which a frame of a view that stays takes in pages as they arrive, before it shows what it has.
  double refine_ms = 100.0;
  /// A bar at the lower left of images that are not complete: the share of their leaves that are drawn.
  bool loading_bar = true;
};

struct PagedReport {
  std::uint64_t frame = 0;        ///< calls of frame() before this one
  double frame_ms = 0.0;          ///< of wall clock, until all was drawn
  std::int64_t leaves = 0;        ///< in the view volume that may cover a sample; of a traced image: pending
  std::int64_t pending = 0;       ///< of these, not drawn yet and not known to be hidden: their pages are not in memory
  double coarseness = 1.0;        ///< as FrameReport has it, of traced images
  double earlier = 0.0;           ///< likewise
  std::int64_t placeholders = 0;  ///< splats drawn for them
  std::int64_t coarse_items = 0;  ///< items drawn for them by their coarsest levels
  std::int64_t items_drawn = 0;   ///< items drawn into the image so far
  bool complete = false;          ///< nothing is pending; with failed pages, nothing that can be read
  std::uint32_t resident = 0;     ///< pages in memory
  std::uint64_t loaded = 0;       ///< pages read since the start
  std::uint64_t evicted = 0;      ///< pages given up since the start
  std::uint64_t prefetched = 0;   ///< of those read, pages that no image needed yet
  std::uint64_t failed = 0;       ///< pages that cannot be read: take_errors()
  std::uint32_t coarse_resident = 0;  ///< pages of coarsest levels in memory, and those read since the start
  std::uint64_t coarse_loaded = 0;
  std::size_t memory = 0;  ///< bytes of the process now; 0 where the system does not say
};

/// Not thread-safe; reads pages on a thread of its own. The destructor waits for the page that is being read. Its
/// context is current within calls alone, as an Engine's own is, and not in Progress. PagedScene::load must not use the
/// engine.
class SIGHTLINE_API PagedEngine {
 public:
  /// Makes an offscreen context and compiles programs for the kinds of items that the scene has. Where the limit leaves
  /// little, it also reads and draws the largest page once, to see what drivers take. Fails as Engine::create() does,
  /// on sizes that the context does not support, when memory runs out, and when the limit leaves no room for the
  /// largest page: the message says how much is needed.
  static core::Expected<PagedEngine> create(core::PagedScene scene, const PagedConfig& config);
  PagedEngine(PagedEngine&&) noexcept;
  PagedEngine& operator=(PagedEngine&&) noexcept;
  ~PagedEngine();

  /// Draws what is in memory of the view, and asks for what is not. The same view again goes on with the image. With
  /// losses.budget_ms, a view that differs from the one before is traced by rays instead: as many as there is time for,
  /// beside the points that earlier frames have found. Leaves that are not in memory are boxes there, with no id, and
  /// pages that these stand for are read; frames of the same view then draw as without a budget. Each item costs some
  /// 170 bytes more in memory. Fails
  /// for views that cannot be drawn, and when GL fails or memory runs out: what is in memory stays, and the next call
  /// goes on. Once the context is lost, all calls fail. A page that cannot be read is no failure: see
  /// PagedReport::failed. It is not asked for again.
  core::Expected<PagedReport> frame(const core::View& view);
  /// Waits until a page has arrived for the next frame, at most so long; may be infinite. False, at once, where none is
  /// on its way.
  bool wait(double seconds);
  /// Progress callback, called now and then with how far an image is. Returning false stops.
  using Progress = std::function<bool(const PagedReport&)>;
  /// As frame() until the image is complete, without showing what comes between.
  core::Expected<PagedReport> settle(const core::View& view, const Progress& progress = {});

  /// Why pages could not be read, each once.
  std::vector<std::string> take_errors();
  /// Messages of the driver; only with gl_debug.
  std::vector<std::string> take_gl_errors();

  /// Reads the last frame, which there must have been; waits for the GPU. Splats have the id of the background, and no
  /// depth.
  image::Image read_colour() const;
  image::IdImage read_ids() const;  ///< only with PagedConfig::drawing.ids
  image::DepthImage read_depth() const;

  const core::PagedScene& scene() const;
  std::string renderer() const;
  /// Bytes of pages in memory and on their way, and what they may come to.
  struct Memory {
    std::size_t pages = 0, limit = 0;
  };
  Memory memory() const;

 private:
  class Impl;
  explicit PagedEngine(std::unique_ptr<Impl> impl);
  /// As create(), in a context that is made already: for tests of this library.
  static core::Expected<PagedEngine> create_in(gl::Context context, core::PagedScene scene, const PagedConfig& config);
  friend struct PagedEngineInContext;

  std::unique_ptr<Impl> impl_;
};

}  // namespace sightline::engine
