// What a GL context offers, on one page for bug reports: driver, limits, self-test, workarounds.
#pragma once

#include <cstdio>
#include <optional>
#include <string>

#include "sightline/gl/context.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// `milliseconds`: that making the context took; none: the page does not say. Sizes are in the units that
/// gl::Capabilities names. Has all extensions, too. The context must be current.
json::Value gl_page(const gl::Context& context, std::optional<double> milliseconds = {});

/// The page as lines, without extensions but for their number. Values begin at kGlPageColumn.
inline constexpr std::size_t kGlPageColumn = 33;
std::string gl_page_text(const json::Value& page);
void print_gl_page(const json::Value& page, std::FILE* out);

}  // namespace sightline::apps
