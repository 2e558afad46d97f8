# Finds what the chosen options need. An optional dependency that is absent switches its option off, says so once, and
# the rest builds without it; core and culling need GLM and tl-expected alone.

# sightline_need(OPTION CONDITION LACK): switches OPTION off for this build when CONDITION is false, and says LACK.
macro(sightline_need option condition lack)
  if(${option} AND NOT ${condition})
    message(STATUS "sightline: ${option} is off: ${lack}")
    set(${option} OFF)
  endif()
endmacro()

find_package(glm REQUIRED)
find_package(tl-expected REQUIRED)

if(SIGHTLINE_OPENMP)
  find_package(OpenMP COMPONENTS CXX QUIET)
  sightline_need(SIGHTLINE_OPENMP OpenMP_CXX_FOUND "OpenMP not found")
endif()

if(SIGHTLINE_IMPORTERS)
  find_package(nlohmann_json QUIET)
  find_package(fmt QUIET)
  sightline_need(SIGHTLINE_IMPORTERS nlohmann_json_FOUND "nlohmann-json not found")
  sightline_need(SIGHTLINE_IMPORTERS fmt_FOUND "fmt not found")
endif()

if(SIGHTLINE_OBJ AND SIGHTLINE_IMPORTERS)
  find_package(tinyobjloader QUIET)
  sightline_need(SIGHTLINE_OBJ tinyobjloader_FOUND "tinyobjloader not found")
endif()

if(SIGHTLINE_GL)
  find_path(SIGHTLINE_GL_INCLUDE GL/glcorearb.h)
  find_path(SIGHTLINE_EGL_INCLUDE EGL/egl.h)
  find_package(PNG QUIET)
  find_package(fmt QUIET)
  sightline_need(SIGHTLINE_GL SIGHTLINE_GL_INCLUDE "GL/glcorearb.h not found")
  sightline_need(SIGHTLINE_GL SIGHTLINE_EGL_INCLUDE "EGL/egl.h not found")
  sightline_need(SIGHTLINE_GL PNG_FOUND "libpng not found")
  sightline_need(SIGHTLINE_GL fmt_FOUND "fmt not found")
endif()

if(SIGHTLINE_APPS)
  find_package(CLI11 QUIET)
  sightline_need(SIGHTLINE_APPS CLI11_FOUND "CLI11 not found")
  sightline_need(SIGHTLINE_APPS SIGHTLINE_IMPORTERS "the importers are off")
endif()

if(SIGHTLINE_TESTS)
  find_package(GTest QUIET)
  sightline_need(SIGHTLINE_TESTS GTest_FOUND "GoogleTest not found")
endif()
