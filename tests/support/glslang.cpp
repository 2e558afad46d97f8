#include "sightline/tests/support/glslang.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <iostream>
#include <list>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <gtest/gtest.h>
#include <spirv-tools/libspirv.hpp>

namespace sightline::tests {
namespace {

constexpr EShMessages kMessages = EShMsgSpvRules;

EShLanguage language_of(GLenum stage) {
  switch (stage) {
    case GL_VERTEX_SHADER:
      return EShLangVertex;
    case GL_GEOMETRY_SHADER:
      return EShLangGeometry;
    case GL_FRAGMENT_SHADER:
      return EShLangFragment;
    default:
      return EShLangCompute;
  }
}

/// Texts of stages, each once. Threads may share one.
class Texts {
 public:
  /// False if it was there.
  bool add(const std::string& text) {
    const std::scoped_lock lock(mutex_);
    return texts_.insert(text).second;
  }
  std::size_t size() const { return texts_.size(); }

 private:
  std::mutex mutex_;
  std::set<std::string> texts_;
};

struct Stage {
  Stage(EShLanguage language, gl::StageSource from) : source(std::move(from)), shader(language) {
    shader.setEnvInput(glslang::EShSourceGlsl, language, glslang::EShClientOpenGL, 100);
    shader.setEnvClient(glslang::EShClientOpenGL, glslang::EShTargetOpenGL_450);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_0);
    text = source.text.c_str();
    shader.setStrings(&text, 1);
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  std::string compile() {
    const bool good = shader.parse(GetDefaultResources(), 450, false, kMessages);
    const std::string says = gl::name_files_in_log(shader.getInfoLog(), source.files);
    return good || !says.empty() ? says : "glslang refuses it and does not say why";
  }

  gl::StageSource source;
  const char* text = nullptr;
  glslang::TShader shader;
};

std::string validate(const glslang::TIntermediate& linked) {
  std::string says;
  std::vector<std::uint32_t> words;
  spv::SpvBuildLogger logger;
  glslang::GlslangToSpv(linked, words, &logger);
  spvtools::SpirvTools tools(SPV_ENV_OPENGL_4_5);
  tools.SetMessageConsumer([&](spv_message_level_t, const char*, const spv_position_t&, const char* message) {
    says += std::string("SPIR-V: ") + message + "\n";
  });
  if (!tools.Validate(words) && says.empty()) says = "SPIR-V: not valid\n";
  return logger.getAllMessages() + says;
}

/// Texts that are in `validated` are compiled and linked, but not translated again.
std::string complaint(const gl::PipelineDescription& pipeline, Texts& validated) {
  static const bool initialised = glslang::InitializeProcess();
  if (!initialised) return "glslang does not start";
  std::list<Stage> stages;    // first: the program borrows them
  glslang::TProgram program;  // of all stages
  std::string says;
  for (const gl::ProgramDescription& part : pipeline) {
    for (const gl::StageDescription& stage : part.stages) {
      auto source = gl::assemble_stage(part.shaders, stage.files);
      if (!source) return source.error().message;
      Stage& compiled = stages.emplace_back(language_of(stage.stage), std::move(*source));
      says += compiled.compile();
      program.addShader(&compiled.shader);
    }
  }
  if (!says.empty()) return says;
  const bool linked = program.link(kMessages);
  says = program.getInfoLog();
  if (!linked || !says.empty()) return says + "does not link";
  for (const Stage& stage : stages)
    if (validated.add(stage.source.text)) says += validate(*program.getIntermediate(stage.shader.getStage()));
  return says;
}

std::string name_of(const gl::PipelineDescription& pipeline) {
  std::string name;
  for (const gl::ProgramDescription& program : pipeline) {
    name += (name.empty() ? "'" : " with '") + program.name + "' (";
    for (const std::string& define : program.shaders.defines) name += (name.back() == '(' ? "" : ", ") + define;
    name += ")";
  }
  return name;
}

}  // namespace

std::string glslang_complaint(const gl::PipelineDescription& pipeline) {
  Texts validated;
  return complaint(pipeline, validated);
}

void expect_valid(std::span<const gl::PipelineDescription> pipelines) {
  Texts validated;
  std::vector<std::string> complaints(pipelines.size());
  std::atomic<std::size_t> next = 0;
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
    threads.emplace_back([&] {
      for (std::size_t p = next++; p < pipelines.size(); p = next++) complaints[p] = complaint(pipelines[p], validated);
    });
  for (std::thread& thread : threads) thread.join();
  std::map<std::string, std::vector<std::size_t>> alike;
  for (std::size_t p = 0; p < pipelines.size(); ++p)
    if (!complaints[p].empty()) alike[complaints[p]].push_back(p);
  for (const auto& [says, by] : alike)
    ADD_FAILURE() << by.size() << " pipelines, the first of them " << name_of(pipelines[by.front()]) << ":\n" << says;
  std::cout << pipelines.size() << " pipelines of " << validated.size() << " texts\n";
}

}  // namespace sightline::tests
