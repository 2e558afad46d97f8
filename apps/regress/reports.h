// What a run of a suite gave, for people, for CI and for programs.
#pragma once

#include "sightline/apps/regress/task_result.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

struct Outcome {
  const Task* task;
  std::optional<TaskResult> result;
  Status status = Status::kMissing;
  std::string reason;  ///< one line; empty for what passed
};

/// Outcomes of these tasks in the suite's order, whoever drew them in whatever order.
std::vector<Outcome> outcomes(const Suite& suite, const ResultFolder& results, const std::vector<std::size_t>& tasks);
std::size_t count(const std::vector<Outcome>& outcomes, Status status);
/// Whether all passed or were accepted.
bool all_good(const std::vector<Outcome>& outcomes);

/// "14 images: 12 passed, 1 failed, 1 error"
std::string summary(const std::vector<Outcome>& outcomes);
json::Value to_json(const Suite& suite, const std::vector<Outcome>& outcomes);
/// As JUnit writes it, and CI servers read: a test suite a model, a test case a view.
std::string junit_xml(const Suite& suite, const std::vector<Outcome>& outcomes);

enum class ShownImages : std::uint8_t { kNone, kFailed, kAll };
/// One page that holds its images: reference, image and difference of each task in one place, to flip through.
/// `suite_file`: for the commands that draw them again.
core::Expected<std::string> html_report(const Suite& suite, const ResultFolder& results,
                                        const std::vector<Outcome>& outcomes, ShownImages shown,
                                        const std::string& suite_file);

}  // namespace sightline::apps
