# Makes a folder a target, with the same flags everywhere: for the library's project, and those within its checkout.

get_filename_component(SIGHTLINE_CHECKOUT ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT EMSCRIPTEN)  # whose modules are never shared libraries
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
endif()
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_VERIFY_INTERFACE_HEADER_SETS ON)  # target all_verify_interface_header_sets: every public header compiles alone
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
# Batches of sources compile headers once. So file-local names of a target must differ, as if it were one file. What every
# script and CI build is also what CMake builds unless told otherwise; scripts/alone.py checks sources one by one.
option(SIGHTLINE_UNITY "Compile sources in batches: several times faster from scratch, slower after an edit" ON)
set(CMAKE_UNITY_BUILD ${SIGHTLINE_UNITY})
set(SIGHTLINE_UNITY_BATCH 16 CACHE STRING "Sources in a batch; 0: all sources of a target")
set(CMAKE_UNITY_BUILD_BATCH_SIZE ${SIGHTLINE_UNITY_BATCH})

# Writes a file that settings of engines are a part of: cmake/settings.py fills a template, whenever CMake runs.
function(sightline_fill_settings template file)
  set(script ${SIGHTLINE_CHECKOUT}/cmake/settings.py)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${script} ${template}
    ${SIGHTLINE_CHECKOUT}/engine/internal/settings.inc ${SIGHTLINE_CHECKOUT}/importers/internal/settings.inc)
  execute_process(COMMAND ${SIGHTLINE_PYTHON3} ${script} fill ${SIGHTLINE_CHECKOUT} ${template} ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Includes read "sightline/core/scene.h" in the tree as after installation. For that the build tree has one include root
# per folder, with a link to the sources of that folder only. So a target cannot include a folder that it does not link.
function(sightline_include_root result name folder)
  set(root ${PROJECT_BINARY_DIR}/include/${name})
  get_filename_component(parent ${root}/sightline/${folder} DIRECTORY)
  file(MAKE_DIRECTORY ${parent})
  file(CREATE_LINK ${SIGHTLINE_CHECKOUT}/${folder} ${root}/sightline/${folder} SYMBOLIC)
  set(${result} ${root} PARENT_SCOPE)
endfunction()

# Include roots of folders without a library: sightline_apps_headers and so on. Builds without GL have no library gl, and
# read from its folder the value of a framebuffer that they refuse to draw into.
foreach(folder apps gl tests)
  sightline_include_root(root ${folder} ${folder})
  add_library(sightline_${folder}_headers INTERFACE)
  target_include_directories(sightline_${folder}_headers INTERFACE ${root})
endforeach()

add_library(sightline_flags INTERFACE)
# -ffp-contract=off: the cullers promise one answer for every instruction set, and a fused multiply-add rounds differently.
target_compile_options(sightline_flags INTERFACE
  $<$<CXX_COMPILER_ID:GNU,Clang>:-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -ffp-contract=off>
  # Without OpenMP its pragmas mean nothing.
  $<$<AND:$<NOT:$<BOOL:${SIGHTLINE_OPENMP}>>,$<CXX_COMPILER_ID:GNU,Clang>>:-Wno-unknown-pragmas>
  # When g++ 12 vectorises straight-line code, it drops the rounding of neighbouring double(float(x)). Outward rounding
  # and chunk-relative placements depend on that rounding. tests/core/conventions_test.cpp holds the case.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-fno-tree-slp-vectorize>
  # g++ 12 warns of overlapping copies in std::string's own code (GCC bug 105651).
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  # g++ says of every 64-byte vector that it was passed differently before version 4.6, and clang++ that other options
  # would pass it differently. No such vector crosses a library's border.
  $<$<CXX_COMPILER_ID:GNU,Clang>:-Wno-psabi>
  # Vectors have no &&, and templates are for them and for single numbers.
  $<$<AND:$<CXX_COMPILER_ID:Clang>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,14>>:-Wno-bitwise-instead-of-logical>
  # The sources of a batch look like headers to g++, which then warns of their unnamed namespaces.
  $<$<AND:$<BOOL:${SIGHTLINE_UNITY}>,$<COMPILE_LANG_AND_ID:CXX,GNU>>:-Wno-subobject-linkage>
  $<$<AND:$<BOOL:${SIGHTLINE_WARNINGS_AS_ERRORS}>,$<CXX_COMPILER_ID:GNU,Clang>>:-Werror>)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  set(SIGHTLINE_X86_KERNELS TRUE)
  target_compile_definitions(sightline_flags INTERFACE SIGHTLINE_X86_KERNELS)
  # Instruction sets that the wider kernels may use, by the compiler's names. core/instruction_set.cpp checks that the
  # processor has all of them.
  set(SIGHTLINE_AVX2_FEATURES avx2 fma bmi popcnt)
  set(SIGHTLINE_AVX512_FEATURES avx512f avx512bw avx512dq avx512vl fma bmi popcnt)
  foreach(form AVX2 AVX512)
    list(TRANSFORM SIGHTLINE_${form}_FEATURES REPLACE "(.+)" "SIGHTLINE_HAS(\\1)" OUTPUT_VARIABLE features)
    list(JOIN features "&&" features)
    # Not for resource compilers, which hand their definitions to a shell.
    target_compile_definitions(sightline_flags INTERFACE "$<$<COMPILE_LANGUAGE:C,CXX>:SIGHTLINE_HAS_${form}=${features}>")
  endforeach()
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64" AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  set(SIGHTLINE_NEON_KERNELS TRUE)
  target_compile_definitions(sightline_flags INTERFACE SIGHTLINE_NEON_KERNELS)
endif()
if(EMSCRIPTEN)
  # Exceptions of WebAssembly itself: others would cost each call that may throw. The library throws none across its
  # interfaces, but catches what the standard library throws where memory ends.
  set(wasm_options -fwasm-exceptions $<$<BOOL:${SIGHTLINE_WASM_THREADS}>:-pthread>)
  target_compile_options(sightline_flags INTERFACE ${wasm_options})
  target_link_options(sightline_flags INTERFACE ${wasm_options})
  target_compile_definitions(sightline_flags INTERFACE $<$<BOOL:${SIGHTLINE_WASM_SIMD}>:SIGHTLINE_WASM_KERNELS>)
  # Sizes have 32 bits there. Counts that files state have 64, and are compared with what the file holds first.
  target_compile_options(sightline_flags INTERFACE -Wno-shorten-64-to-32)
  # What the standard library that Emscripten brings lacks of C++20.
  target_include_directories(sightline_flags INTERFACE ${SIGHTLINE_CHECKOUT}/bindings/wasm/libcxx)
endif()
if(SIGHTLINE_SANITIZE)
  # With sanitizers g++ 12 takes the insides of std::variant and std::regex for uninitialised (GCC's manual: they add
  # false positives).
  target_compile_options(sightline_flags INTERFACE
    $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-maybe-uninitialized>)
  target_compile_options(sightline_flags INTERFACE -fsanitize=${SIGHTLINE_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=undefined)
  target_link_options(sightline_flags INTERFACE -fsanitize=${SIGHTLINE_SANITIZE})
endif()
if(SIGHTLINE_FUZZ)
  target_compile_options(sightline_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# sightline_library(NAME [FOLDER folder] SOURCES … [HEADERS …] [LINKS …] [PRIVATE_LINKS …]): the library of a folder, by
# default of the same name. LINKS are the public dependencies. HEADERS are installed: those for applications, and in
# detail/ what their classes hold by value, which applications include through them alone. Headers in internal/ are
# private to the library. The library is an archive always;
# with BUILD_SHARED_LIBS all archives together become libsightline (SharedLibrary.cmake).
function(sightline_library name)
  cmake_parse_arguments(arg "" "FOLDER" "SOURCES;HEADERS;LINKS;PRIVATE_LINKS" ${ARGN})
  if(NOT arg_FOLDER)
    set(arg_FOLDER ${name})
  endif()
  sightline_include_root(root ${name} ${arg_FOLDER})
  set(target sightline_${name})
  add_library(${target} STATIC ${arg_SOURCES})
  add_library(sightline::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  if(WIN32 AND BUILD_SHARED_LIBS)  # classes would otherwise leave all their inline functions in every object
    target_compile_definitions(${target} PRIVATE SIGHTLINE_EXPORTS)
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-keep-inline-dllexport>)
  endif()
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_link_libraries(${target} PUBLIC ${arg_LINKS} PRIVATE $<BUILD_INTERFACE:sightline_flags> ${arg_PRIVATE_LINKS})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${root}>)
  if(arg_HEADERS MATCHES "internal/")
    message(FATAL_ERROR "sightline_library(${name}): headers in internal/ are not installed: ${arg_HEADERS}")
  endif()
  if(arg_HEADERS)
    list(TRANSFORM arg_HEADERS PREPEND ${root}/sightline/${arg_FOLDER}/)
    target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS ${root} FILES ${arg_HEADERS})
  endif()
  set_property(GLOBAL APPEND PROPERTY SIGHTLINE_LIBRARIES ${name})
endfunction()

# sightline_kernels(NAME [AVX2 file] [AVX512 file] [NEON file] [SIMD128 file]): kernels of one binary for all processors.
# Only these files may use wider instructions; core/instruction_set.h says which ones the processor has. SIMD128: for NEON
# and for WebAssembly, whose modules are checked as a whole before they run, so that each holds one form alone.
function(sightline_kernels name)
  cmake_parse_arguments(arg "" "AVX2;AVX512;NEON;SIMD128" "" ${ARGN})
  set_source_files_properties(${arg_NEON} ${arg_SIMD128} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(SIGHTLINE_NEON_KERNELS)
    target_sources(sightline_${name} PRIVATE ${arg_NEON} ${arg_SIMD128})
    # g++ takes operations on four registers for too long to inline, and passes them through memory.
    set_source_files_properties(${arg_NEON} ${arg_SIMD128} PROPERTIES
                                COMPILE_OPTIONS "$<$<CXX_COMPILER_ID:GNU>:--param=early-inlining-insns=200>")
  endif()
  # Other files must not be vectorised: clang 14 (Emscripten 3.1.6) mixes up the lanes of doubles.
  if(EMSCRIPTEN AND SIGHTLINE_WASM_SIMD AND arg_SIMD128)
    target_sources(sightline_${name} PRIVATE ${arg_SIMD128})
    set_source_files_properties(${arg_SIMD128} PROPERTIES COMPILE_OPTIONS "-msimd128;-fno-vectorize;-fno-slp-vectorize")
  endif()
  if(SIGHTLINE_X86_KERNELS)
    target_sources(sightline_${name} PRIVATE ${arg_AVX2} ${arg_AVX512})
    foreach(form AVX2 AVX512)
      list(TRANSFORM SIGHTLINE_${form}_FEATURES PREPEND "-m" OUTPUT_VARIABLE options)
      set_source_files_properties(${arg_${form}} PROPERTIES COMPILE_OPTIONS "${options}")
    endforeach()
  endif()
endfunction()

# sightline_resources(TARGET): what Windows shows of a program's file, and lets it do.
function(sightline_resources target)
  if(NOT WIN32)
    return()
  endif()
  set(file ${PROJECT_BINARY_DIR}/resources/${target}.rc)
  configure_file(${SIGHTLINE_CHECKOUT}/packaging/windows/resources.rc.in ${file} @ONLY)
  target_sources(${target} PRIVATE ${file})
endfunction()

# Where programs lie for whatever starts them: in bin/, or, for Linux on another processor, as scripts that lead to the
# emulator.
set(SIGHTLINE_RUNNABLE ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
if(CMAKE_CROSSCOMPILING_EMULATOR AND CMAKE_SYSTEM_NAME STREQUAL "Linux")
  set(SIGHTLINE_RUNNABLE ${PROJECT_BINARY_DIR}/emulated)
endif()
function(sightline_runnable name folder)
  if(SIGHTLINE_RUNNABLE STREQUAL CMAKE_RUNTIME_OUTPUT_DIRECTORY)
    return()
  endif()
  list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " emulator)
  file(WRITE ${SIGHTLINE_RUNNABLE}/${name} "#!/bin/sh\nexec ${emulator} -0 \"$0\" ${folder}/${name} \"$@\"\n")
  file(CHMOD ${SIGHTLINE_RUNNABLE}/${name} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endfunction()

# sightline_program(NAME SOURCES … LINKS …): an executable in bin/.
function(sightline_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINKS} sightline_flags)
  sightline_runnable(${name} ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
endfunction()
