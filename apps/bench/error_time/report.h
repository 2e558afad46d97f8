// Prints and writes the figures of sightline-bench error-time. Internal to it.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/bench/error_time/error_time.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

struct NamedModel {
  std::string name;
  std::size_t items = 0;
  std::vector<ModelResult> views;
};

/// Prints tables that are also Markdown.
void print(const KindResult& result, std::FILE* out);
void print(const NamedModel& model, std::FILE* out);

/// Compares GLSL with triangles of 24 segments (or the finest available), one line for each kind or view.
void print_summary(const std::vector<KindResult>& results, std::FILE* out);
void print_summary(const std::vector<NamedModel>& models, std::FILE* out);

json::Value to_json(const KindResult& result);
json::Value to_json(const NamedModel& model);

/// One line for each form, with a header.
std::string to_csv(const std::vector<KindResult>& results);
std::string to_csv(const std::vector<NamedModel>& models);

/// Writes PREFIX-silhouette.svg, -depth.svg and -normal.svg: mean error against milliseconds, a panel for each kind.
core::Expected<void> write_plots(const std::vector<KindResult>& results, const std::string& prefix);
/// Writes PREFIX-time.svg and -bytes.svg: mean FLIP against milliseconds and GPU memory, a panel for each view.
core::Expected<void> write_plots(const std::vector<NamedModel>& models, const std::string& prefix);

}  // namespace sightline::bench
