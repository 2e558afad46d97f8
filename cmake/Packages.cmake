# Debian packages (docs/guide/packages.md): manual pages, changelogs and copyright files, and CPack with one package for each
# install component. The library is the shared one. Include this after all install() calls. scripts/package.sh does the rest.

# ---- The build step: cmake -DTOOL= -DVERSION= -DHELP2MAN= -DOUTPUT= -P Packages.cmake makes a manual page of a tool's --help.
if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  cmake_minimum_required(VERSION 3.25)
  execute_process(COMMAND ${TOOL} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCH "^[^\n]+" what "${help}")
  get_filename_component(name ${TOOL} NAME)
  execute_process(COMMAND ${HELP2MAN} --no-info --help-option=--help-all "--name=${what}" "--version-string=${VERSION}" --source=Sightline
                          --output=${OUTPUT} ${TOOL} COMMAND_ERROR_IS_FATAL ANY)
  # Examples line by line.
  file(READ ${OUTPUT} page)
  string(REGEX REPLACE "(\n\\.SH EXAMPLES\n\\.IP\n)(.*)$" "\\1.nf\n\\2.fi\n" page "${page}")
  file(WRITE ${OUTPUT} "${page}")
  execute_process(COMMAND gzip -9nf ${OUTPUT} COMMAND_ERROR_IS_FATAL ANY)
  return()
endif()

set(library_package libsightline${SIGHTLINE_SOVERSION})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${library_package})
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libsightline-dev)
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME sightline-tools)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-sightline)
set(CPACK_DEBIAN_OCCT_PACKAGE_NAME sightline-occt)

set(CPACK_COMPONENTS_ALL library development)
get_property(programs GLOBAL PROPERTY SIGHTLINE_TOOLS)
if(programs)
  list(APPEND CPACK_COMPONENTS_ALL tools)
endif()
if(SIGHTLINE_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(TARGET sightline_cad_reader)
  list(APPEND CPACK_COMPONENTS_ALL occt)
endif()

# Manual pages.
set(pages "")
foreach(program IN LISTS programs)
  set(page ${PROJECT_BINARY_DIR}/man/${program}.1)
  add_custom_command(OUTPUT ${page}.gz
    COMMAND ${CMAKE_COMMAND} -DTOOL=${SIGHTLINE_RUNNABLE}/${program} -DVERSION=${PROJECT_VERSION} -DHELP2MAN=${SIGHTLINE_HELP2MAN}
            -DOUTPUT=${page} -P ${CMAKE_CURRENT_LIST_DIR}/Packages.cmake
    DEPENDS ${program} ${CMAKE_CURRENT_LIST_DIR}/Packages.cmake VERBATIM)
  list(APPEND pages ${page}.gz)
endforeach()
if(pages)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/man)
  add_custom_target(man ALL DEPENDS ${pages})
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools)
endif()

# The maintainer is whom the environment names, as for Debian's own tools.
set(SIGHTLINE_PACKAGE_CONTACT "Sightline authors <sightline@localhost>")
if(DEFINED ENV{DEBEMAIL})
  set(SIGHTLINE_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()

# What Debian's policy wants of every package, and what lintian says of it that we know of, with reasons.
string(TIMESTAMP SIGHTLINE_CHANGED "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH, where it is set
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(SIGHTLINE_PACKAGE_VERSION ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
set(folder ${PROJECT_BINARY_DIR}/debian)
file(READ ${PROJECT_SOURCE_DIR}/LICENSE license)
string(REGEX REPLACE "^MIT License\n\nCopyright[^\n]*\n\n" "" license "${license}")
string(REGEX REPLACE "\n\n" "\n.\n" license "${license}")
string(STRIP "${license}" license)
string(REGEX REPLACE "\n" "\n " SIGHTLINE_LICENSE_TEXT " ${license}")
configure_file(cmake/debian/copyright.in ${folder}/copyright @ONLY)
configure_file(cmake/debian/changelog.in ${folder}/changelog.Debian @ONLY)
file(COPY_FILE ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${folder}/changelog)
execute_process(COMMAND gzip -9nfk ${folder}/changelog ${folder}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} COMPONENT)
  set(package ${CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME})
  install(FILES ${folder}/copyright ${folder}/changelog.gz ${folder}/changelog.Debian.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
  configure_file(cmake/debian/lintian-overrides ${folder}/overrides/${package} COPYONLY)
  if(component STREQUAL "library")
    file(READ cmake/debian/library.lintian-overrides overrides)
    file(APPEND ${folder}/overrides/${package} "${overrides}")
  endif()
  install(FILES ${folder}/overrides/${package} DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides
          COMPONENT ${component})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
# CPack would put any other summary before the descriptions of all packages, which begin with a summary of their own.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${CMAKE_PROJECT_NAME} built using CMake")
set(CPACK_PACKAGE_CONTACT "${SIGHTLINE_PACKAGE_CONTACT}")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/debs)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

# The library's own dependencies come from dpkg-shlibdeps; libEGL and libOSMesa are opened at run time.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/triggers)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SUGGESTS "libosmesa6, sightline-occt")
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "visibility library for CAD viewers
Holds a plant, a ship or an aircraft in a retained scene graph, decides per
view what can be seen, and draws it with OpenGL 4.5.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "${library_package} (= ${SIGHTLINE_PACKAGE_VERSION}), libexpected-dev, libgl-dev, libglm-dev")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "visibility library for CAD viewers - development files
Headers of Sightline, a library that holds a CAD model in a scene graph,
decides per view what can be seen, and draws it. With packages for CMake and
pkg-config.")

set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS "fonts-dejavu-core, libegl1, libgl1-mesa-dri")
set(CPACK_DEBIAN_TOOLS_PACKAGE_SUGGESTS "libosmesa6, sightline-occt")
set(CPACK_DEBIAN_TOOLS_DESCRIPTION "draws, replays, traces and converts CAD models
Command-line tools and a walkthrough window of Sightline, a visibility
library for CAD viewers: images and comparisons of models, flights along
camera paths with figures of culling and drawing, ray tracing, reports,
conversion of RVM, OBJ, glTF, PLY and STL files.")

set(CPACK_DEBIAN_OCCT_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_OCCT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_OCCT_DESCRIPTION "reads STEP, IGES and BREP files for Sightline
With this package the tools, the library and the Python module of Sightline, a
visibility library for CAD viewers, read STEP, IGES and BREP files, by a
program of its own that uses Open CASCADE.")

if(SIGHTLINE_PYTHON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${library_package} (= ${SIGHTLINE_PACKAGE_VERSION}), \
python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "visibility library for CAD viewers - Python module
Sightline for Python: imports CAD models into a scene graph, culls, draws
into numpy arrays, picks, and compares images.")
endif()

include(CPack)
