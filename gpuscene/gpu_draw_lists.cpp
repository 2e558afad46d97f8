// Draw lists that a culler on the GPU fills.
//
// Unless the culler counts, a binary search for the first unused place finds how many records it has written. It runs
// in vertex stages and writes its result through transform feedback. Two other ways give the same number but are slow
// on Mesa's llvmpipe: a query written into a buffer waits until the frame before is drawn, and so does the memory
// barrier after a compute shader (12 ms of a frame of 73 ms).
#include <algorithm>
#include <cassert>

#include "sightline/core/internal/store.h"
#include "sightline/gl/internal/pipeline_state.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/gpuscene/internal/record_commands.h"
#include "sightline/gpuscene/internal/shaders.h"

namespace sightline::gpuscene {
namespace {

enum TextureUnit : GLuint { kRecordUnit, kCommandUnit };
constexpr GLint kSectionsUniform = 0;

/// Words of DrawLists::GpuSections.
enum SectionWord { kFirstCommand, kFirstSingle, kPlaces, kIndicesPerRecord };

/// Places for commands or records that a culler finds.
std::size_t places_of(const Batch& batch, std::size_t parts) {
  return batch.capacity + (batch.kind == BatchKind::kMesh ? parts : 0);
}

gl::ProgramDescription describe_search(const char* vertex, std::vector<std::string> varyings) {
  gl::ProgramDescription description;
  description.name = vertex;
  description.stages = {{GL_VERTEX_SHADER, {vertex}}};
  description.shaders = DrawLists::shader_context();
  description.feedback_varyings = std::move(varyings);
  return description;
}

gl::ProgramDescription describe_count() {
  return describe_search("count_records.vert", {"command_count", "record_count"});
}

gl::ProgramDescription describe_write() {
  return describe_search("write_commands.vert", {"index_count", "gl_SkipComponents4"});
}

core::Expected<void> make_view(const gl::Functions& gl, const gl::Buffer& buffer, const char* what,
                               gl::TextureBuffer& out) {
  return core::store(gl::TextureBuffer::create(gl, buffer, GL_R32UI, what), out);
}

}  // namespace

gl::ShaderContext DrawLists::shader_context() {
  gl::ShaderContext context;
  context.tables = {shaders()};
  context.defines = {"BATCH_KINDS " + std::to_string(kBatchKindCount),
                     "MESH_KIND " + std::to_string(int(BatchKind::kMesh)) + "u",
                     "RECORDS_PER_COMMAND " + std::to_string(kRecordsPerCommand) + "u",
                     "COMMAND_WORDS " + std::to_string(sizeof(ElementsCommand) / sizeof(std::uint32_t)) + "u"};
  return context;
}

core::Expected<void> DrawLists::make_gpu_lists(const GpuScene& scene, std::size_t parts) {
  GpuLists lists;
  lists.parts = parts;
  std::size_t commands = 0, singles = 0;
  const auto place = [&](const Batch& batch) {
    const std::size_t kind = std::size_t(batch.kind);
    const bool meshes = batch.kind == BatchKind::kMesh;
    const std::size_t places = places_of(batch, parts);
    lists.sections[kind] = {std::uint32_t(commands), std::uint32_t(singles), std::uint32_t(places),
                            meshes ? 0 : record_form(batch.kind, gl_->workarounds).indices};
    lists.command_count[kind] = meshes ? places : (places + kRecordsPerCommand - 1) / kRecordsPerCommand;
    commands += lists.command_count[kind];
    if (!meshes) singles += batch.capacity;
  };
  for (const Batch& batch : scene.batches())
    if (batch.kind != BatchKind::kMesh) place(batch);
  lists.record_commands = commands;
  if (const Batch* meshes = scene.batch(BatchKind::kMesh)) place(*meshes);

  const auto make = [&](gl::Buffer& out, std::size_t bytes, const char* what) -> core::Expected<void> {
    return core::store(gl::Buffer::create(*gl_, bytes, nullptr, GL_DYNAMIC_STORAGE_BIT, what), out);
  };
  auto done = make(lists.commands, std::max<std::size_t>(1, commands) * sizeof(ElementsCommand), "GPU's draw commands");
  if (done)
    done = make(lists.singles, std::max<std::size_t>(1, singles) * sizeof(std::uint32_t), "GPU's visible records");
  if (done) done = make(lists.counts, 2 * kBatchKindCount * sizeof(std::uint32_t), "GPU's visible counts");
  if (done) done = make_view(*gl_, lists.singles, "GPU's visible records", lists.single_texels);
  if (!done) return done;
  lists.write_commands = std::move(gpu_.write_commands);
  lists.count_records = std::move(gpu_.count_records);
  gpu_ = std::move(lists);
  write_gpu_templates(scene);
  return {};
}

std::vector<gl::PipelineDescription> DrawLists::all_programs() {
  return {{describe_count()}, {describe_write()}};
}

core::Expected<void> DrawLists::make_search_programs() {
  auto programs = gl::Program::create_all(*gl_, std::array{describe_count(), describe_write()});
  if (!programs) return tl::unexpected(programs.error());
  gpu_.count_records = std::move((*programs)[0]);
  gpu_.write_commands = std::move((*programs)[1]);
  return {};
}

/// What the search needs of the lists. The view of the commands comes last: it tells that all is there.
core::Expected<void> DrawLists::make_search() {
  core::Expected<void> done;
  if (gpu_.write_commands.id() == 0) done = make_search_programs();
  if (!done) return done;
  for (const gl::Program* program : {&gpu_.write_commands, &gpu_.count_records})
    gl_->ProgramUniform4uiv(program->id(), kSectionsUniform, kBatchKindCount, gpu_.sections[0].data());
  gpu_.array = gl::VertexArray(*gl_);
  gpu_.command_feedback = gl::TransformFeedback(*gl_);
  gpu_.count_feedback = gl::TransformFeedback(*gl_);
  done = gl::check_names(*gl_, {gpu_.array.id(), gpu_.command_feedback.id(), gpu_.count_feedback.id()},
                         "objects for the search of visible records");
  if (!done) return done;
  gpu_.command_feedback.set_buffer(gpu_.commands.id(), 0, gpu_.commands.size());
  gpu_.count_feedback.set_buffer(gpu_.counts.id(), 0, gpu_.counts.size());
  return make_view(*gl_, gpu_.commands, "GPU's draw commands", gpu_.command_texels);
}

/// Writes the parts of record batches' commands that the GPU does not change.
void DrawLists::write_gpu_templates(const GpuScene& scene) {
  std::vector<ElementsCommand> commands(gpu_.record_commands);
  for (const Batch& batch : scene.batches()) {
    const std::size_t kind = std::size_t(batch.kind);
    gpu_.records[kind] = batch.count;
    if (batch.kind == BatchKind::kMesh) continue;
    const RecordForm form = record_form(batch.kind, gl_->workarounds);
    const auto& section = gpu_.sections[kind];
    for (std::size_t i = 0; i < gpu_.command_count[kind]; ++i) {
      const std::size_t record = batch.count + section[kFirstSingle] + i * kRecordsPerCommand;
      commands[section[kFirstCommand] + i] = {0, 1, form.first_index, std::int32_t(record * form.vertices), 0};
    }
  }
  gpu_.commands.write(0, commands.size() * sizeof(ElementsCommand), commands.data());
}

core::Expected<void> DrawLists::begin_gpu_update(const GpuScene& scene, Counting counting, std::size_t parts) {
  sections_ = {};
  from_gpu_ = true;
  counting_ = counting;
  if (gpu_.counts.id() == 0 || parts > gpu_.parts)
    if (auto done = make_gpu_lists(scene, parts); !done) return done;
  const bool search = counting == Counting::kSearch;
  if (search && gpu_.command_texels.id() == 0)
    if (auto done = make_search(); !done) return done;
  bool grown = false;
  for (const Batch& batch : scene.batches()) grown |= gpu_.records[std::size_t(batch.kind)] != batch.count;
  if (grown) write_gpu_templates(scene);
  if (search && gpu_.record_commands > 0) gpu_.singles.fill(0, gpu_.singles.size(), 0xff);
  if (scene.batch(BatchKind::kMesh) && (search || !gl_->MultiDrawElementsIndirectCountARB)) {
    const Target meshes = target(BatchKind::kMesh);
    gpu_.commands.fill(meshes.offset, meshes.size, 0);  // commands that draw nothing
  }
  return {};
}

DrawLists::Target DrawLists::target(BatchKind kind) const {
  const auto& section = gpu_.sections[std::size_t(kind)];
  if (kind == BatchKind::kMesh)
    return {gpu_.commands.id(), section[kFirstCommand] * sizeof(ElementsCommand),
            section[kPlaces] * sizeof(ElementsCommand)};
  return {gpu_.singles.id(), section[kFirstSingle] * sizeof(std::uint32_t), section[kPlaces] * sizeof(std::uint32_t)};
}

void DrawLists::search() {
  const gl::Functions& gl = *gl_;
  gl.Enable(GL_RASTERIZER_DISCARD);
  gl.BindTextureUnit(kRecordUnit, gpu_.single_texels.id());
  gl.BindTextureUnit(kCommandUnit, gpu_.command_texels.id());
  gpu_.array.bind();
  gpu_.count_records.use();
  gpu_.count_feedback.begin_points();
  gl.DrawArrays(GL_POINTS, 0, kBatchKindCount);
  gpu_.count_feedback.end();
  // No program, here or in the culler, may read a buffer that is being written.
  gl::unbind_texture(gl, kCommandUnit, GL_TEXTURE_BUFFER);
  if (gpu_.record_commands > 0) {
    gpu_.write_commands.use();
    gpu_.command_feedback.begin_points();
    gl.DrawArrays(GL_POINTS, 0, GLsizei(gpu_.record_commands));
    gpu_.command_feedback.end();
  }
  gl.Disable(GL_RASTERIZER_DISCARD);
}

void DrawLists::end_gpu_update(const GpuScene& scene) {
  if (counting_ == Counting::kSearch) search();
  for (const Batch& batch : scene.batches()) {
    const std::size_t kind = std::size_t(batch.kind);
    assert(places_of(batch, gpu_.parts) == gpu_.sections[kind][kPlaces] && "draw lists are of another scene");
    sections_[kind] = {gpu_.sections[kind][kFirstCommand] * sizeof(ElementsCommand), int(gpu_.command_count[kind]),
                       gl_->MultiDrawElementsIndirectCountARB != nullptr};
  }
}

}  // namespace sightline::gpuscene
