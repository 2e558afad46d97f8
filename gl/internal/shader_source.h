// Assembles the text of a shader stage from its files, and names the files in a driver's messages. No GL calls here.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/gl/workarounds.h"

namespace sightline::gl {

/// A shader file's name (without folder) and text, as sightline_embed_shaders() embeds them. A plain pair, so that
/// folders that do not use GL can hold shaders.
using ShaderFile = std::pair<std::string_view, std::string_view>;
using ShaderTable = std::span<const ShaderFile>;

/// Where to find files and what to put before them.
struct ShaderContext {
  std::vector<ShaderTable> tables;      ///< searched in order; the first file of a name wins
  std::vector<std::string> extensions;  ///< "GL_ARB_shader_draw_parameters", each required
  std::vector<std::string> defines;     ///< "NAME" or "NAME value"
};

/// Text ready for glShaderSource.
struct StageSource {
  std::string text;
  std::vector<std::string> files;  ///< indexed by the numbers in #line directives; 0 is the prolog
};

/// Concatenates `files` after "#version 450 core", the extensions and the defines, and replaces each line
///   #include "name.glsl"
/// by that file, once per stage: a second include of the same file is an empty line. #line directives keep the driver's
/// line numbers right. Fails on a file that no table has, on a cycle (with its chain), on a malformed #include and on a
/// file with a #version of its own; each names file and line. Comments are not parsed: an #include inside one counts.
core::Expected<StageSource> assemble_stage(const ShaderContext& context, std::span<const std::string> files);

/// Adds the defines and extensions by which shaders know of workarounds: PLAIN_DEPTH, ADD_BASE_VERTEX.
ShaderContext with_workarounds(ShaderContext context, Workarounds workarounds);

/// In a driver's log of such a stage, replaces "1:100012(3)" (Mesa) and "1(100012)" (NVIDIA) at the start of lines,
/// also after "ERROR: " or "WARNING: ", by "file.glsl:12".
std::string name_files_in_log(std::string_view log, std::span<const std::string> files);

}  // namespace sightline::gl
