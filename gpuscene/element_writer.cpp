#include "sightline/gpuscene/internal/element_writer.h"

#include <algorithm>
#include <string>

#include "sightline/gpuscene/internal/shaders.h"

namespace sightline::gpuscene {
namespace {

constexpr GLuint kInvocations = 256, kMostGroups = 4096;
enum StorageBinding : GLuint { kSourceBuffer, kTargetBuffer, kPlaceBuffer };
enum Uniform : GLint { kElementsUniform, kWordsUniform };

/// One past the end of the run of neighbours that begins at `first`.
std::size_t run_end(std::span<const std::uint32_t> places, std::size_t first) {
  std::size_t end = first + 1;
  while (end < places.size() && places[end] == places[end - 1] + 1) ++end;
  return end;
}

bool has_more_runs_than(std::size_t most, std::span<const std::uint32_t> places) {
  std::size_t runs = 0;
  for (std::size_t i = 0; i < places.size() && runs <= most; i = run_end(places, i)) ++runs;
  return runs > most;
}

gl::ProgramDescription describe_element_writer(bool wide) {
  gl::ProgramDescription description;
  description.name = "write elements";
  description.stages = {{GL_COMPUTE_SHADER, {"write_elements.comp"}}};
  description.shaders.tables = {shaders()};
  description.shaders.defines = {"INVOCATIONS " + std::to_string(kInvocations), wide ? "WORD uvec4" : "WORD uint"};
  return description;
}

}  // namespace

std::vector<gl::PipelineDescription> ElementWriter::all_programs() {
  return {{describe_element_writer(false)}, {describe_element_writer(true)}};
}

void ElementWriter::write(const gl::Buffer& buffer, std::size_t bytes, std::span<const std::uint32_t> places,
                          const void* data) {
  if (has_more_runs_than(kMostRuns, places) && scatter(buffer, bytes, places, data)) return;
  for (std::size_t i = 0; i < places.size();) {
    const std::size_t end = run_end(places, i);
    buffer.write(places[i] * bytes, (end - i) * bytes, static_cast<const std::byte*>(data) + i * bytes);
    i = end;
  }
}

bool ElementWriter::scatter(const gl::Buffer& buffer, std::size_t bytes, std::span<const std::uint32_t> places,
                            const void* data) {
  const std::size_t elements = places.size();
  const bool wide = bytes % sizeof(std::uint32_t[4]) == 0;
  const std::size_t words = bytes / (wide ? sizeof(std::uint32_t[4]) : sizeof(std::uint32_t));
  if (std::max(buffer.size(), elements * bytes) > largest_block_) return false;
  const gl::Program* program = prepare(wide);
  auto source = gl::Buffer::create(*gl_, elements * bytes, data, 0, "elements to write");
  auto to = gl::Buffer::create(*gl_, places, 0, "places of elements to write");
  if (!program || !source || !to) return false;
  gl_->ProgramUniform1ui(program->id(), kElementsUniform, GLuint(elements));
  gl_->ProgramUniform1ui(program->id(), kWordsUniform, GLuint(words));
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, kSourceBuffer, source->id());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, kTargetBuffer, buffer.id());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, kPlaceBuffer, to->id());
  program->use();
  const std::size_t groups = (elements * words + kInvocations - 1) / kInvocations;
  gl_->DispatchCompute(GLuint(std::min<std::size_t>(groups, kMostGroups)), 1, 1);
  gl_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT |
                     GL_BUFFER_UPDATE_BARRIER_BIT);
  return true;
}

const gl::Program* ElementWriter::prepare(bool wide) {
  gl::Program& program = programs_[wide];
  if (program.id() != 0) return &program;
  auto made = gl::Program::create(*gl_, describe_element_writer(wide));
  if (!made) return nullptr;
  program = std::move(*made);
  return &program;
}

}  // namespace sightline::gpuscene
