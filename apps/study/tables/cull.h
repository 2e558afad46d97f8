// Internal to sightline-study: the models that the subcommands cull and cull-gpu share.
#pragma once

#include <string>
#include <vector>

#include "sightline/apps/study/session.h"
#include "sightline/core/error.h"

namespace sightline::apps {
class CommandLine;
}

namespace sightline::study {

struct CullOptions {
  std::string plots, json;
  int frames = 120, passes = 3, samples = 10;
  double scale = 1.0;
  std::vector<std::string> only, variants;
};

void add_options(apps::CommandLine& line, CullOptions& options);

/// The generated models that are wanted and those of files, prepared; at least one.
core::Expected<std::vector<Model>> make_models(const CullOptions& options);

SessionOptions session_of(const Model& model, const CullOptions& options);

}  // namespace sightline::study
