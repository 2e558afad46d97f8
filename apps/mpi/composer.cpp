#include "sightline/apps/mpi/composer.h"

#include <limits>

#include <mpi.h>

#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gpuprims/internal/view_block.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {
namespace {

/// For MPI, which calls it with any parts of the images, in any order and grouping.
void compose_fragments(void* more, void* into, int* count, MPI_Datatype*) {
  const auto size = std::size_t(*count);
  compose({static_cast<const Fragment*>(more), size}, {static_cast<Fragment*>(into), size});
}

}  // namespace

struct Composer::State {
  MPI_Datatype fragment = MPI_DATATYPE_NULL;
  MPI_Op nearest = MPI_OP_NULL;

  State() {
    MPI_Type_contiguous(int(sizeof(Fragment)), MPI_BYTE, &fragment);
    MPI_Type_commit(&fragment);
    MPI_Op_create(compose_fragments, 1, &nearest);
  }
  ~State() {
    MPI_Op_free(&nearest);
    MPI_Type_free(&fragment);
  }
};

Composer::Composer(const MpiSession& session) : session_(session), state_(std::make_unique<State>()) {}
Composer::~Composer() = default;

/// Where an item stands among all in the order in which one process draws them: by batch, then by record.
std::uint32_t Composer::order_of(const core::Snapshot& snapshot, core::ItemId item) {
  if (batch_begin_.empty()) {
    std::array<std::uint32_t, gpuscene::kBatchKindCount> counts{};
    for (int kind = 0; kind < core::kKindCount; ++kind)
      counts[std::size_t(gpuscene::batch_of(core::Kind(kind)))] +=
          std::uint32_t(snapshot.of_kind(core::Kind(kind)).size());
    std::uint32_t begin = 0;
    for (const std::uint32_t count : counts) {
      batch_begin_.push_back(begin);
      begin += count;
    }
  }
  const core::Slot slot = snapshot.slot(item);
  return batch_begin_[std::size_t(gpuscene::batch_of(snapshot.kind(slot)))] +
         gpuscene::GpuScene::record_of(snapshot, slot);
}

core::Expected<std::vector<Fragment>> Composer::fragments(engine::Engine& engine) {
  const auto colours = engine.read_colour();
  if (!colours) return tl::unexpected(colours.error());
  const auto ids = engine.read_ids();
  if (!ids) return tl::unexpected(ids.error());
  const auto depths = engine::EngineParts::reversed_depths(engine);
  if (!depths) return tl::unexpected(depths.error());
  std::vector<Fragment> out(depths->metres.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint8_t* rgb = &colours->pixels[3 * i];
    out[i] = {depths->metres[i], 0xffffffff, ids->ids[i], std::uint32_t(rgb[0] | rgb[1] << 8 | rgb[2] << 16)};
    if (out[i].id != 0) out[i].order = order_of(engine.snapshot(), core::ItemId{out[i].id - 1});
  }
  return out;
}

std::vector<double> Composer::gather(double own) const {
  std::vector<double> all(session_.rank() == 0 ? std::size_t(session_.size()) : 0);
  MPI_Gather(&own, 1, MPI_DOUBLE, all.data(), 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  return all;
}

core::Expected<ReadImage> Composer::read(engine::Engine& engine, const core::View& whole,
                                         const core::Expected<engine::FrameReport>& drawn) {
  const bool draws = drawn && drawn->visible != 0;
  core::Expected<std::vector<Fragment>> own;
  if (!drawn)
    own = tl::unexpected(drawn.error());
  else if (draws || session_.rank() == 0)
    own = fragments(engine);
  own = session_.agreed(std::move(own));
  if (!own) return tl::unexpected(own.error());
  const int width = engine.config().width, height = engine.config().height;
  const std::int64_t counts[2] = {draws ? 1 : 0, std::max<std::int64_t>(drawn->visible, 0)};
  std::int64_t sums[2] = {};
  MPI_Allreduce(counts, sums, 2, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  drawing_ = int(sums[0]);
  visible_ = sums[1];
  // Rank 0 stays in, though it may draw nothing: it gets the image.
  const bool takes_part = draws || session_.rank() == 0;
  MPI_Comm those = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, takes_part ? 0 : MPI_UNDEFINED, session_.rank(), &those);
  if (takes_part) {
    const bool root = session_.rank() == 0;
    MPI_Reduce(root ? MPI_IN_PLACE : own->data(), root ? own->data() : nullptr, int(own->size()), state_->fragment,
               state_->nearest, 0, those);
    MPI_Comm_free(&those);
  }
  own->resize(std::size_t(width) * std::size_t(height));
  ReadImage out;
  out.colours = {width, height, std::vector<std::uint8_t>(3 * own->size())};
  out.ids = {width, height, std::vector<std::uint32_t>(own->size())};
  out.depth = {width, height, std::vector<float>(own->size(), std::numeric_limits<float>::infinity())};
  const core::dmat4 clip = gpuprims::reversed_clip_from_eye(whole);
  for (std::size_t i = 0; i < own->size(); ++i) {
    const Fragment& f = (*own)[i];
    for (int c = 0; c < 3; ++c) out.colours.pixels[3 * i + std::size_t(c)] = std::uint8_t(f.colour >> 8 * c);
    out.ids.ids[i] = f.id;
    if (f.depth == 0.0f) continue;
    out.depth.metres[i] = float(gpuprims::eye_depth(clip, f.depth));
    out.covered = true;
  }
  return out;
}

}  // namespace sightline::apps
