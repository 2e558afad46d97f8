// What is there of a model that is still being read: its largest items, drawn from above.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/scene.h"
#include "sightline/engine/engine.h"

namespace sightline::apps {

/// One thread reads, another one draws; neither waits for the other. Costs the reading thread a tenth of a microsecond
/// an item and an eighth of its time, and no more memory than so many items and corners take.
class Preview {
 public:
  static constexpr std::size_t kMostItems = 50'000;
  static constexpr std::size_t kMostCorners = 3'000'000;  ///< of meshes; those beyond are shown as their boxes
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kFirst{300}, kBetween{1000};  ///< files read sooner need no preview

  /// `config`: of the images; their size and context do not matter.
  explicit Preview(const engine::EngineConfig& config);

  /// By the thread that reads, with the scene as far as it was read; of always the same scene, to which items are only
  /// added. True: there is more to draw. `now` must not go back.
  bool follow(const core::Scene& scene, Clock::time_point now = Clock::now());

  /// By the thread that draws, in that context, which is current: the framebuffer with the newest image that is
  /// complete, of that size. Each call goes on for about kPortion with the next one. None while there is nothing to
  /// see, and where it cannot be drawn.
  std::optional<std::uint32_t> draw(gl::Context& context, const std::array<int, 2>& size);
  /// Whether another draw() would go on with an image.
  bool drawing() const;
  /// How many items that image shows.
  std::size_t items() const { return shown_ ? shown_->scene->item_count() : 0; }

  /// The items themselves: the largest ones of those that follow() has seen, in rising order.
  std::vector<core::ItemId> largest() const;

 private:
  struct Sized {
    double size;
    core::ItemId item;
    friend bool operator<(const Sized& a, const Sized& b) {
      return a.size != b.size ? a.size > b.size : a.item < b.item;
    }
  };
  struct Shown {
    std::unique_ptr<core::Scene> scene;
    engine::Engine engine;
    core::FittedBounds bounds;
    bool in_context = false, complete = false;
    std::array<int, 2> size{};
    core::Expected<core::View> view = core::fail("no size yet");  // of that size
  };
  static bool advance(Shown& shown, gl::Context& context, const std::array<int, 2>& size, bool& failed);

  void look_at(const core::Scene& scene);
  std::unique_ptr<core::Scene> copy(const core::Scene& scene) const;

  engine::EngineConfig config_;
  // The reading thread's.
  std::vector<Sized> largest_;  // a heap: the smallest of them first
  core::ItemId seen_{0};
  bool more_ = false;  // than was last shown
  Clock::time_point next_;
  mutable std::mutex mutex_;
  std::unique_ptr<Shown> fresh_;           // guarded by it
  std::unique_ptr<Shown> incoming_, shown_;  // the drawing thread's
};

}  // namespace sightline::apps
