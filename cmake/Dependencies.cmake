# Finds the dependencies of the chosen options. If an optional dependency is absent, its option is switched off with one
# message, and the rest builds without it. core and culling need only GLM and tl-expected.

include(${CMAKE_CURRENT_LIST_DIR}/Need.cmake)

find_package(glm REQUIRED)
find_package(tl-expected REQUIRED)

if(SIGHTLINE_OPENMP)
  find_package(OpenMP COMPONENTS CXX QUIET)
  sightline_need(SIGHTLINE_OPENMP OpenMP_CXX_FOUND "OpenMP not found")
endif()

if(SIGHTLINE_IMPORTERS)
  find_package(Threads REQUIRED)
  find_package(nlohmann_json QUIET)
  find_package(fmt QUIET)
  sightline_need(SIGHTLINE_IMPORTERS nlohmann_json_FOUND "nlohmann-json not found")
  sightline_need(SIGHTLINE_IMPORTERS fmt_FOUND "fmt not found")
endif()

if(SIGHTLINE_OBJ AND SIGHTLINE_IMPORTERS)
  find_package(tinyobjloader QUIET)
  sightline_need(SIGHTLINE_OBJ tinyobjloader_FOUND "tinyobjloader not found")
endif()

if(SIGHTLINE_GLTF AND SIGHTLINE_IMPORTERS)
  find_path(SIGHTLINE_STB_INCLUDE stb_image.h PATH_SUFFIXES stb)
  sightline_need(SIGHTLINE_GLTF SIGHTLINE_STB_INCLUDE "stb_image.h not found (libstb-dev)")
endif()

if(SIGHTLINE_VTK AND SIGHTLINE_IMPORTERS)
  # By component, since all of a packaged VTK requires Qt, Java and more. Only tests need its writers, only an example its
  # render window.
  find_package(VTK 9 QUIET COMPONENTS CommonCore CommonDataModel CommonExecutionModel FiltersGeometry IOCore
               OPTIONAL_COMPONENTS IOLegacy IOXML FiltersSources IOImage InteractionStyle RenderingOpenGL2)
  sightline_need(SIGHTLINE_VTK VTK_FOUND "VTK 9 not found (libvtk9-dev)")
  sightline_need(SIGHTLINE_VTK UNIX "its module is loaded by dlopen()")
endif()

if(SIGHTLINE_IMAGE)
  find_package(PNG QUIET)
  sightline_need(SIGHTLINE_IMAGE PNG_FOUND "libpng not found")
endif()

if(SIGHTLINE_GL)
  find_path(SIGHTLINE_GL_INCLUDE GL/glcorearb.h)
  find_path(SIGHTLINE_EGL_INCLUDE EGL/egl.h)
  find_package(fmt QUIET)
  sightline_need(SIGHTLINE_GL SIGHTLINE_GL_INCLUDE "GL/glcorearb.h not found")
  sightline_need(SIGHTLINE_GL SIGHTLINE_EGL_INCLUDE "EGL/egl.h not found")
  sightline_need(SIGHTLINE_GL SIGHTLINE_IMAGE "SIGHTLINE_IMAGE is off")
  sightline_need(SIGHTLINE_GL fmt_FOUND "fmt not found")
endif()

if(SIGHTLINE_PYTHON)
  # The first python3 that has numpy: a PATH may begin with another one.
  function(sightline_imports_numpy result candidate)
    execute_process(COMMAND ${candidate} -c "import numpy" RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
    if(failed)
      set(${result} FALSE PARENT_SCOPE)
    endif()
  endfunction()
  find_program(Python_EXECUTABLE NAMES python3 python VALIDATOR sightline_imports_numpy)
  sightline_need(SIGHTLINE_PYTHON Python_EXECUTABLE "no python3 with numpy found (python3-numpy)")
  sightline_need(SIGHTLINE_PYTHON SIGHTLINE_GL "SIGHTLINE_GL is off")
  sightline_need(SIGHTLINE_PYTHON SIGHTLINE_IMPORTERS "the importers are off")
  sightline_need(SIGHTLINE_PYTHON SIGHTLINE_RAYTRACE "SIGHTLINE_RAYTRACE is off")
endif()
if(SIGHTLINE_PYTHON)
  find_package(Python 3 COMPONENTS Interpreter Development.Module QUIET)
  find_package(pybind11 2.10 QUIET)
  sightline_need(SIGHTLINE_PYTHON Python_Development.Module_FOUND "Python's headers not found (python3-dev)")
  sightline_need(SIGHTLINE_PYTHON pybind11_FOUND "pybind11 not found (pybind11-dev)")
endif()

if(SIGHTLINE_APPS)
  find_package(CLI11 QUIET)
  sightline_need(SIGHTLINE_APPS CLI11_FOUND "CLI11 not found")
  sightline_need(SIGHTLINE_APPS SIGHTLINE_IMPORTERS "the importers are off")
endif()

if(SIGHTLINE_VIEW AND SIGHTLINE_APPS)
  find_package(glfw3 3.3 QUIET)
  sightline_need(SIGHTLINE_VIEW SIGHTLINE_GL "SIGHTLINE_GL is off")
  sightline_need(SIGHTLINE_VIEW glfw3_FOUND "GLFW not found (libglfw3-dev)")
endif()

if(SIGHTLINE_EXAMPLES AND SIGHTLINE_EXAMPLES_OSG)
  find_package(OpenSceneGraph 3.6 QUIET COMPONENTS osgViewer osgGA osgUtil osgDB)
  sightline_need(SIGHTLINE_EXAMPLES_OSG OPENSCENEGRAPH_FOUND "OpenSceneGraph not found (libopenscenegraph-dev)")
endif()
if(SIGHTLINE_EXAMPLES AND SIGHTLINE_EXAMPLES_QT)
  find_package(Qt6 QUIET COMPONENTS OpenGLWidgets)
  sightline_need(SIGHTLINE_EXAMPLES_QT Qt6_FOUND "Qt 6 not found (qt6-base-dev, libqt6opengl6-dev)")
endif()

if(SIGHTLINE_PACKAGES)
  find_program(SIGHTLINE_HELP2MAN help2man)
  sightline_need(SIGHTLINE_PACKAGES SIGHTLINE_HELP2MAN "help2man not found")
  sightline_need(SIGHTLINE_PACKAGES BUILD_SHARED_LIBS "BUILD_SHARED_LIBS is off")
endif()

if(SIGHTLINE_TESTS)
  find_package(GTest QUIET)
  sightline_need(SIGHTLINE_TESTS GTest_FOUND "GoogleTest not found")
endif()

if(SIGHTLINE_BENCH AND SIGHTLINE_APPS)
  find_package(benchmark QUIET)
  if(NOT benchmark_FOUND)
    sightline_lack("sightline-bench is without queries and intersect: Google Benchmark not found (libbenchmark-dev)")
  endif()
  if(SIGHTLINE_RAYTRACE)
    find_package(embree 3 QUIET)  # a peer to measure beside: nothing is missing without it
  endif()
endif()
