#include "sightline/gpuscene/element_writer.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "sightline/gpuscene/shaders.h"

namespace sightline::gpuscene {
namespace {

constexpr GLuint kInvocations = 256, kMostGroups = 4096;
enum StorageBinding : GLuint { kSource, kTarget };
enum Uniform : GLint { kElementsUniform, kWordsUniform };

/// One past the last of the neighbours from `first` on.
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

}  // namespace

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
  std::vector<std::byte> source(places.size_bytes() + elements * bytes);
  if (std::max(buffer.size(), source.size()) > largest_block_) return false;
  std::memcpy(source.data(), places.data(), places.size_bytes());
  std::memcpy(source.data() + places.size_bytes(), data, elements * bytes);
  auto uploaded = gl::Buffer::create(*gl_, std::span(source), 0, "elements to write");
  if (!uploaded) return false;
  if (program_.id() == 0) {
    gl::ProgramDescription description;
    description.name = "write elements";
    description.stages = {{GL_COMPUTE_SHADER, {"write_elements.comp"}}};
    description.shaders.tables = {shaders()};
    description.shaders.defines = {"INVOCATIONS " + std::to_string(kInvocations)};
    auto program = gl::Program::create(*gl_, description);
    if (!program) return false;
    program_ = std::move(*program);
  }
  const std::size_t words = bytes / sizeof(std::uint32_t);
  gl_->ProgramUniform1ui(program_.id(), kElementsUniform, GLuint(elements));
  gl_->ProgramUniform1ui(program_.id(), kWordsUniform, GLuint(words));
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, kSource, uploaded->id());
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, kTarget, buffer.id());
  program_.use();
  const std::size_t groups = (elements * words + kInvocations - 1) / kInvocations;
  gl_->DispatchCompute(GLuint(std::min<std::size_t>(groups, kMostGroups)), 1, 1);
  gl_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT |
                     GL_BUFFER_UPDATE_BARRIER_BIT);
  return true;
}

}  // namespace sightline::gpuscene
