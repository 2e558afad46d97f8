// Linked programs kept in a folder from run to run, in the form that the driver itself gives out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/gl/functions.h"

namespace sightline::gl {

/// Entries are told apart by the driver (vendor, renderer, version) and by a key of the caller's, to the last byte.
/// Whatever goes wrong only costs the time to compile: entries that are damaged, cut short or not ours are passed over
/// and written anew; without a folder, the right to write or room on the disk nothing is kept. Several processes may
/// share a folder: an entry appears whole or not at all.
///
/// A driver without program binaries (GL_NUM_PROGRAM_BINARY_FORMATS is 0) makes it do nothing; so does Mesa's llvmpipe
/// where its own cache is switched off.
class ProgramCache {
 public:
  static constexpr std::uintmax_t kMostBytes = 64u << 20;

  /// For the current context. The folder is made when the first entry is. Beyond `most_bytes` the entries that were not
  /// used for longest go.
  ProgramCache(const Functions& gl, std::filesystem::path folder, std::uintmax_t most_bytes = kMostBytes);

  /// "sightline" in XDG_CACHE_HOME, else in .cache in HOME, on Windows in LOCALAPPDATA; empty when none of them is set.
  static std::filesystem::path default_folder();

  /// False when there is nothing that can be kept.
  bool enabled() const { return !formats_.empty(); }
  /// Links `program` from what was stored under `key`. False, and it is not linked, when there is nothing of use.
  bool load(const Functions& gl, GLuint program, std::string_view key) const;
  /// Keeps a program, linked with GL_PROGRAM_BINARY_RETRIEVABLE_HINT.
  void store(const Functions& gl, GLuint program, std::string_view key) const;

 private:
  std::filesystem::path place_of(std::string_view key) const;
  void drop_oldest() const;

  std::filesystem::path folder_;
  std::uintmax_t most_bytes_;
  std::string driver_;
  std::vector<GLenum> formats_;
};

}  // namespace sightline::gl
