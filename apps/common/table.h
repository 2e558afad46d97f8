// Tables of results, for people.
#pragma once

#include <cstdio>
#include <span>
#include <string_view>

#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

struct Column {
  std::string_view head;
  std::string_view key;                ///< of a row's value: "ms/mean" is the member "mean" of the member "ms"
  std::string_view format = "{:.4g}";  ///< of numbers, which are written as doubles
};

/// Writes the rows, which are objects, as a table that is also Markdown. Where a row has no value stands "-"; a column
/// that no row has is left out.
void print_table(const json::Value& rows, std::span<const Column> columns, std::FILE* out);

}  // namespace sightline::apps
