// The variant in compute shaders: three steps with barriers between them.
//   test    per batch, one work group per block of 32 clusters: a mask of visible records for each place in a cluster
//   sum     one work group: where the visible records of each mask go, and how many there are of each batch
//   write   per batch, one work group per block: the records
// The order is that in which the geometry variant draws its instances: first of all clusters, second of all clusters, …
// Parts of meshes, where there are any, are tested and written in the same way, behind the records of meshes.
//
// The numbers of items go to the CPU through a small buffer that stays mapped, two words per probe, guarded by a fence
// that is polled without waiting.
#include <algorithm>

#include "sightline/core/internal/store.h"
#include "sightline/culling/gpu/internal/gpu_pass.h"

namespace sightline::culling {
namespace {

using gpuscene::BatchKind;
using gpuscene::DrawLists;
using gpuscene::ElementsCommand;
using gpuscene::kBatchKindCount;

constexpr int kScanInvocations = 256;
enum StorageBinding : GLuint { kMasks, kPlaces, kCounts, kCommands, kResults, kFound = kCounts };
constexpr GLint kSectionsUniform = 0, kFirstPlaceUniform = kBatchKindCount,
                kRecordCommandsUniform = 2 * kBatchKindCount + 1, kResultUniform = 2 * kBatchKindCount + 2,
                kFirstPartPlaceUniform = 2 * kBatchKindCount + 3;
constexpr GLint kBatchUniform = 0, kFirstWordUniform = 1, kTestResultUniform = 2;
constexpr std::size_t kProbeBytes = 2 * sizeof(std::uint32_t);

std::uint32_t blocks_of(std::uint32_t clusters) {
  return (clusters + kClustersPerBlock - 1) / kClustersPerBlock;
}

struct DeleteFence {
  const gl::Functions* gl = nullptr;
  void operator()(GLsync fence) const { gl->DeleteSync(fence); }
};
using Fence = std::unique_ptr<std::remove_pointer_t<GLsync>, DeleteFence>;

gl::ProgramDescription describe_test(bool parts, Selection selection) {
  return describe_pass("cull: test", {{GL_COMPUTE_SHADER, {"test_blocks.comp"}}},
                       parts ? ProgramKind::kParts : ProgramKind::kRecords, selection);
}

gl::ProgramDescription describe_sum() {
  auto sum = describe_pass("cull: sum", {{GL_COMPUTE_SHADER, {"sum_places.comp"}}}, ProgramKind::kRecords);
  sum.shaders.defines.push_back("SCAN_INVOCATIONS " + std::to_string(kScanInvocations));
  return sum;
}

gl::ProgramDescription describe_write(ProgramKind kind) {
  return describe_pass("cull: write", {{GL_COMPUTE_SHADER, {"write_blocks.comp"}}}, kind);
}

class ComputePass : public GpuPass {
 public:
  explicit ComputePass(const gl::Context& context)
      : gl_(&context.functions()),
        largest_block_(std::size_t(context.capabilities().max_storage_block_bytes)),
        alignment_(std::size_t(context.capabilities().storage_offset_alignment)) {}

  core::Expected<void> prepare(std::span<const CullBatch> batches, Selection selection) override {
    auto done = fit(batches);
    if (done && sum_.id() == 0) done = make_sum();
    if (done) done = write_.make(*gl_, batches, describe_write);
    for (const CullBatch& batch : batches) {
      gl::Program& test = test_of(batch, selection);
      if (done && test.id() == 0)
        done = core::store(gl::Program::create(*gl_, describe_test(batch.parts != nullptr, selection)), test);
    }
    return done;
  }

  core::Expected<void> make_sum() { return core::store(gl::Program::create(*gl_, describe_sum()), sum_); }

  core::Expected<void> make_results() {
    constexpr GLbitfield kAccess = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    auto buffer = gl::Buffer::create(*gl_, kProbes * kProbeBytes, nullptr, kAccess, "visible sums");
    if (!buffer) return tl::unexpected(buffer.error());
    results_ = std::move(*buffer);
    mapped_ = static_cast<const volatile std::uint32_t*>(results_.map(0, results_.size(), kAccess));
    if (!mapped_) return core::fail("GL buffer 'visible sums': the driver does not map it");
    return {};
  }

