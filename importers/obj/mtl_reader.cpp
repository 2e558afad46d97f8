#include "sightline/importers/obj/internal/mtl_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/internal/side_files.h"

namespace sightline::importers::obj {
namespace {

namespace fs = std::filesystem;

std::string_view without_quotes(std::string_view name) {
  const bool quotes = name.size() >= 2 && name.front() == '"' && name.back() == '"';
  return quotes ? name.substr(1, name.size() - 2) : name;
}

using Names = std::vector<std::string>;

/// Names that end with .mtl, and may hold spaces.
Names split_behind_extensions(std::string_view arguments) {
  constexpr std::string_view kExtension = ".mtl";
  const std::string lower = core::lower_case(arguments);
  Names names;
  std::size_t begin = 0;
  for (std::size_t at = 0; (at = lower.find(kExtension, at)) != lower.npos;) {
    at += kExtension.size();
    if (at < lower.size() && !is_space(lower[at])) continue;
    names.emplace_back(without_quotes(trimmed(arguments.substr(begin, at - begin))));
    begin = at;
  }
  if (const std::string_view rest = trimmed(arguments.substr(begin)); !rest.empty()) names.emplace_back(rest);
  return names;
}

Names split_at_spaces(std::string_view arguments) {
  Names names;
  TextScanner words(std::as_bytes(std::span(arguments)));
  for (std::string_view word; !(word = words.word()).empty();) names.emplace_back(without_quotes(word));
  return names;
}

/// A single number is grey, as the format's description has it. Nothing for other words.
std::optional<core::vec3> colour_of(std::string_view arguments) {
  TextScanner words(std::as_bytes(std::span(arguments)));
  std::array<double, 3> channels{};
  words.number(channels[0]);
  if (words.number(channels[1]) == TextScanner::Found::kEnd)
    channels[1] = channels[2] = channels[0];
  else
    words.number(channels[2]);
  core::vec3 colour;
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(channels[std::size_t(i)])) return {};
    colour[i] = float(std::clamp(channels[std::size_t(i)], 0.0, 1.0));
  }
  return colour;
}

