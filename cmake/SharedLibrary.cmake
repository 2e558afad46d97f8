# One shared library, libsightline, of all archives: built and installed with BUILD_SHARED_LIBS, otherwise made where a
# target links it. It exports what public headers mark as SIGHTLINE_API and nothing else. Include this after all
# sightline_library() calls: it reads their targets.
#
# It has the same components as the archives: sightline_core_component and so on, which a package names sightline::core.
# Each is an interface: the headers of a folder, what these need, and libsightline. importers_vtk is not among them,
# since libsightline would need VTK then; import_file() reads VTK files all the same.

# sightline_public_links(RESULT NAME): what users of a library's headers link.
function(sightline_public_links result name)
  get_target_property(links sightline_${name} INTERFACE_LINK_LIBRARIES)
  list(FILTER links EXCLUDE REGEX "LINK_ONLY")
  set(${result} ${links} PARENT_SCOPE)
endfunction()

get_property(libraries GLOBAL PROPERTY SIGHTLINE_LIBRARIES)
list(REMOVE_ITEM libraries importers_vtk)
list(TRANSFORM libraries PREPEND sightline_ OUTPUT_VARIABLE archives)
list(TRANSFORM archives REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)

add_library(sightline SHARED ${objects})
add_library(sightline::sightline ALIAS sightline)
target_link_libraries(sightline PRIVATE ${archives} sightline_flags)  # for what these link: all objects are there
if(NOT BUILD_SHARED_LIBS)
  set_target_properties(sightline PROPERTIES EXCLUDE_FROM_ALL TRUE)
endif()
# As long as the major version is 0, each minor version may have another ABI (docs/guide/packages.md).
set(SIGHTLINE_SOVERSION ${PROJECT_VERSION_MAJOR})
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(SIGHTLINE_SOVERSION 0.${PROJECT_VERSION_MINOR})
endif()
set_target_properties(sightline PROPERTIES LINKER_LANGUAGE CXX VERSION ${PROJECT_VERSION} SOVERSION ${SIGHTLINE_SOVERSION})

if(WIN32)
  sightline_resources(sightline)
  target_compile_definitions(sightline INTERFACE SIGHTLINE_IMPORTS)
endif()

foreach(name IN LISTS libraries)
  set(component sightline_${name}_component)
  add_library(${component} INTERFACE)
  set_target_properties(${component} PROPERTIES EXPORT_NAME ${name} VERIFY_INTERFACE_HEADER_SETS OFF)
  target_compile_features(${component} INTERFACE cxx_std_20)
  get_target_property(definitions sightline_${name} INTERFACE_COMPILE_DEFINITIONS)
  if(definitions)
    target_compile_definitions(${component} INTERFACE ${definitions})
  endif()
  sightline_public_links(links ${name})
  list(TRANSFORM links REPLACE "^sightline::(.+)$" "sightline_\\1_component")
  target_link_libraries(${component} INTERFACE sightline ${links})
  get_target_property(headers sightline_${name} HEADER_SET)
  if(headers)
    get_target_property(root sightline_${name} HEADER_DIRS)
    target_sources(${component} INTERFACE FILE_SET HEADERS BASE_DIRS ${root} FILES ${headers})
  endif()
endforeach()
