// Internal to sightline-bench error-time: what is printed and written of its figures.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "sightline/bench/error_time/error_time.h"

namespace sightline::bench {

struct NamedModel {
  std::string name;
  std::size_t items = 0;
  std::vector<ModelResult> views;
};

/// Tables that are Markdown, too.
void print(const KindResult& result, std::FILE* out);
void print(const NamedModel& model, std::FILE* out);

/// GLSL against triangles with 24 segments (or the finest that there are), a line for each kind or view.
void print_summary(const std::vector<KindResult>& results, std::FILE* out);
void print_summary(const std::vector<NamedModel>& models, std::FILE* out);

nlohmann::ordered_json to_json(const KindResult& result);
nlohmann::ordered_json to_json(const NamedModel& model);

/// A line for each form, with a header.
std::string to_csv(const std::vector<KindResult>& results);
std::string to_csv(const std::vector<NamedModel>& models);

/// PREFIX-silhouette.svg, -depth.svg and -normal.svg: mean error against milliseconds, a panel for each kind.
core::Expected<void> write_plots(const std::vector<KindResult>& results, const std::string& prefix);
/// PREFIX-time.svg and -bytes.svg: mean FLIP against milliseconds and GPU memory, a panel for each view.
core::Expected<void> write_plots(const std::vector<NamedModel>& models, const std::string& prefix);

}  // namespace sightline::bench
