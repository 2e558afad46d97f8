// What libsightline, the shared library, exports. Everything else in it is hidden (cmake/SharedLibrary.cmake). Without
// effect for the archives.
#pragma once

#if defined(__GNUC__)
#define SIGHTLINE_API __attribute__((visibility("default")))
#else
#define SIGHTLINE_API  // archives only
#endif
