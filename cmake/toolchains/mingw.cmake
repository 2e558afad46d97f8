# Windows on x86-64 with the distribution's g++ of MinGW-w64, in the variant whose std::thread is made of POSIX threads.
# SIGHTLINE_WINDOWS_DEPS names the folder that scripts/windows.sh installs dependencies into.

set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_VERSION 10)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SIGHTLINE_WINDOWS_DEPS)
set(CMAKE_FIND_ROOT_PATH ${SIGHTLINE_WINDOWS_DEPS} /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# Windows 10 is the oldest that is supported.
#
# An inline function's code is that of one of the objects that have a copy. On Windows such copies are not weak symbols,
# and g++ 12 takes the one of the object that it compiles for the one that is called: it relies on which registers that
# one spares, or how it wants the stack aligned, which the copy of another object need not do.
set(flags "-D_WIN32_WINNT=0x0A00 -fno-ipa-ra -fno-ipa-stack-alignment")
set(CMAKE_C_FLAGS_INIT "${flags}")
set(CMAKE_CXX_FLAGS_INIT "${flags}")
# Programs need no libraries of the compiler beside them. Their stacks are as large as on Linux: 2 MB are the default.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static -Wl,--stack,8388608")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "-static")
set(CMAKE_MODULE_LINKER_FLAGS_INIT "-static")

# FindOpenMP would take the library to be loaded, which lies beside no program.
execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libgomp.a OUTPUT_VARIABLE gomp OUTPUT_STRIP_TRAILING_WHITESPACE)
set(OpenMP_gomp_LIBRARY ${gomp} CACHE FILEPATH "")

# Programs are run by this script: ctest, and what lists a program's tests, go through it.
if(SIGHTLINE_WINE)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${SIGHTLINE_WINE})
endif()