  core::Expected<void> fit(std::span<const CullBatch> batches) {
    std::size_t blocks = 0, target = 0;
    for (const CullBatch& batch : batches) {
      blocks += blocks_of(batch.bounds.cluster_capacity());
      const std::size_t record = batch.meshes() ? sizeof(ElementsCommand) : sizeof(std::uint32_t);
      const std::size_t parts = batch.parts ? batch.parts->cluster_capacity() : 0;
      blocks += blocks_of(std::uint32_t(parts));
      target = std::max(target, (batch.bounds.cluster_capacity() + parts) * kItemsPerCluster * record);
    }
    const std::size_t words = blocks * kItemsPerCluster, most = std::max(target, (words + 1) * sizeof(std::uint32_t));
    if (places_.size() >= (words + 1) * sizeof(std::uint32_t)) return {};
    if (most + alignment_ > largest_block_)
      return core::fail("culling in compute shaders wants storage blocks of " + std::to_string(most + alignment_) +
                        " bytes, and the context's limit is " + std::to_string(largest_block_) +
                        "; the geometry variant does without");
    const auto make = [&](gl::Buffer& out, std::size_t count, const char* what) -> core::Expected<void> {
      return core::store(gl::Buffer::create(*gl_, count * sizeof(std::uint32_t), nullptr, 0, what), out);
    };
    auto done = make(masks_, std::max<std::size_t>(1, words), "visible masks");
    if (done) done = make(places_, words + 1, "visible places");
    return done;
  }

  GpuVariant variant() const override { return GpuVariant::kCompute; }
  DrawLists::Counting counting() const override { return DrawLists::Counting::kCuller; }

  void run(std::span<const CullBatch> batches, const DrawLists& lists, Selection selection,
           std::size_t probe) override {
    lay_out(batches);
    if (selection != Selection::kUnoccludedNow) {
      counts_in_view_[probe] = counts_in_view(selection);
      results_.fill(probe * kProbeBytes, kProbeBytes, 0);
    }
    bind(kMasks, masks_);
    bind(kPlaces, places_);
    bind(kResults, results_);
    const auto for_each_list = [&](const auto& visit) {
      for (const CullBatch& batch : batches) {
        visit(CullList{batch, false});
        if (batch.parts) visit(CullList{batch, true});
      }
    };
    for_each_list([&](const CullList& list) {
      const gl::Program& test = test_of(list.batch, selection);
      if (counts_in_view(selection) || list.batch.parts)
        gl_->ProgramUniform1ui(test.id(), kTestResultUniform, GLuint(probe));
      bind_selection(*gl_, test, list, selection);
      dispatch(test, list);
    });
    gl_->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    sum(lists, probe);
    gl_->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    for_each_list([&](const CullList& list) { write(list, lists); });
    gl_->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                       GL_BUFFER_UPDATE_BARRIER_BIT | GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
    fences_[probe] = Fence(gl_->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0), DeleteFence{gl_});
  }

  std::optional<Found> found(std::size_t probe) override {
    const GLenum state = fences_[probe] ? gl_->ClientWaitSync(fences_[probe].get(), GL_SYNC_FLUSH_COMMANDS_BIT, 0)
                                        : GLenum(GL_WAIT_FAILED);  // the driver has made none
    if (state == GL_TIMEOUT_EXPIRED) return std::nullopt;
    if (state == GL_WAIT_FAILED) gl_->Finish();  // else this result, and all after it, would never be known
    const std::uint32_t in_view = mapped_[2 * probe], written = mapped_[2 * probe + 1];
    return Found{counts_in_view_[probe] ? in_view : written, written};
  }

  std::size_t memory_bytes() const override { return masks_.size() + places_.size() + results_.size(); }

 private:
  /// Assigns the blocks in use to batches, without gaps. Those of parts, if any, come last, as meshes do.
  void lay_out(std::span<const CullBatch> batches) {
    std::uint32_t of_parts = 0;
    first_block_ = {};
    for (const CullBatch& batch : batches) {
      first_block_[std::size_t(batch.kind) + 1] = blocks_of(batch.bounds.cluster_count());
      if (batch.parts) of_parts = blocks_of(batch.parts->cluster_count());
    }
    for (std::size_t kind = 0; kind < kBatchKindCount; ++kind) first_block_[kind + 1] += first_block_[kind];
    first_part_block_ = first_block_[kBatchKindCount];
    first_block_[kBatchKindCount] += of_parts;
  }

