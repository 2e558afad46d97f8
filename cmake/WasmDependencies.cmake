# Dependencies where Emscripten builds (CMAKE_PROJECT_TOP_LEVEL_INCLUDES of the wasm presets): headers of the
# distribution's packages, alone. Their folder also holds the C library of this machine, which must not be seen, so each
# is linked into a folder of the build tree.

set(SIGHTLINE_HEADERS ${CMAKE_BINARY_DIR}/headers)
file(MAKE_DIRECTORY ${SIGHTLINE_HEADERS})
foreach(header glm tl fmt nlohmann xxhash.h meshoptimizer.h)
  file(CREATE_LINK /usr/include/${header} ${SIGHTLINE_HEADERS}/${header} SYMBOLIC)
endforeach()
set(SIGHTLINE_XXHASH_INCLUDE ${SIGHTLINE_HEADERS} CACHE PATH "")

macro(sightline_provide_headers method name)
  set(target_of_glm glm::glm)
  set(target_of_tl-expected tl::expected)
  set(target_of_fmt fmt::fmt)
  set(target_of_nlohmann_json nlohmann_json::nlohmann_json)
  if(DEFINED target_of_${name})
    if(NOT TARGET ${target_of_${name}})
      add_library(${target_of_${name}} INTERFACE IMPORTED GLOBAL)
      target_include_directories(${target_of_${name}} SYSTEM INTERFACE ${SIGHTLINE_HEADERS})
      target_compile_definitions(${target_of_${name}} INTERFACE $<$<STREQUAL:${name},fmt>:FMT_HEADER_ONLY>)
    endif()
    set(${name}_FOUND TRUE)
  endif()
endmacro()
cmake_language(SET_DEPENDENCY_PROVIDER sightline_provide_headers SUPPORTED_METHODS FIND_PACKAGE)
