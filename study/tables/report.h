// Internal to sightline-study: what is printed and what is written of the study's results.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/study/session.h"

namespace sightline::study {

/// All paths of one model; the first is the one that everything was run on.
using ModelResults = std::vector<Results>;

/// The tables of E. T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU" (2009), chapter 4, and ours.
void print_tables(const std::vector<ModelResults>& all);
/// One line a run.
void print_runs(const std::vector<ModelResults>& all);

json::Value to_json(const Results& results);

/// One of the dissertation's figures: times of runs frame by frame, as CSV and SVG.
core::Expected<void> write_figure(const Results& results, const std::string& figure,
                                  const std::vector<const Run*>& runs, const std::filesystem::path& directory);

/// Data and plots of figures 4.1 to 4.16, of limited depth, and of error against time. The directory must exist.
core::Expected<void> write_figures(const ModelResults& results, const std::filesystem::path& directory);

}  // namespace sightline::study
