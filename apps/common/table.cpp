#include "sightline/apps/common/table.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace sightline::apps {
namespace {

std::string text_of(const json::Value* value, std::string_view format) {
  if (!value || value->is_null()) return "-";
  if (value->is_string()) return value->string();
  return value->is_number() ? fmt::format(fmt::runtime(format), value->get<double>()) : value->dump();
}

/// The head and the rows of a column; empty where no row has a value.
std::vector<std::string> cells_of(const json::Value& rows, const Column& column, bool& numbers) {
  std::vector<std::string> cells{std::string(column.head)};
  bool known = false;
  numbers = true;
  for (const json::Value& row : rows) {
    const json::Value* value = row.find_pointer("/" + std::string(column.key));
    known = known || (value && !value->is_null());
    numbers = numbers && !(value && value->is_string());
    cells.push_back(text_of(value, column.format));
  }
  if (!known) cells.clear();
  return cells;
}

}  // namespace

void print_table(const json::Value& rows, std::span<const Column> columns, std::FILE* out) {
  std::vector<std::string> lines(rows.size() + 2, "|");  // the head, the rule below it, and the rows
  for (const Column& column : columns) {
    bool numbers = true;
    std::vector<std::string> cells = cells_of(rows, column, numbers);
    if (cells.empty()) continue;
    std::size_t width = 3;
    for (const std::string& cell : cells) width = std::max(width, cell.size());
    cells.insert(cells.begin() + 1, numbers ? std::string(width - 1, '-') + ":" : std::string(width, '-'));
    for (std::size_t i = 0; i < lines.size(); ++i)
      lines[i] += numbers ? fmt::format(" {:>{}} |", cells[i], width) : fmt::format(" {:<{}} |", cells[i], width);
  }
  for (const std::string& line : lines) std::fprintf(out, "%s\n", line.c_str());
}

}  // namespace sightline::apps
