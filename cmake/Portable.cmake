# Programs for other machines (scripts/gpu_kit.sh). Libraries are linked as archives where there are any, and are looked
# for in ../lib where there are none. The C++ runtime is linked as an archive, too: a graphics driver may need a newer
# libstdc++ than that of this machine, and one process cannot load both.

list(PREPEND CMAKE_FIND_LIBRARY_SUFFIXES .a)
add_link_options(-static-libstdc++ -static-libgcc LINKER:--as-needed)
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)
set(CMAKE_INSTALL_RPATH "$ORIGIN/../lib")

# Debian has fmt as a shared library only. Its headers can do without.
find_package(fmt QUIET)
if(TARGET fmt::fmt)
  target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY)
endif()
