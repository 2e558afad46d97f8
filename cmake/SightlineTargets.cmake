# How a folder becomes a target, with the same flags everywhere.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# Includes read "sightline/core/scene.h" in the tree as after installation: the build tree holds a link to the sources.
set(SIGHTLINE_INCLUDE_ROOT ${CMAKE_BINARY_DIR}/include)
file(MAKE_DIRECTORY ${SIGHTLINE_INCLUDE_ROOT})
file(CREATE_LINK ${PROJECT_SOURCE_DIR} ${SIGHTLINE_INCLUDE_ROOT}/sightline SYMBOLIC)

add_library(sightline_flags INTERFACE)
target_include_directories(sightline_flags INTERFACE ${SIGHTLINE_INCLUDE_ROOT})
# -ffp-contract=off: the cullers promise one answer for every instruction set, and a fused multiply-add rounds differently.
target_compile_options(sightline_flags INTERFACE
  $<$<CXX_COMPILER_ID:GNU,Clang>:-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -ffp-contract=off>
  # g++ 12 drops the rounding of neighbouring double(float(x)) when it vectorises straight-line code; outward rounding and
  # chunk-relative placements depend on it. tests/core/conventions_test.cpp holds the case.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-fno-tree-slp-vectorize>
  # g++ 12 sees overlapping copies in std::string's own code (GCC bug 105651).
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<AND:$<BOOL:${SIGHTLINE_WARNINGS_AS_ERRORS}>,$<CXX_COMPILER_ID:GNU,Clang>>:-Werror>)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  set(SIGHTLINE_X86_KERNELS TRUE)
  target_compile_definitions(sightline_flags INTERFACE SIGHTLINE_X86_KERNELS)
  # What the wider forms of kernels may use, by the compiler's names. core/instruction_set.cpp asks the processor for
  # all of it.
  set(SIGHTLINE_AVX2_FEATURES avx2 fma bmi popcnt)
  set(SIGHTLINE_AVX512_FEATURES avx512f avx512bw avx512dq avx512vl fma bmi popcnt)
  foreach(form AVX2 AVX512)
    list(TRANSFORM SIGHTLINE_${form}_FEATURES REPLACE "(.+)" "SIGHTLINE_HAS(\\1)" OUTPUT_VARIABLE features)
    list(JOIN features "&&" features)
    target_compile_definitions(sightline_flags INTERFACE "SIGHTLINE_HAS_${form}=${features}")
  endforeach()
endif()
if(SIGHTLINE_SANITIZE)
  target_compile_options(sightline_flags INTERFACE -fsanitize=${SIGHTLINE_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=undefined)
  target_link_options(sightline_flags INTERFACE -fsanitize=${SIGHTLINE_SANITIZE})
endif()
if(SIGHTLINE_FUZZ)
  target_compile_options(sightline_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# sightline_library(NAME SOURCES … [LINKS …] [PRIVATE_LINKS …]): the library of folder NAME. LINKS are the arrows.
function(sightline_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(sightline_${name} STATIC ${arg_SOURCES})
  add_library(sightline::${name} ALIAS sightline_${name})
  target_link_libraries(sightline_${name} PUBLIC ${arg_LINKS} PRIVATE sightline_flags ${arg_PRIVATE_LINKS})
  target_include_directories(sightline_${name} PUBLIC ${SIGHTLINE_INCLUDE_ROOT})
endfunction()

# sightline_kernels(NAME AVX2 file AVX512 file): one binary for all processors. These files alone may use wider
# instructions; core/instruction_set.h says which the processor has.
function(sightline_kernels name)
  cmake_parse_arguments(arg "" "AVX2;AVX512" "" ${ARGN})
  if(SIGHTLINE_X86_KERNELS)
    target_sources(sightline_${name} PRIVATE ${arg_AVX2} ${arg_AVX512})
    foreach(form AVX2 AVX512)
      list(TRANSFORM SIGHTLINE_${form}_FEATURES PREPEND "-m" OUTPUT_VARIABLE options)
      set_source_files_properties(${arg_${form}} PROPERTIES COMPILE_OPTIONS "${options}")
    endforeach()
  endif()
endfunction()

# sightline_program(NAME SOURCES … LINKS …): an executable in bin/.
function(sightline_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINKS} sightline_flags)
endfunction()
