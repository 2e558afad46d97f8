#include "sightline/apps/view/image_textures.h"

#include <iterator>
#include <span>
#include <utility>

namespace sightline::apps {
namespace {

/// Empty where the context has no room for it.
gl::Texture2D texture_of(const gl::Functions& gl, const image::Image& image) {
  auto texture = gl::Texture2D::create(gl, image.width, image.height, GL_RGB8, "small image");
  if (!texture) return {};
  texture->write(GL_RGB, GL_UNSIGNED_BYTE, std::as_bytes(std::span(image.pixels)));  // ImGui, too, has the top first
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl.TextureParameteri(texture->id(), filter, GL_LINEAR);
  return std::move(*texture);
}

}  // namespace

const gl::Texture2D* ImageTextures::get(const gl::Context& context, const std::string& key, const Read& read) {
  auto found = known_.find(key);
  if (found == known_.end()) {
    waits_ |= has_read_;
    if (std::exchange(has_read_, true)) return nullptr;
    const auto image = read();
    found = known_.emplace(key, Known{image ? texture_of(context.functions(), *image) : gl::Texture2D()}).first;
  }
  found->second.asked = true;
  return found->second.texture.id() != 0 ? &found->second.texture : nullptr;
}

bool ImageTextures::end_frame() {
  for (auto at = known_.begin(); at != known_.end();)
    at = std::exchange(at->second.asked, false) ? std::next(at) : known_.erase(at);
  has_read_ = false;
  return std::exchange(waits_, false);
}

}  // namespace sightline::apps
