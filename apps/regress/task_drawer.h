// Draws tasks of a suite and compares the images with their references.
#pragma once

#include "sightline/apps/regress/task_result.h"
#include "sightline/engine/engine.h"

namespace sightline::apps {

/// Keeps the model of the last task, so that tasks of one model in a row read it once. The image of a task does not
/// depend on those before it: nothing is on that learns from earlier frames.
class TaskDrawer {
 public:
  TaskDrawer(const Suite& suite, ResultFolder results, engine::Renderer renderer, gl::ContextPlatform platform)
      : suite_(suite), results_(std::move(results)), renderer_(renderer), platform_(platform) {}

  /// Draws, compares and writes the result; TaskResult::error is part of that. Fails where nothing can be written.
  core::Expected<void> run(const Task& task);

 private:
  struct Drawn {
    image::Image image;
    image::IdImage ids;
  };

  engine::ImageTiles prepare(const Task& task);
  Drawn draw(const Task& task);

  const Suite& suite_;
  ResultFolder results_;
  engine::Renderer renderer_;
  gl::ContextPlatform platform_;
  std::optional<std::size_t> model_;  // in the suite, that is read
  std::optional<Model> read_;
  std::optional<engine::Engine> engine_;
  std::string coloured_by_;  // its items, as Task::colour_by
};

}  // namespace sightline::apps
