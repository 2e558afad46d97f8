// Stands for bcf.cpp where its libraries are absent.
#include "sightline/apps/viewpoints/bcf.h"

namespace sightline::apps {
namespace {

constexpr const char* kAbsent =
    "this build has no BCF: it was made without libzip (libzip-dev) or pugixml (libpugixml-dev)";

}  // namespace

core::Expected<std::string> format_bcf(std::span<const Viewpoint>) {
  return core::fail(kAbsent);
}

core::Expected<ViewFile> parse_bcf(std::string_view, const std::string& source) {
  return core::fail(source + ": " + kAbsent);
}

}  // namespace sightline::apps
