// Images of any size, drawn tile by tile; and camera paths as images.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/common/mean_image.h"
#include "sightline/core/camera_path.h"
#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

/// Largest side of tiles, pixels: larger ones take more memory and are no faster.
inline constexpr int kTileSide = 1024;

/// Rows of an image, from the top.
struct ImageRows {
  int width = 0, first = 0, count = 0;
  std::vector<std::uint8_t> colours;  ///< RGB, 3 bytes per pixel; RGBA, 4 bytes, where the background is transparent
  std::vector<std::uint32_t> ids;     ///< item + 1, 0 is background; where they are wanted
  std::vector<float> metres;          ///< along the view axis; where they are wanted
};

/// What was drawn last, as it is read back.
struct ReadImage {
  image::Image colours;
  image::IdImage ids;       ///< where they are wanted
  image::DepthImage depth;  ///< where it is wanted
  bool covered = true;      ///< whether any pixel shows anything
};

/// Draws an image in steps that are short, for progress and to be stopped between them.
class TiledImage {
 public:
  struct Wanted {
    bool ids = false, depth = false;
    bool transparent = false;  ///< each image is drawn on black and on white, which tells alpha; not with `read`
    bool complete = true;      ///< whatever EngineConfig::losses.budget_ms; otherwise as one frame leaves it
    /// Pixels right and up by which images are shifted whose mean is taken, MeanImage::kMost at most: sample_shifts().
    /// Ids and depth are those of pixel centres; where the first shift is another, one more image is drawn for them.
    std::vector<core::dvec2> shifts = {core::dvec2(0.0)};
    /// Reads what was drawn, where that is not the engine's alone: see Composer.
    /// It is called after failures to draw, too, and then fails.
    std::function<core::Expected<ReadImage>(engine::Engine&, const core::View& whole,
                                            const core::Expected<engine::FrameReport>& drawn)>
        read = {};
  };
  /// `whole`: of the image that the tiles make up.
  TiledImage(const core::View& whole, engine::ImageTiles tiles, Wanted wanted)
      : whole_(whole),
        tiles_(std::move(tiles)),
        wanted_(std::move(wanted)),
        drawn_apart_((wanted_.ids || wanted_.depth) && wanted_.shifts[0] != core::dvec2(0.0)) {}

  std::size_t steps() const { return tiles_.tiles.size() * steps_of_tile(); }
  std::size_t steps_done() const { return done_; }
  bool in_one_tile() const { return tiles_.tiles.size() == 1; }
  bool complete() const { return done_ == steps(); }
  /// Draws one of the images that a tile is the mean of. The engine must have the tiles' size, and ids where they are
  /// wanted. True where that completes rows.
  core::Expected<bool> step(engine::Engine& engine);
  /// The last rows that were completed.
  const ImageRows& rows() const { return rows_; }
  /// The report of the last step.
  const engine::FrameReport& report() const { return report_; }
  bool found() const { return found_; }      ///< whether items were found in the view volume so far
  bool covered() const { return covered_; }  ///< whether a pixel shows any so far

 private:
  std::size_t steps_of_tile() const { return wanted_.shifts.size() + std::size_t(drawn_apart_); }
  core::Expected<void> draw(engine::Engine& engine, const engine::CroppedTile& tile, const core::dvec2& shift);
  core::Expected<ReadImage> draw_and_read(engine::Engine& engine, const engine::CroppedTile& tile,
                                          const core::dvec2& shift, bool first);
  void add(const engine::CroppedTile& tile, const image::Image& image, std::size_t number);
  core::Expected<ReadImage> read(engine::Engine& engine, const core::Expected<void>& drawn, bool ids_and_depth);
  void begin_rows(const engine::CroppedTile& tile);
  template <class T>
  void take(const engine::CroppedTile& tile, const std::vector<T>& drawn, std::vector<T>& rows, std::size_t channels);

  core::View whole_;
  engine::ImageTiles tiles_;
  Wanted wanted_;
  bool drawn_apart_;  // ids and depth
  std::size_t done_ = 0;
  MeanImage mean_, on_white_;
  ImageRows rows_;
  engine::FrameReport report_;
  bool found_ = false, covered_ = false;
};

/// Colours and alpha, 4 bytes per pixel, out of the same pixels on black and on white, 3 bytes each.
std::vector<std::uint8_t> with_alpha(std::span<const std::uint8_t> on_black, std::span<const std::uint8_t> on_white);

/// Shifts that take a pixel's mean over so many samples, 1 to MeanImage::kMost; a single one is none.
std::vector<core::dvec2> sample_shifts(int samples);

/// Tiles for an image that an engine with these settings draws.
core::Expected<engine::ImageTiles> tiles_for(const std::array<int, 2>& size, int largest_side,
                                             const engine::EngineConfig& config);

/// A camera path as numbered images at a constant rate in the path's own time, as programs that make videos read
/// them.
class PathFrames {
 public:
  static constexpr double kMostPerSecond = 1000.0;
  static constexpr int kMost = 999'999;

  /// Fails unless per_second is above 0 and at most kMostPerSecond, and where that makes more than kMost frames.
  static core::Expected<PathFrames> create(const core::CameraPath& path, double per_second);
  int count() const { return count_; }
  double time(int frame) const { return begin_ + frame / per_second_; }  ///< on the path; frames from 0 on
  static std::string file_name(int frame);                               ///< "frame-000001.png" is that of frame 0

 private:
  double begin_ = 0.0, per_second_ = 1.0;
  int count_ = 1;
};

/// Makes a folder for these images where it is missing. Fails where it cannot be made, and where it holds anything.
core::Expected<void> take_empty_folder(const std::string& folder);

}  // namespace sightline::apps
