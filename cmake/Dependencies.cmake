# Finds what the chosen options need. An optional dependency that is absent switches its option off, says so once, and
# the rest builds without it; core and culling need GLM and tl-expected alone.

# sightline_need(OPTION FOUND WHAT): switches OPTION off for this build when FOUND is false.
macro(sightline_need option found what)
  if(${option} AND NOT ${found})
    message(STATUS "sightline: ${option} is off: ${what} not found")
    set(${option} OFF)
  endif()
endmacro()

find_package(glm REQUIRED)
find_package(tl-expected REQUIRED)

if(SIGHTLINE_OPENMP)
  find_package(OpenMP COMPONENTS CXX QUIET)
  sightline_need(SIGHTLINE_OPENMP OpenMP_CXX_FOUND "OpenMP")
endif()

if(SIGHTLINE_IMPORTERS)
  find_package(nlohmann_json QUIET)
  find_package(fmt QUIET)
  sightline_need(SIGHTLINE_IMPORTERS nlohmann_json_FOUND "nlohmann-json")
  sightline_need(SIGHTLINE_IMPORTERS fmt_FOUND "fmt")
endif()

if(SIGHTLINE_OBJ AND SIGHTLINE_IMPORTERS)
  find_package(tinyobjloader QUIET)
  sightline_need(SIGHTLINE_OBJ tinyobjloader_FOUND "tinyobjloader")
endif()

if(SIGHTLINE_GL)
  find_path(SIGHTLINE_GL_INCLUDE GL/glcorearb.h)
  find_path(SIGHTLINE_EGL_INCLUDE EGL/egl.h)
  find_package(PNG QUIET)
  find_package(fmt QUIET)
  sightline_need(SIGHTLINE_GL SIGHTLINE_GL_INCLUDE "GL/glcorearb.h")
  sightline_need(SIGHTLINE_GL SIGHTLINE_EGL_INCLUDE "EGL/egl.h")
  sightline_need(SIGHTLINE_GL PNG_FOUND "libpng")
  sightline_need(SIGHTLINE_GL fmt_FOUND "fmt")
endif()

if(SIGHTLINE_APPS)
  find_package(CLI11 QUIET)
  sightline_need(SIGHTLINE_APPS CLI11_FOUND "CLI11")
  sightline_need(SIGHTLINE_APPS SIGHTLINE_IMPORTERS "what the importers need")
endif()

if(SIGHTLINE_TESTS)
  find_package(GTest QUIET)
  sightline_need(SIGHTLINE_TESTS GTest_FOUND "GoogleTest")
endif()
