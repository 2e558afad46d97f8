// The promises that an import of a case must keep, in a process of its own (hostile_table) or in a test.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile {

struct Finding {
  bool imported = false;
  bool leaked = false;  ///< the scene holds more than the case allows: something outside the model's directory was read
  std::string message;  ///< the error, or the first warning
  std::string broken;   ///< the promise that was not kept, or empty
};

using Import =
    std::function<core::Expected<importers::ImportReport>(core::Scene&, core::NodeId, const importers::ImportOptions&)>;

/// Calls `import` with a scene that holds what the target needs, strict or lenient. After a failure the scene must be
/// unchanged and the error name the model. After a success it must be possible to commit the scene and to make a
/// snapshot of it. The outcome must be that of the case, and memory must suffice.
Finding check(const Target& target, const Case& made, bool lenient, const Import& import);

/// A folder for one case's files: FOLDER/models holds the model, FOLDER what lies outside.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  /// Writes the files in place of those of the case before. Returns the model.
  std::filesystem::path write(const Case& made);
  /// Where the model lies.
  std::filesystem::path models() const { return path_ / "models"; }
  /// The content as it is written, where kOutside is a folder's name.
  std::string content(const File& file) const;
  /// A message without where the folder lies.
  std::string shortened(std::string message) const;

 private:
  void clear();  ///< makes the folder, and leaves it empty
  std::filesystem::path path_;
};

}  // namespace sightline::hostile
