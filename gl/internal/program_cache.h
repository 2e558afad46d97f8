// Cache of linked programs in a folder, from run to run, in the driver's own binary form.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/gl/functions.h"

namespace sightline::gl {

/// The driver (vendor, renderer, version) and a key from the caller identify an entry; both must match exactly. Any
/// failure only costs the time to compile. Entries that are damaged, cut short or foreign are ignored and written anew.
/// Without a folder, write permission or disk space nothing is kept. Several processes may share a folder: an entry
/// appears whole or not at all.
///
/// Does nothing with a driver that has no program binaries (GL_NUM_PROGRAM_BINARY_FORMATS is 0), nor with Mesa's
/// llvmpipe when its own cache is switched off.
class ProgramCache {
 public:
  static constexpr std::uintmax_t kMostBytes = 64u << 20;

  /// For the current context. The first entry creates the folder. Above `most_bytes`, the least recently used entries
  /// are deleted.
  ProgramCache(const Functions& gl, std::filesystem::path folder, std::uintmax_t most_bytes = kMostBytes);

  /// "sightline" in XDG_CACHE_HOME, otherwise in .cache in HOME, on Windows in LOCALAPPDATA; empty when none of them is
  /// set.
  static std::filesystem::path default_folder();

  /// False when nothing can be kept.
  bool enabled() const { return !formats_.empty(); }
  /// Whether there is an entry of `key`.
  bool has(std::string_view key) const { return find(key).has_value(); }
  /// Links `program` from the entry of `key`, with the bindings of its blocks, textures and images as they were when it
  /// was stored. False when there is no usable entry; then it is not linked.
  bool load(const Functions& gl, GLuint program, std::string_view key) const;
  /// Stores a program, which must be linked with GL_PROGRAM_BINARY_RETRIEVABLE_HINT.
  void store(const Functions& gl, GLuint program, std::string_view key) const;

  /// What was remembered of the driver under a key; none where nothing can be kept.
  std::optional<std::string> recall(std::string_view key) const;
  void remember(std::string_view key, std::string_view text) const;

 private:
  struct Entry {
    GLenum format;  ///< GL_NONE for what is not a program
    std::string bytes;
  };
  std::optional<Entry> find(std::string_view key) const;
  void keep(std::string_view key, GLenum format, std::string_view bytes) const;
  std::filesystem::path place_of(std::string_view key) const;
  void drop_oldest() const;

  std::filesystem::path folder_;
  std::uintmax_t most_bytes_;
  std::string driver_;
  std::vector<GLenum> formats_;
};

}  // namespace sightline::gl
