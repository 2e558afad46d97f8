// Attacks on the readers: files that are damaged or made to harm. A table of them against all formats is what
// hostile_table.cpp prints.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::hostile {

/// Stands for the folder above the model's directory, in a file's content.
inline constexpr std::string_view kOutside = "@OUTSIDE@";

/// A file, or a link when `link_to` is not empty. The name is relative to the model's directory.
struct File {
  std::string name, content, link_to = {};
};

/// What an import is given. The first file is the model.
struct Case {
  std::vector<File> files;
  /// More than these in the scene: something was read that lies outside the model's directory.
  std::size_t most_items = std::numeric_limits<std::size_t>::max();
  std::size_t most_materials = std::numeric_limits<std::size_t>::max();
};

struct Attack {
  std::string name;
  std::size_t cases = 0;
  std::function<Case(std::size_t)> make;  ///< 0 … cases - 1
};

/// What is attacked: files with this extension, seeds in tests/fuzz/corpus/FORMAT.
struct Target {
  std::string format, extension;
  std::vector<Attack> attacks;  ///< beside truncation and mutation, which every format gets
};

namespace gltf {
std::vector<Attack> attacks();
std::vector<Attack> binary_attacks();
}  // namespace gltf
namespace json {
std::vector<Attack> attacks();
}
namespace obj {
std::vector<Attack> attacks();
}
namespace polygon_file {
std::vector<Attack> ply_attacks();
std::vector<Attack> stl_attacks();
}  // namespace polygon_file
namespace rvm {
std::vector<Attack> attacks();
std::vector<Attack> attribute_attacks();
}  // namespace rvm
namespace vtk {
std::vector<Attack> legacy_attacks();
std::vector<Attack> polygon_attacks();
std::vector<Attack> block_attacks();
}  // namespace vtk

/// Text over and over.
std::string repeated(const std::string& text, std::size_t times);

}  // namespace sightline::hostile
