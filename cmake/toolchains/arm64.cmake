# Linux on 64-bit ARM with the distribution's cross compiler. SIGHTLINE_ARM64_ROOT names the folder that scripts/arm64.sh
# unpacks the distribution's packages for ARM into.

set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SIGHTLINE_ARM64_ROOT)
set(CMAKE_SYSROOT ${SIGHTLINE_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# Programs are run by this one: ctest, and what lists a program's tests, go through it.
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L ${SIGHTLINE_ARM64_ROOT})
