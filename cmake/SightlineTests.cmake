# sightline_tests(FOLDER [LABEL label] THINGS thing … [LINKS …] [ALONE filter …] [NIGHTLY filter …]): one test program of the
# files <thing>_test.cpp beside the caller. Its name is FOLDER_tests, or FOLDER_label_tests; ctest's entries are FOLDER.Suite,
# or FOLDER_label.Suite with that label, each a process that runs the suite's cases. The label gl is of tests that need a
# context; their programs make sure that they got the driver that scripts/with_driver.sh chose. Cases that one of GoogleTest's
# filters in ALONE takes are entries of their own, FOLDER.Suite.Case: where one could spoil the next, or where each starts other
# programs, so that one process saves nothing. So are those of NIGHTLY, with the label nightly, or nightly_label, which presets
# leave out.
#
# A new file of tests is one more word in THINGS. Cases share a process, so they leave no state behind; each makes its context.
# Batches of files are compiled as one: each file has a namespace of its own, named after it, and an anonymous one within.
include(GoogleTest)
find_package(Threads REQUIRED)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/tests/cache)
add_library(sightline_tests_places STATIC ${SIGHTLINE_CHECKOUT}/tests/support/places.cpp)
target_link_libraries(sightline_tests_places PUBLIC sightline_tests_headers PRIVATE sightline_flags)
target_compile_definitions(sightline_tests_places PRIVATE SIGHTLINE_SOURCE_DIR="${SIGHTLINE_CHECKOUT}"
                           SIGHTLINE_BIN_DIR="${SIGHTLINE_RUNNABLE}")
if(TARGET sightline::gl)
  add_library(sightline_tests_driver OBJECT ${SIGHTLINE_CHECKOUT}/tests/support/driver.cpp)
  target_link_libraries(sightline_tests_driver PRIVATE sightline::gl GTest::gtest sightline_tests_headers sightline_flags)
endif()

# sightline_tests_glslang: compiles programs without a driver, where glslang is found.
if(TARGET sightline::gl)
  find_package(SPIRV-Tools-opt QUIET)
  find_package(glslang QUIET)
  if(SPIRV-Tools-opt_FOUND AND glslang_FOUND)
    add_library(sightline_tests_glslang STATIC ${SIGHTLINE_CHECKOUT}/tests/support/glslang.cpp)
    target_link_libraries(sightline_tests_glslang PUBLIC sightline::gl sightline_tests_headers
      PRIVATE glslang::SPIRV glslang::glslang-default-resource-limits GTest::gtest Threads::Threads sightline_flags)
  else()
    sightline_lack("tests that compile all programs are not built: glslang or SPIRV-Tools not found (glslang-dev, spirv-tools)")
  endif()
endif()

# Entries are made when ctest runs, not when tests are built: a program that cannot start fails its tests and not the build.
function(sightline_add_cases name filter)
  gtest_discover_tests(${name}_tests TEST_PREFIX ${name}. TEST_FILTER ${filter} NO_PRETTY_VALUES DISCOVERY_MODE PRE_TEST
                       DISCOVERY_TIMEOUT 120 PROPERTIES ${ARGN})
endfunction()
function(sightline_add_suites name left_out)
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${name}_suites.cmake)
  list(JOIN ARGN "\" \"" properties)
  set(emulator ${CMAKE_CROSSCOMPILING_EMULATOR})
  set(program ${PROJECT_BINARY_DIR}/tests/${name}_tests${CMAKE_EXECUTABLE_SUFFIX})
  if(NOT SIGHTLINE_RUNNABLE STREQUAL CMAKE_RUNTIME_OUTPUT_DIRECTORY)  # also for tests that start themselves
    set(emulator "")
    set(program ${SIGHTLINE_RUNNABLE}/${name}_tests)
  endif()
  file(WRITE ${file} "set(SIGHTLINE_EMULATOR \"${emulator}\")\n"
                     "include(${SIGHTLINE_CHECKOUT}/cmake/SuiteEntries.cmake)\nsightline_suite_entries(${name} "
                     "${program} \"${left_out}\" \"${properties}\")\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
endfunction()

function(sightline_tests folder)
  cmake_parse_arguments(arg "" "LABEL" "THINGS;LINKS;ALONE;NIGHTLY" ${ARGN})
  string(JOIN _ name ${folder} ${arg_LABEL})
  list(TRANSFORM arg_THINGS REPLACE "(.+)" "${CMAKE_CURRENT_SOURCE_DIR}/\\1_test.cpp" OUTPUT_VARIABLE sources)
  add_executable(${name}_tests ${sources})
  target_link_libraries(${name}_tests PRIVATE ${arg_LINKS} GTest::gtest GTest::gtest_main Threads::Threads
                        sightline_tests_places sightline_flags)
  if(arg_LABEL STREQUAL "gl")
    target_sources(${name}_tests PRIVATE $<TARGET_OBJECTS:sightline_tests_driver>)
    target_link_libraries(${name}_tests PRIVATE sightline::gl)
  endif()
  # The library beneath is optimised; optimising the checks takes longer than running them.
  target_compile_options(${name}_tests PRIVATE $<$<AND:$<CONFIG:Release>,$<CXX_COMPILER_ID:GNU,Clang>>:-O1>)
  set_target_properties(${name}_tests PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  sightline_runnable(${name}_tests ${PROJECT_BINARY_DIR}/tests)
  # What is kept for later runs, drivers' caches included, is kept in the build tree. Threads of OpenMP that wait leave the
  # processors to other tests.
  set(properties TIMEOUT 1200 ENVIRONMENT OMP_WAIT_POLICY=passive
                 ENVIRONMENT_MODIFICATION XDG_CACHE_HOME=set:${PROJECT_BINARY_DIR}/tests/cache)
  list(JOIN arg_NIGHTLY ":" nightly)
  list(JOIN arg_ALONE ":" alone)
  string(JOIN ":" not_in_suites ${nightly} ${alone})
  set(label ${arg_LABEL})
  if(label)
    list(PREPEND label LABELS)
  endif()
  if(alone)
    sightline_add_cases(${name} "${alone}-${nightly}" ${properties} ${label})
  endif()
  if(NOT alone STREQUAL "*")
    sightline_add_suites(${name} "${not_in_suites}" ${properties} ${label})
  endif()
  if(nightly)
    string(JOIN _ label nightly ${arg_LABEL})
    sightline_add_cases(${name} "${nightly}" ${properties} LABELS ${label})
  endif()
endfunction()

# sightline_needs_tools(PROGRAM tool …): PROGRAM runs sightline-<tool> of each tool, which are built before it.
function(sightline_needs_tools program)
  list(JOIN ARGN " " names)
  target_compile_definitions(${program} PRIVATE SIGHTLINE_TOOLS="${names}")
  list(TRANSFORM ARGN PREPEND sightline- OUTPUT_VARIABLE targets)
  add_dependencies(${program} ${targets})
endfunction()
