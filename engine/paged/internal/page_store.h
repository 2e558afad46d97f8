// Which pages are in memory, in CPU and GPU, and which come and go. Internal to engine.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "sightline/core/paged_scene.h"
#include "sightline/gl/context.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::raytrace {
class Tracer;
}

namespace sightline::engine {

/// Reads pages on a thread of its own, in the order in which they are asked for.
class PageLoader {
 public:
  struct Loaded {
    std::uint32_t page;
    core::Expected<std::unique_ptr<core::Page>> content;
    std::vector<gpuscene::MeshPool::LevelsOfMesh> levels = {};  ///< where the page says that its meshes come with some
    std::shared_ptr<const raytrace::Tracer> tracer = {};        ///< where pages are traced
  };
  /// The scene must outlive it. `traced`: makes tracers.
  PageLoader(const core::PagedScene& scene, bool traced);
  ~PageLoader();

  void ask_for(std::uint32_t page);
  std::vector<Loaded> take();
  /// Until take() has something, at most so long. False when there is nothing to wait for.
  bool wait(double seconds);
  std::size_t on_their_way() const { return on_their_way_; }  ///< asked for and not taken

 private:
  void run();
  Loaded load(std::uint32_t page) const;
  Loaded prepared(std::uint32_t page) const;

  const core::PagedScene& scene_;
  const bool traced_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::uint32_t> asked_;
  std::vector<Loaded> loaded_;
  bool stop_ = false;
  std::size_t on_their_way_ = 0;
  std::thread thread_;
};

/// A page on the GPU, as drawing needs it.
struct UploadedPage {
  gpuscene::GpuScene scene;
  gpuscene::DrawLists lists;
};

/// A page in memory.
struct ResidentPage {
  std::unique_ptr<core::Page> content;
  std::vector<gpuscene::MeshPool::LevelsOfMesh> levels;  ///< for the upload, which takes them
  std::optional<UploadedPage> uploaded;                  ///< none: it can be traced and not yet drawn
  std::vector<std::uint64_t> lines;                      ///< a bit per slot; empty where the page has no lines
  std::size_t level_bytes = 0;                           ///< of levels of detail; 0: it has none
  std::shared_ptr<const raytrace::Tracer> tracer;        ///< of its items; null: pages are not traced
  std::size_t bytes = 0;                                 ///< as counted against the limit
  std::uint64_t used = 0;                                ///< frame that last drew it
  float area = 0.0f;                                     ///< pixels of its leaves in that frame
  bool needed = false;                                   ///< whether an image has needed it

  std::size_t memory_bytes() const;  ///< of one that is uploaded
};

/// Keeps pages within a number of bytes. What a page will take is counted from when it is asked for.
class PageStore {
 public:
  /// A page that should come, and how much of the image waits for it. `now`: or only foreseen.
  struct Wanted {
    std::uint32_t page;
    float area;
    bool now;
  };
  struct Counts {
    std::uint32_t resident = 0;
    std::uint64_t loaded = 0, evicted = 0, prefetched = 0, failed = 0;
  };

  /// Uses `pages` and `load` of `scene`. `traced`: moving images trace the pages; PageInfo::memory_bytes includes
  /// tracer_bytes() then.
  PageStore(const core::PagedScene& scene, std::size_t limit, bool traced);

  /// Bytes that a page takes while it is uploaded, and the largest one.
  static std::size_t bytes_of(const core::PagedScene::PageInfo& info);
  /// And what its tracer takes while it is made.
  static std::size_t tracer_bytes(const core::PagedScene::PageInfo& info);
  static std::size_t largest_page(const core::PagedScene& scene);

  /// Pages asked for at a time: few, so that what is asked for next is what the newest image needs.
  static constexpr std::size_t kMostAsked = 12;

  std::span<const std::uint32_t> resident() const { return resident_; }
  ResidentPage* find(std::uint32_t page) { return pages_[page].get(); }
  bool failed(std::uint32_t page) const { return failed_[page]; }
  std::size_t on_their_way() const { return loader_.on_their_way(); }
  /// Takes what was read.
  void take_loaded(std::uint64_t frame);
  /// Uploads pages that are not. `context` must be current. After a failure, what is not uploaded may be asked for
  /// again.
  core::Expected<void> upload(const gl::Context& context);
  /// Asks for pages, first things first, as long as there is room or pages can go: those that were used longest ago,
  /// and the smallest of them. Where `stays`, what this frame's image has drawn may go, too; else only for what is
  /// larger.
  void ask_for(std::span<const Wanted> wanted, std::uint64_t frame, bool stays);
  /// Gives up pages until no more than so many bytes are in use. Room for the largest page stays in any case: else no
  /// image could be completed.
  void set_limit(std::size_t limit);
  /// A page has drawn: what it takes may have grown.
  void count_again(std::uint32_t page);
  /// An image has needed a page.
  void need(std::uint32_t page);

  bool wait(double seconds) { return loader_.wait(seconds); }
  const Counts& counts() const { return counts_; }
  std::size_t bytes() const { return bytes_; }
  std::size_t resident_bytes() const { return resident_bytes_; }  ///< of these, what is not on its way
  std::size_t limit() const { return limit_; }
  std::vector<std::string> take_errors() { return std::exchange(errors_, {}); }

 private:
  static core::Expected<void> upload(const gl::Context& context, ResidentPage& page);
  bool make_room(std::size_t bytes, const Wanted& wanted, std::uint64_t frame, bool stays);
  /// The page with the lowest goes first.
  std::pair<std::uint64_t, float> rank(std::uint32_t page) const { return {pages_[page]->used, pages_[page]->area}; }
  std::uint32_t first_to_go() const;
  void evict(std::uint32_t page);
  /// What a resident page takes was so much, and is measured again.
  void recount(ResidentPage& page);

  const core::PagedScene& scene_;
  const std::size_t largest_page_;
  std::size_t limit_, bytes_ = 0, resident_bytes_ = 0;
  std::vector<std::unique_ptr<ResidentPage>> pages_;  // by page; null: not in memory
  std::vector<std::uint32_t> resident_;               // in any order
  std::vector<bool> asked_, failed_;
  std::vector<std::string> errors_;
  Counts counts_;
  PageLoader loader_;
};

}  // namespace sightline::engine