std::optional<double> number_of(std::string_view arguments) {
  TextScanner words(std::as_bytes(std::span(arguments)));
  if (arguments.starts_with("-halo")) words.word();
  double value = 0.0;
  words.number(value);
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

/// One library on its way in.
struct MaterialLibraries::Reading {
  Reading(MaterialLibraries& to, std::string_view text) : libraries(to), lines(text) {}

  void run() {
    for (std::string_view line; lines.next(line);) statement(line);
    end_material();
  }

  void statement(std::string_view line) {
    TextScanner words(std::as_bytes(std::span(line)));
    const std::string key = core::lower_case(words.word());
    if (key.empty()) return;
    if (key[0] == '#') return comment(line);
    const std::string_view rest = words.rest_of_line(), numbers = rest.substr(0, rest.find('#'));
    if (key == "newmtl")
      begin_material(rest);
    else if (key == "kd")
      take_diffuse(numbers, line);
    else if (key == "d")
      take(material.dissolve, number_of(numbers), line);
    else if (key == "tr")
      take(material.transparency, number_of(numbers), line);
    else if (key == "map_kd")
      material.texture = name_without_comment(rest);
  }

  /// These programs write opacity as Tr, and name themselves at the begin.
  void comment(std::string_view line) {
    const std::string lower = core::lower_case(line);
    for (const std::string_view writer : {"meshlab", "visualization toolkit"})
      tr_is_opacity = tr_is_opacity || lower.find(writer) != lower.npos;
  }

  void begin_material(std::string_view name) {
    end_material();
    if (!is_utf8(name)) guessed.add(lines, name);
    material.name = utf8_by_guess(name);
    named = true;
  }

  void end_material() {
    if (tr_is_opacity && material.transparency) material.transparency = 1.0 - *material.transparency;
    if (named) libraries.keep(material);
    material = {};
  }

  void take_diffuse(std::string_view numbers, std::string_view line) {
    take(material.diffuse, colour_of(numbers), line);
    TextScanner words(std::as_bytes(std::span(numbers)));
    for (int i = 0; i < 3; ++i) words.word();
    if (!words.word().empty()) fourth.add(lines, trimmed(line));
  }

  /// A value that cannot be read loses itself alone.
  template <class Value>
  void take(std::optional<Value>& to, std::optional<Value> value, std::string_view line) {
    if (value)
      to = value;
    else
      unreadable.add(lines, trimmed(line));
  }

  MaterialLibraries& libraries;
  StatementLines lines;
  LibraryMaterial material;
  bool named = false, tr_is_opacity = false;
  Noticed unreadable, guessed, fourth;
};

void MaterialLibraries::open(std::string_view arguments, const StatementLines& at) {
  if (!asked_.insert(std::string(arguments)).second) return;
  const std::string_view clean = without_quotes(name_without_comment(arguments));
  const std::array<Names, 4> splits = {Names{std::string(arguments)}, Names{std::string(clean)},
                                       split_behind_extensions(clean), split_at_spaces(clean)};
  for (const bool guess : {false, true})
    for (const Names& names : splits)
      if (open_all(names, guess, at)) return;
  const auto found = [&](const std::string& name) { return find_named_file(model_, name).has_value(); };
  const bool words = std::any_of(splits[3].begin(), splits[3].end(), found);
  for (const std::string& name : words ? splits[3] : splits[2])
    if (const auto path = find_named_file(model_, name); !open_all({name}, true, at) && !path)
      job_.warn(at.offset(),
                fmt::format("line {}: material file {}", at.number(), utf8_by_guess(path.error().message)));
}

bool MaterialLibraries::open_all(const Names& names, bool guess, const StatementLines& at) {
  std::vector<fs::path> paths;
  Names guesses;
  for (const std::string& name : names) {
    auto path = find_named_file(model_, name);
    if (!path && guess) {
      path = find_similar_file(model_, name);
      if (path)
        guesses.push_back(fmt::format("{} not found; {} is read", excerpt(name), excerpt(path->filename().string())));
    }
    if (!path) return false;
    paths.push_back(std::move(*path));
  }
  for (const std::string& told : guesses)
    job_.warn(at.offset(), fmt::format("line {}: material file {}", at.number(), told));
  for (const fs::path& path : paths) read(path, at);
  return !paths.empty();
}

void MaterialLibraries::read(const fs::path& path, const StatementLines& at) {
  if (!known_.insert(path).second) return;
  const auto bytes = read_side_file(model_, path.string());
  if (!bytes) {
    job_.warn(at.offset(), fmt::format("line {}: material file {}", at.number(), utf8_by_guess(bytes.error().message)));
    return;
  }
  const auto wide = utf8_from_utf16(*bytes);
  Reading reading(*this, wide ? std::string_view(*wide)
                              : std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
  reading.run();
  const auto tell = [&](const Noticed& noticed, std::string_view what) {
    if (noticed.count > 0)
      job_.warn(at.offset(), fmt::format("{}: line {}: {} {}, the first {}", utf8_by_guess(path.filename().string()),
                                         noticed.line, noticed.count, what, noticed.first));
  };
  tell(reading.unreadable, "values that are no numbers left out");
  tell(reading.fourth, "colours with more than three numbers, of which three count");
  tell(reading.guessed, "names that are not UTF-8, taken for Windows-1252");
}

void MaterialLibraries::keep(LibraryMaterial& material) {
  const auto [at, added] = place_of_name_.try_emplace(material.name, materials_.size());
  if (!added) return;
  // A name with a comment behind it is found by either.
  if (const std::string_view bare = name_without_comment(material.name); bare != material.name)
    place_of_name_.try_emplace(std::string(bare), materials_.size());
  materials_.push_back(std::move(material));
}

const LibraryMaterial* MaterialLibraries::find(std::string_view name) const {
  auto at = place_of_name_.find(name);
  if (at == place_of_name_.end()) at = place_of_name_.find(name_without_comment(name));
  return at == place_of_name_.end() ? nullptr : &materials_[at->second];
}

}  // namespace sightline::importers::obj
