// The texts that an import leaves: names and attributes of nodes, and warnings.
#pragma once

#include <string>
#include <string_view>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/text_encoding.h"

namespace sightline::tests {

/// One that is not UTF-8, or empty.
inline std::string text_that_is_not_utf8(const core::Scene& scene, const importers::ImportReport& report) {
  std::string found;
  const auto look_at = [&](std::string_view text) {
    if (!importers::is_utf8(text)) found = text;
  };
  scene.for_each_node(scene.root(), [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
    look_at(scene.name(node));
    for (const auto& [key, value] : scene.attributes(node)) look_at(key), look_at(value);
  });
  for (const importers::ImportWarning& warning : report.warnings) look_at(warning.file), look_at(warning.message);
  return found;
}

}  // namespace sightline::tests
