// What the colours of an image mean.
#pragma once

#include <string>

#include "sightline/analysis/query/colouring.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// A line for the key, and one for each group: "  #332288  CW  (1,234)"; nothing where there are no groups.
std::string legend_text(const query::Colouring& colouring);
/// {"key":"…", "groups":[{"label":"…", "colour":"#332288", "items":1234}]}; null where there are no groups.
json::Value legend_json(const query::Colouring& colouring);

}  // namespace sightline::apps
