// Numbers as tools write them for people.
#pragma once

#include <cstdint>
#include <string>

#include "sightline/core/conventions.h"

namespace sightline::apps {

std::string grouped(std::int64_t number);  ///< 1,234,567
std::string vector_text(const core::dvec3& v);
std::string length_text(double metres);  ///< 1.250 m, 0.13 mm

}  // namespace sightline::apps
