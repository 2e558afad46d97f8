// Names and extensions of the files that tools read and write, as people are asked for them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sightline::apps {

struct FileFormat {
  std::string name;                     ///< for example "glTF"
  std::vector<std::string> extensions;  ///< with dots, in lower case; the first one is that of new files

  /// By its extension, in any case.
  bool has(const std::filesystem::path& file) const;
  friend bool operator==(const FileFormat&, const FileFormat&) = default;
};

std::vector<FileFormat> model_formats();  ///< that this build reads: importers::known_extensions()
std::vector<FileFormat> written_formats();  ///< of models
FileFormat png_format();
FileFormat jpeg_format();
FileFormat json_format();  ///< of views and camera paths
FileFormat bcf_format();   ///< of views

}  // namespace sightline::apps
