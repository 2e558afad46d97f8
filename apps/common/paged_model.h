// Scenes that are drawn page by page, in the same way for every tool that can.
#pragma once

#include <string>

#include "sightline/apps/common/model.h"
#include "sightline/engine/paged/paged_engine.h"

namespace sightline::apps {

class CommandLine;

/// "800M", "2G", "1.5G", "123456789": bytes, with K, M, G or T for powers of 1024.
core::Expected<std::size_t> parse_bytes(const std::string& text);

/// --memory LIMIT, into `text`: a mode with options of OptionGroup::kGeneral alone, since others need the whole scene
/// in memory. Add it last.
void add_memory_option(CommandLine& line, std::string& text);

/// Opens the one file or folder that the tool was given. Fails on anything but a scene cache or a folder of them.
core::Expected<engine::PagedEngine> open_paged(const ModelOptions& model, const std::string& memory,
                                               const engine::PagedConfig& config);

/// Errors of pages that could not be read, as one; none where there are none.
core::Expected<void> page_errors(engine::PagedEngine& engine);

}  // namespace sightline::apps
