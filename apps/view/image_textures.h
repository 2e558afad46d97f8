// Small images in panels, as textures of the window's context.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "sightline/gl/context.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

/// One is read in a frame, so that a page of many comes at once; those that a frame did not ask for are freed.
class ImageTextures {
 public:
  using Read = std::function<std::optional<image::Image>()>;

  /// Null while it waits to be read, and where there is none.
  const gl::Texture2D* get(const gl::Context& context, const std::string& key, const Read& read);
  /// After the frame is drawn. True where images wait to be read in the next one.
  bool end_frame();
  /// Before the context is lost.
  void clear() { known_.clear(); }

 private:
  struct Known {
    gl::Texture2D texture;  // empty where there is no image
    bool asked = true;      // for by this frame
  };
  std::map<std::string, Known> known_;
  bool has_read_ = false, waits_ = false;  // in this frame
};

}  // namespace sightline::apps
