# cmake --install: the libraries, their public headers, and packages for find_package() and pkg-config. Include this
# after all sightline_library() calls: it reads their targets.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# How the packages name an external target that a library links: in find_dependency() (_PACKAGE), and in a pkg-config
# file under Requires (_REQUIRES) or Libs (_LIBS).
set(external_glm::glm_PACKAGE "glm")
set(external_tl::expected_PACKAGE "tl-expected")
set(external_Threads::Threads_PACKAGE "Threads")
set(external_Threads::Threads_LIBS "-pthread")
set(external_OpenMP::OpenMP_CXX_PACKAGE "OpenMP COMPONENTS CXX")
set(external_OpenMP::OpenMP_CXX_LIBS "-fopenmp")
set(external_fmt::fmt_PACKAGE "fmt")
set(external_fmt::fmt_REQUIRES "fmt")
set(external_PNG::PNG_PACKAGE "PNG")
set(external_PNG::PNG_REQUIRES "libpng")
set(external_nlohmann_json::nlohmann_json_PACKAGE "nlohmann_json")
set(external_tinyobjloader::tinyobjloader_double_PACKAGE "tinyobjloader")
set(external_tinyobjloader::tinyobjloader_double_REQUIRES "tinyobjloader_double")
foreach(part CommonCore CommonDataModel CommonExecutionModel FiltersGeometry IOCore)
  set(external_VTK::${part}_PACKAGE "VTK COMPONENTS ${part}")
endforeach()
set(external_${CMAKE_DL_LIBS}_LIBS "-l${CMAKE_DL_LIBS}")

get_property(libraries GLOBAL PROPERTY SIGHTLINE_LIBRARIES)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Sightline)
file(RELATIVE_PATH PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
set(SIGHTLINE_DEPENDENCIES "")  # lines of SightlineConfig.cmake
foreach(name IN LISTS libraries)
  install(TARGETS sightline_${name} EXPORT SightlineTargets
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  set(links "")
  foreach(kind PACKAGE REQUIRES LIBS)
    set(${kind} "")
  endforeach()
  get_target_property(targets sightline_${name} LINK_LIBRARIES)
  foreach(target IN LISTS targets)
    if(target MATCHES "^sightline::(.+)$")
      list(APPEND links ${CMAKE_MATCH_1})
    endif()
    foreach(kind PACKAGE REQUIRES LIBS)
      if(DEFINED external_${target}_${kind})
        list(APPEND ${kind} "${external_${target}_${kind}}")
      endif()
    endforeach()
  endforeach()
  string(APPEND SIGHTLINE_DEPENDENCIES "set(Sightline_${name}_links \"${links}\")\nset(Sightline_${name}_packages \"${PACKAGE}\")\n")

  set(PC_NAME ${name})
  list(TRANSFORM links PREPEND "sightline-" OUTPUT_VARIABLE PC_REQUIRES)
  list(APPEND PC_REQUIRES ${REQUIRES})
  list(JOIN PC_REQUIRES ", " PC_REQUIRES)
  list(JOIN LIBS " " PC_LIBS)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/sightline.pc.in ${PROJECT_BINARY_DIR}/sightline-${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/sightline-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()

set(SIGHTLINE_COMPONENTS ${libraries})

# For projects that measure the library's parts: all private headers, and the shaders that some of them include. They
# promise nothing and change without notice. An install component of its own; find_package() has it as a component, too.
if(SIGHTLINE_INSTALL_INTERNALS)
  if(BUILD_SHARED_LIBS)
    message(FATAL_ERROR "sightline: SIGHTLINE_INSTALL_INTERNALS needs static libraries, BUILD_SHARED_LIBS is on: "
                        "a shared library exports only what its public headers declare")
  endif()
  foreach(name IN LISTS libraries)
    get_target_property(source_dir sightline_${name} SOURCE_DIR)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${source_dir})
    set(destination ${CMAKE_INSTALL_INCLUDEDIR}/sightline/${folder})
    file(GLOB internals RELATIVE ${source_dir} ${source_dir}/internal ${source_dir}/*/internal)
    foreach(path IN LISTS internals)
      install(DIRECTORY ${source_dir}/${path}/ DESTINATION ${destination}/${path} COMPONENT internals)
    endforeach()
    file(GLOB limits ${source_dir}/shaders/*limits.glsl)
    install(FILES ${limits} DESTINATION ${destination}/shaders COMPONENT internals)
  endforeach()
endif()

install(EXPORT SightlineTargets NAMESPACE sightline:: DESTINATION ${package_dir})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/SightlineConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/SightlineConfig.cmake INSTALL_DESTINATION ${package_dir}
                              PATH_VARS CMAKE_INSTALL_INCLUDEDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/SightlineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/SightlineConfig.cmake ${PROJECT_BINARY_DIR}/SightlineConfigVersion.cmake
        DESTINATION ${package_dir})
if(TARGET sightline_vtk)
  install(TARGETS sightline_vtk LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
get_property(programs GLOBAL PROPERTY SIGHTLINE_TOOLS)
if(programs)
  install(TARGETS ${programs} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
