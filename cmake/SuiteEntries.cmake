# sightline_suite_entries(NAME PROGRAM LEFT_OUT property …), called when ctest runs: an entry NAME.Suite for each suite of
# PROGRAM, which runs its cases in one process, but for those that LEFT_OUT takes, filters of GoogleTest joined by colons.
# The properties are those of set_tests_properties. SIGHTLINE_EMULATOR: what runs the program, where this system cannot.
function(sightline_suite_entries name program left_out)
  set(output "")
  if(EXISTS ${program})
    execute_process(COMMAND ${SIGHTLINE_EMULATOR} ${program} --gtest_list_tests --gtest_filter=*-${left_out}
                    OUTPUT_VARIABLE output ERROR_QUIET TIMEOUT 120)
  endif()
  string(REPLACE "\r" "" output "${output}")
  string(REGEX MATCHALL "(^|\n)[^ \n]+[.][ \n]" suites "${output}")
  if(NOT suites)  # a program that is not built or cannot start: this entry fails
    add_test(${name}_NOT_BUILT ${program})
  endif()
  foreach(suite IN LISTS suites)
    string(REGEX REPLACE "[\n ]|[.][ \n]" "" suite "${suite}")
    add_test(${name}.${suite} ${SIGHTLINE_EMULATOR} ${program} --gtest_filter=${suite}.*-${left_out})
    set_tests_properties(${name}.${suite} PROPERTIES ${ARGN})
  endforeach()
endfunction()
