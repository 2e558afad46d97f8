# Embeds shader files into a target as strings, at build time, with CMake only.
#
# sightline_embed_shaders(TARGET NAMESPACE HEADER HEADER_PATH FILES shaders/a.glsl …)
#   adds to TARGET a generated source that defines, in NAMESPACE (such as sightline::gpuprims),
#     std::span<const std::pair<std::string_view, std::string_view>> shaders();
#   the name (without folder) and text of each file, in the order given. HEADER_PATH ("sightline/gpuprims/internal/shaders.h") is
#   the hand-written header that declares it. The next build embeds a changed file again.

# ---- The build step: cmake -DOUTPUT= -DNAMESPACE= -DHEADER= -DFILES=a|b -P EmbedShaders.cmake
if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  cmake_minimum_required(VERSION 3.25)
  set(delimiter "sightline_glsl")
  string(REPLACE "|" ";" files "${FILES}")
  set(entries "")
  foreach(path IN LISTS files)
    get_filename_component(name "${path}" NAME)
    file(READ "${path}" text)
    if(text MATCHES "\\)${delimiter}\"")
      message(FATAL_ERROR "${path}: holds the raw string delimiter )${delimiter}\"")
    endif()
    string(APPEND entries "    {\"${name}\", R\"${delimiter}(${text})${delimiter}\"},\n")
  endforeach()
  list(LENGTH files count)
  file(WRITE "${OUTPUT}" "// Generated from shader files: edit those.
#include \"${HEADER}\"

#include <array>
#include <span>
#include <string_view>
#include <utility>

namespace ${NAMESPACE} {
namespace {
constexpr std::array<std::pair<std::string_view, std::string_view>, ${count}> kShaders{{
${entries}}};
}  // namespace

std::span<const std::pair<std::string_view, std::string_view>> shaders() { return kShaders; }

}  // namespace ${NAMESPACE}
")
  return()
endif()

include_guard(GLOBAL)

function(sightline_embed_shaders target namespace)
  cmake_parse_arguments(arg "" "HEADER" "FILES" ${ARGN})
  if(NOT arg_HEADER OR NOT arg_FILES)
    message(FATAL_ERROR "sightline_embed_shaders(${target}): HEADER and FILES are required")
  endif()
  set(paths "")
  set(names "")
  foreach(file IN LISTS arg_FILES)
    get_filename_component(path "${file}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
    get_filename_component(name "${path}" NAME)
    if(name IN_LIST names)
      message(FATAL_ERROR "sightline_embed_shaders(${target}): two files are named ${name}")
    endif()
    list(APPEND paths "${path}")
    list(APPEND names "${name}")
  endforeach()
  set(script "${CMAKE_CURRENT_FUNCTION_LIST_FILE}")
  set(output "${CMAKE_CURRENT_BINARY_DIR}/${target}_shaders.cpp")
  string(REPLACE ";" "|" joined "${paths}")
  add_custom_command(
    OUTPUT "${output}"
    COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${output}" "-DNAMESPACE=${namespace}" "-DHEADER=${arg_HEADER}"
            "-DFILES=${joined}" -P "${script}"
    DEPENDS ${paths} "${script}"
    COMMENT "Embedding the shaders of ${target}"
    VERBATIM)
  target_sources(${target} PRIVATE "${output}")
endfunction()
