// Writes files while the viewer's window goes on: images and frames in short steps, models in the background.
#pragma once

#include <memory>
#include <utility>

#include "sightline/apps/view/export.h"
#include "sightline/apps/view/messages.h"
#include "sightline/apps/view/model_export.h"

namespace sightline::apps {

class Exports {
 public:
  /// Draws and writes from now on, between images of the window, which takes nothing else until that is done.
  void begin(std::unique_ptr<Export> image) {
    image_ = std::move(image);
    cancelled_ = false;
  }
  /// Writes in the background from now on.
  void begin(ModelExport::Job job, Messages& messages);
  const Export* image() const { return image_.get(); }  ///< null while none goes on; frames of a video, too
  void cancel_image() { cancelled_ = true; }
  ModelExport* model() { return model_.get(); }  ///< null while none goes on
  const ModelExport* model() const { return model_.get(); }
  bool busy() const { return image_ || model_; }
  /// Goes on with both for a moment, and tells of what has ended. Fails where an export does.
  Done step(Messages& messages);
  /// Gives up what is not done.
  void drop_image() { image_.reset(); }
  void drop() {
    image_.reset();
    model_.reset();
  }

 private:
  Done step_image(Messages& messages);

  std::unique_ptr<Export> image_;  // with the session's engine
  bool cancelled_ = false;
  std::unique_ptr<ModelExport> model_;  // reads the session's scene
};

}  // namespace sightline::apps