  gl::Program& test_of(const CullBatch& batch, Selection selection) {
    return test_[batch.parts != nullptr][std::size_t(selection)];
  }

  void bind(GLuint binding, const gl::Buffer& buffer) const {
    gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.id());
  }

  void dispatch(const gl::Program& program, const CullList& list) const {
    const std::uint32_t clusters = list.cluster_count(), blocks = blocks_of(clusters);
    const std::uint32_t of_batch = first_block_[std::size_t(list.batch.kind)];
    program.use();
    gl_->ProgramUniform4ui(program.id(), kBatchUniform, clusters, blocks, list.parts ? first_part_block_ : of_batch,
                           of_batch);
    bind_list(*gl_, program, list);
    gl_->DispatchCompute(blocks, 1, 1);
  }

  void sum(const DrawLists& lists, std::size_t probe) const {
    sum_.use();
    const GLuint id = sum_.id();
    std::array<std::uint32_t, kBatchKindCount + 1> first_place = first_block_;
    for (std::uint32_t& place : first_place) place *= kItemsPerCluster;
    gl_->ProgramUniform4uiv(id, kSectionsUniform, kBatchKindCount, lists.gpu_sections()[0].data());
    gl_->ProgramUniform1uiv(id, kFirstPlaceUniform, GLsizei(first_place.size()), first_place.data());
    gl_->ProgramUniform1ui(id, kRecordCommandsUniform, GLuint(lists.record_command_count()));
    gl_->ProgramUniform1ui(id, kResultUniform, GLuint(probe));
    gl_->ProgramUniform1ui(id, kFirstPartPlaceUniform, first_part_block_ * kItemsPerCluster);
    bind(kCounts, lists.counts());
    gl_->BindBufferRange(GL_SHADER_STORAGE_BUFFER, kCommands, lists.commands().id(), 0,
                         GLsizeiptr(std::max<std::size_t>(1, lists.record_command_count()) * sizeof(ElementsCommand)));
    gl_->DispatchCompute(1, 1, 1);
  }

  void write(const CullList& list, const DrawLists& lists) const {
    const gl::Program& program = write_.of(list.batch);
    const DrawLists::Target target = lists.target(list.batch.kind);
    const std::size_t rest = target.offset % alignment_;
    gl_->BindBufferRange(GL_SHADER_STORAGE_BUFFER, kFound, target.buffer, GLintptr(target.offset - rest),
                         GLsizeiptr(target.size + rest));
    gl_->ProgramUniform1ui(program.id(), kFirstWordUniform, GLuint(rest / sizeof(std::uint32_t)));
    dispatch(program, list);
  }

  const gl::Functions* gl_;
  std::size_t largest_block_, alignment_;                         // bytes
  std::array<std::array<gl::Program, kSelectionCount>, 2> test_;  // of batches with parts the second ones
  BatchPrograms write_;
  gl::Program sum_;
  gl::Buffer masks_, places_, results_;
  const volatile std::uint32_t* mapped_ = nullptr;
  std::array<std::uint32_t, kBatchKindCount + 1> first_block_{};  // by batch kind
  std::uint32_t first_part_block_ = 0;                            // after all of records
  std::array<Fence, kProbes> fences_;
  std::array<bool, kProbes> counts_in_view_{};
};

}  // namespace

std::vector<gl::PipelineDescription> compute_programs() {
  std::vector<gl::PipelineDescription> all = {{describe_sum()}};
  for (std::size_t kind = 0; kind < kProgramKinds; ++kind) all.push_back({describe_write(ProgramKind(kind))});
  for (const bool parts : {false, true})
    for (std::size_t selection = 0; selection < kSelectionCount; ++selection)
      all.push_back({describe_test(parts, Selection(selection))});
  return all;
}

core::Expected<std::unique_ptr<GpuPass>> make_compute_pass(const gl::Context& context,
                                                           std::span<const CullBatch> batches) {
  auto pass = std::make_unique<ComputePass>(context);
  auto done = pass->fit(batches);  // first, since it may fail
  if (done) done = pass->make_results();
  if (!done) return tl::unexpected(done.error());
  return pass;
}

}  // namespace sightline::culling
