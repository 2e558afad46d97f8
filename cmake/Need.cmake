# What a build does without when a dependency is absent. With SIGHTLINE_REQUIRE_ALL that is an error.

# sightline_lack(WHAT): reports what this build lacks.
function(sightline_lack what)
  if(SIGHTLINE_REQUIRE_ALL)
    message(FATAL_ERROR "sightline: ${what} (SIGHTLINE_REQUIRE_ALL is on)")
  endif()
  message(STATUS "sightline: ${what}")
endfunction()

# sightline_need(OPTION CONDITION LACK): switches OPTION off for this build when CONDITION is false, and reports LACK.
macro(sightline_need option condition lack)
  if(${option} AND NOT ${condition})
    sightline_lack("${option} is off: ${lack}")
    set(${option} OFF)
  endif()
endmacro()
