// Zip archives in memory.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "sightline/core/error.h"

namespace sightline::apps {

/// Contents by path, with slashes.
using ZipEntries = std::map<std::string, std::string>;

/// The bytes of an archive.
core::Expected<std::string> zip(const ZipEntries& entries);

/// All files of an archive, folders apart; backslashes become slashes. Fails on damage, on encrypted files, on paths
/// that lead outside the archive (absolute ones, those with "..") and where the files together have more than
/// `most_bytes` bytes: none is unpacked beyond that, whatever size it claims.
core::Expected<ZipEntries> unzip(std::string_view bytes, std::uint64_t most_bytes);

}  // namespace sightline::apps
