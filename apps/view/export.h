// Images that take a while: drawn in short steps, so that the window stays alive.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "sightline/apps/common/colour_file.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/tiled_image.h"
#include "sightline/apps/view/painting.h"
#include "sightline/apps/view/session.h"

namespace sightline::apps {

/// Draws with the session's engine, in another size and without a time budget, what the session shows now. Nothing of
/// the session may change meanwhile, and it must outlive this, which puts the engine back as it was. A file appears
/// when it is complete.
class Export {
 public:
  struct Options {
    std::array<int, 2> size{};
    bool smooth = true;                                       ///< edges, where the session smooths them at rest
    Painter marks = {};                                       ///< over each image; empty: none
    std::optional<DrawnOptions::Background> background = {};  ///< none: the session's
  };

  /// One image. Fails where the file cannot be written.
  static core::Expected<std::unique_ptr<Export>> image(Session& session, const Options& options,
                                                       const std::string& file);
  /// Exports the frames of a path, into a folder that is empty or not there yet.
  static core::Expected<std::unique_ptr<Export>> frames(Session& session, const Options& options,
                                                        const core::CameraPath& path, double per_second,
                                                        const std::string& folder);
  Export(const Export&) = delete;
  Export& operator=(const Export&) = delete;
  ~Export();

  core::Expected<void> step();
  bool complete() const { return frame_ == count_; }
  double progress() const;  ///< 0 … 1
  int frame() const { return frame_; }
  int count() const { return count_; }
  const std::array<int, 2>& size() const { return options_.size; }
  const std::string& target() const { return target_; }  ///< file or folder
  bool blank() const { return blank_; }                  ///< whether all images so far show nothing
  /// The session's image before the export.
  const image::Image& before() const { return before_; }

 private:
  Export(Session& session, const Options& options, std::string target);
  static core::Expected<std::unique_ptr<Export>> create(Session& session, const Options& options, std::string target);
  core::Expected<void> begin_frame();
  core::Expected<void> write(const ImageRows& rows);
  std::vector<std::uint8_t> marked(const ImageRows& rows) const;

  Session* session_;
  Options options_;
  std::string target_;
  std::optional<core::CameraPath> path_;  // without it one image of the session's camera
  PathFrames frames_;
  int frame_ = 0, count_ = 1;
  engine::ImageTiles tiles_;
  std::vector<core::dvec2> shifts_;
  std::optional<TiledImage> image_;  // of the frame that is being drawn
  Painting marks_;
  std::optional<ColourFile> file_;
  image::Image before_;
  bool transparent() const { return options_.background && options_.background->transparent; }

  gpuprims::Background background_;  // of the session
  double budget_ms_ = 0.0;
  bool blank_ = true;
};

}  // namespace sightline::apps
