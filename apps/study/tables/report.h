// Internal to sightline-study: tables, plots and JSON of the study's results.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "sightline/apps/study/session.h"
#include "sightline/core/error.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::study {

/// The tables of E. T. Carlos, "Frustum Culling Híbrido Utilizando CPU e GPU" (2009), chapter 4, and ours.
void print_tables(const std::vector<Results>& all, std::FILE* out);
/// One line a run.
void print_runs(const std::vector<Results>& all, std::FILE* out);

json::Value to_json(const Results& results);

/// Plots one of the dissertation's figures as SVG: times of runs, frame by frame. The directory must exist.
core::Expected<void> write_plot(const Results& results, const std::string& figure, const std::vector<const Run*>& runs,
                                const std::string& directory);
/// Plots figures 4.1 to 4.10 and 4.13 to 4.16. The directory must exist.
core::Expected<void> write_plots(const Results& results, const std::string& directory);

}  // namespace sightline::study
