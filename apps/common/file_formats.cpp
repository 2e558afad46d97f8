#include "sightline/apps/common/file_formats.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "sightline/importers/import.h"
#include "sightline/importers/internal/extension.h"

namespace sightline::apps {
namespace {

/// Which extensions there are is for the importers to say. One without a name here has itself as its name.
constexpr std::pair<std::string_view, std::string_view> kModelNames[] = {
    {".rvm", "AVEVA RVM"},     {".rev", "AVEVA RVM"}, {".txt", "Attributes"}, {".att", "Attributes"},
    {".obj", "Wavefront OBJ"}, {".ply", "PLY"},       {".stl", "STL"},        {".slc", "Scene cache"},
    {".gltf", "glTF"},         {".glb", "glTF"},      {".vtk", "VTK"},        {".vtm", "VTK"},
    {".vtmb", "VTK"},          {".vtp", "VTK"},       {".vtu", "VTK"},        {".step", "STEP"},
    {".stp", "STEP"},          {".stpz", "STEP"},     {".iges", "IGES"},      {".igs", "IGES"},
    {".brep", "BREP"}};

std::string model_name(std::string_view extension) {
  for (const auto& [known, name] : kModelNames)
    if (known == extension) return std::string(name);
  return std::string(extension.substr(1));
}

}  // namespace

bool FileFormat::has(const std::filesystem::path& file) const {
  return std::find(extensions.begin(), extensions.end(), importers::lower_case_extension(file)) != extensions.end();
}

std::vector<FileFormat> model_formats() {
  std::vector<FileFormat> formats;
  for (const std::string_view extension : importers::known_extensions()) {
    const std::string name = model_name(extension);
    auto format =
        std::find_if(formats.begin(), formats.end(), [&](const FileFormat& known) { return known.name == name; });
    if (format == formats.end()) format = formats.insert(format, {name, {}});
    format->extensions.emplace_back(extension);
  }
  return formats;
}

std::vector<FileFormat> written_formats() {
  std::vector<FileFormat> formats;
  for (const char* extension : {".glb", ".gltf", ".rvm", ".obj", ".stl", ".ply", ".slc"}) {
    const std::string name = model_name(extension);
    if (formats.empty() || formats.back().name != name) formats.push_back({name, {}});
    formats.back().extensions.emplace_back(extension);
  }
  return formats;
}

FileFormat png_format() {
  return {"PNG", {".png"}};
}

FileFormat jpeg_format() {
  return {"JPEG", {".jpg", ".jpeg"}};
}

FileFormat json_format() {
  return {"JSON", {".json"}};
}

FileFormat bcf_format() {
  return {"BCF", {".bcfzip", ".bcf"}};
}

}  // namespace sightline::apps
