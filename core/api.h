// What libsightline, the shared library, exports. Everything else in it is hidden (cmake/SharedLibrary.cmake). Without
// effect for the archives. On Windows those who link the library say so by SIGHTLINE_IMPORTS, as its CMake package does.
#pragma once

#if defined(SIGHTLINE_EXPORTS)
#define SIGHTLINE_API __declspec(dllexport)
#elif defined(SIGHTLINE_IMPORTS)
#define SIGHTLINE_API __declspec(dllimport)
#elif defined(__GNUC__)
#define SIGHTLINE_API __attribute__((visibility("default")))
#else
#define SIGHTLINE_API
#endif
