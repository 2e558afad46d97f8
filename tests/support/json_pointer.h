// Changes of JSON documents at places that a pointer names.
#pragma once

#include <algorithm>
#include <string>

#include "sightline/importers/json/internal/json.h"

namespace sightline::tests {

/// The value at a pointer without escapes, as "/nodes/0/mesh". Adds missing members of objects.
inline json::Value& at_pointer(json::Value& root, const std::string& pointer) {
  json::Value* value = &root;
  for (std::size_t begin = 1, end; begin <= pointer.size(); begin = end + 1) {
    end = std::min(pointer.find('/', begin), pointer.size());
    const std::string name = pointer.substr(begin, end - begin);
    value = value->is_array() ? &value->at(std::stoul(name)) : &(*value)[name];
  }
  return *value;
}

}  // namespace sightline::tests
