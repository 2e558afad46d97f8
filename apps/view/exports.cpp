#include "sightline/apps/view/exports.h"

#include <filesystem>
#include <string>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/view/window.h"

namespace sightline::apps {

void Exports::begin(ModelExport::Job job, Messages& messages) {
  messages.tell("writing " + std::filesystem::path(job.file).filename().string());
  model_ = std::make_unique<ModelExport>(std::move(job), &Window::wake);
}

Done Exports::step(Messages& messages) {
  if (auto done = model_ ? model_->take() : std::nullopt) {
    model_.reset();
    if (!*done) return tl::unexpected(done->error());
    messages.tell(**done);
  }
  return step_image(messages);
}

Done Exports::step_image(Messages& messages) {
  constexpr double kSlice = 0.05;  // seconds between images of the window
  if (!image_) return {};
  Done done;
  for (const double end = glfwGetTime() + kSlice; done && !cancelled_ && !image_->complete() && glfwGetTime() < end;)
    done = image_->step();
  if (done && !cancelled_ && !image_->complete()) return {};
  const auto ended = std::exchange(image_, nullptr);
  if (!done) return done;
  const std::string words =
      (ended->count() > 1 ? std::to_string(ended->frame()) + " frames: " : "image: ") + ended->target();
  if (!ended->complete())
    messages.tell("cancelled, " + words);
  else
    messages.tell(words + (ended->blank() ? " (no pixel shows any item)" : ""));
  return {};
}

}  // namespace sightline::apps
