// Internal to the reader of OBJ: what the statements of a file say, before it becomes a scene.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/obj/internal/mtl_reader.h"
#include "sightline/importers/obj/internal/statement_lines.h"

namespace sightline::importers::obj {

struct Corner {
  std::uint32_t position = 0, normal = core::kNone;
  friend bool operator==(const Corner&, const Corner&) = default;
};

/// Faces belong to an object, a group and a material, by the numbers of their names; kNone where there is none.
struct Place {
  std::uint32_t object = core::kNone, group = core::kNone, material = core::kNone;
  friend auto operator<=>(const Place&, const Place&) = default;
};

/// Faces of one place: corners back to back, and the number of corners of each face (none: all are triangles).
struct Part {
  Place place;
  std::uint64_t offset = 0, line = 0;  // of the first face
  std::vector<Corner> corners;
  std::vector<std::uint32_t> face_sizes;
};

struct Name {
  std::string text;  // decoded
  std::uint64_t offset = 0, line = 0;
};

struct Model {
  std::vector<core::dvec3> positions;
  std::vector<core::vec3> normals;  // zero where the file has no direction
  std::vector<core::vec3> colours;  // of the first positions, NaN where there is none
  std::vector<Name> names;
  std::vector<Part> parts;  // in order of appearance
};

/// Adds nodes, materials and items.
core::Expected<void> add_to_scene(ImportJob& job, Model& model, MaterialLibraries& libraries);

}  // namespace sightline::importers::obj
