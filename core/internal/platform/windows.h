// windows.h as the files of this folder need it, and what they share. For windows*.cpp alone.
#pragma once

#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
// Names of ours that it takes for its own.
#undef near
#undef far

#include <string>
#include <string_view>
#include <system_error>

namespace sightline::core::platform {

/// UTF-16 of UTF-8, and back. What is neither becomes U+FFFD.
std::wstring wide_of(std::string_view text);
std::string utf8_of(std::wstring_view text);

/// What GetLastError() says, as portable code compares it.
inline std::error_code last_error() {
  return {int(GetLastError()), std::system_category()};
}
/// The system's words for it, in one line.
std::string words_of(const std::error_code& error);

}  // namespace sightline::core::platform
