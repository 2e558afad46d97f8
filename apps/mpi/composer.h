// The image of a scene whose parts are drawn by the processes of an MPI run.
#pragma once

#include "sightline/apps/common/tiled_image.h"
#include "sightline/apps/mpi/composition.h"
#include "sightline/apps/mpi/session.h"

namespace sightline::apps {

class Composer {
 public:
  explicit Composer(const MpiSession& session);
  ~Composer();
  Composer(const Composer&) = delete;
  Composer& operator=(const Composer&) = delete;

  /// The part of a scene that this process draws: engines need that, one sample, and ids.
  engine::ScenePart part() const { return {session_.rank(), session_.size()}; }

  /// All processes call it after each frame of the same view, with what that frame gave. Rank 0 gets the image
  /// of all parts, the others that of theirs. Processes whose part is not in the view send nothing: MPI_Comm_split
  /// leaves them out. The rest meet in one MPI_Reduce with an operator on fragments, so how images travel is up to
  /// MPI. Fails in all processes where it fails in one.
  core::Expected<ReadImage> read(engine::Engine& engine, const core::View& whole,
                                 const core::Expected<engine::FrameReport>& drawn);

  /// A number of each process, by rank, for rank 0; empty for the others. All processes call it.
  std::vector<double> gather(double own) const;

  /// In the last read(): processes that drew something, and the items that all of them found in the view volume.
  int drawing() const { return drawing_; }
  std::int64_t visible() const { return visible_; }

 private:
  core::Expected<std::vector<Fragment>> fragments(engine::Engine& engine);
  std::uint32_t order_of(const core::Snapshot& snapshot, core::ItemId item);

  const MpiSession& session_;
  struct State;
  std::unique_ptr<State> state_;
  std::vector<std::uint32_t> batch_begin_;
  int drawing_ = 0;
  std::int64_t visible_ = 0;
};

}  // namespace sightline::apps
