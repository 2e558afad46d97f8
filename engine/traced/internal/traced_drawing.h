// The backend of an engine whose images rays make: for machines without OpenGL, and where rays are faster. Internal to
// engine.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sightline/core/thread_pool.h"
#include "sightline/engine/internal/backend.h"
#include "sightline/engine/internal/edge_lists.h"
#include "sightline/raytrace/internal/still_image.h"

namespace sightline::engine {

/// Draws what renderers draw, whole: items that losses let an image lack are there, and meshes in full. Needs the
/// tracer of each frame. What it has not, engines refuse: blended transparency, hatching, and what is the application's
/// in GL.
class TracedDrawing : public Backend {
 public:
  /// `overrides` are borrowed. `why`: for the plan.
  TracedDrawing(const EngineConfig& config, const Overrides& overrides, std::string why);

  bool ready() const override { return true; }
  void configure(const EngineConfig& config) override { config_ = config; }
  core::Expected<void> resize(int width, int height) override;
  core::Expected<void> use_image(std::uint32_t number, int width, int height) override;
  void forget_image(std::uint32_t number) override { images_.erase(number); }

  core::Expected<DrawResult> draw(const Frame& frame, const core::VisibleSet& visible, bool on_gpu = false) override;

  core::Expected<image::Image> read_colour() override;
  core::Expected<image::IdImage> read_ids() override;
  core::Expected<image::DepthImage> read_depth(const core::View* view) override;

  BackendReport report() const override;
  bool software() const override { return true; }
  bool traces() const override { return true; }

 private:
  struct Image {
    int width = 0, height = 0;
    raytrace::StillImage pixels;
  };
  void find_shown(const Frame& frame, const core::VisibleSet& visible);
  culling::SlotBits all_but(culling::SlotBits items, culling::SlotBits more = {});
  core::Expected<void> draw_items(const Frame& frame, culling::SlotBits without, raytrace::StillImage& image,
                                  bool as_ghosts = false);
  void draw_edges(const Frame& frame);
  core::Expected<void> draw_ghosts(const Frame& frame);
  core::Expected<void> draw_outline(const Frame& frame);
  core::Expected<void> check_drawn() const;

  EngineConfig config_;
  const Overrides& overrides_;
  std::string why_;
  core::ThreadPool threads_;
  std::map<std::uint32_t, Image> images_;
  Image* image_ = nullptr;
  // A bit per slot: the frame's visible items, if anything asks; what an image leaves out; lines that it shows.
  std::vector<std::uint64_t> shown_, without_, line_bits_;
  std::vector<core::Slot> lines_;
  EdgeLists edges_;
  raytrace::StillImage layer_;  // what is drawn over the image
};

}  // namespace sightline::engine
