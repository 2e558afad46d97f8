#include "sightline/tests/hostile/check.h"

#include <array>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "sightline/core/snapshot.h"
#include "sightline/tests/support/links.h"
#include "sightline/tests/support/scene_texts.h"

namespace sightline::hostile {

namespace fs = std::filesystem;

namespace {

using Sizes = std::array<std::size_t, 4>;

Sizes sizes_of(const core::Scene& scene) {
  return {scene.node_count(), scene.item_slots(), scene.mesh_slots(), scene.material_slots()};
}

std::string after_failure(const core::Scene& scene, const Sizes& before, const Case& made, const std::string& message) {
  if (message.find("not enough memory") != message.npos) return message;
  if (message.find(made.files[0].name) == message.npos) return "the error does not name the file: " + message;
  return sizes_of(scene) == before ? "" : "a failed import changed the scene";
}

std::string after_success(core::Scene& scene, const Case& made, bool keeps_bytes,
                          const importers::ImportReport& report) {
  if (report.warnings.size() > importers::kMaxWarnings + 1) return "more warnings than the most";
  if (made.warns && report.warnings.empty()) return "no warning";
  if (!keeps_bytes)
    if (const std::string text = tests::text_that_is_not_utf8(scene, report); !text.empty()) return "not UTF-8: " + text;
  const bool empty = !report.nodes.empty() && scene.item_count() == 0;
  if (empty && report.attributed == 0 && report.warnings.empty()) return "nothing to draw, and no warning";
  if (scene.item_count() < made.least_items) return "items are missing";
  const auto committed = scene.commit();
  if (!committed) return "the scene cannot be committed: " + committed.error().message;
  return core::Snapshot(scene).size() <= scene.item_slots() ? "" : "the snapshot has too many items";
}

}  // namespace

Finding check(const Target& target, const Case& made, bool lenient, const Import& import) {
  core::Scene scene;
  const core::NodeId parent = target.prepare ? scene.root() : scene.add_node(scene.root(), "kept");
  if (target.prepare) target.prepare(scene);
  const Sizes before = sizes_of(scene);
  const auto report = import(scene, parent, {.lenient = lenient});
  Finding found;
  found.imported = report.has_value();
  found.leaked = scene.item_count() > made.most_items || scene.material_slots() > made.most_materials;
  if (!report)
    found.message = report.error().message;
  else if (!report->warnings.empty())
    found.message = report->warnings[0].message;
  found.broken = report ? after_success(scene, made, target.format == "slc", *report)
                        : after_failure(scene, before, made, report.error().message);
  const Expect wanted = lenient ? made.lenient : made.strict;
  if (found.broken.empty() && wanted == Expect::kSuccess && !report) found.broken = "refused: " + found.message;
  if (found.broken.empty() && wanted == Expect::kFailure && report) found.broken = "not refused";
  return found;
}

Folder::Folder() : path_(fs::temp_directory_path() / fmt::format("sightline_hostile_{}", getpid())) {
  clear();
}

Folder::~Folder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path Folder::write(const Case& made) {
  clear();
  for (const File& file : made.files) {
    const fs::path path = models() / file.name;
    if (file.link_to.empty())
      std::ofstream(path, std::ios::binary) << content(file);
    else
      tests::make_link(file.link_to, path);  // where there are no links, nothing is read by one
  }
  return models() / made.files[0].name;
}

std::string Folder::content(const File& file) const {
  std::string content = file.content;
  if (const std::size_t at = content.find(kOutside); at != content.npos)
    content.replace(at, kOutside.size(), path_.generic_string());  // escapes nothing
  return content;
}

std::string Folder::shortened(std::string message) const {
  for (const std::string& prefix : {models().string() + "/", path_.string()})
    for (std::size_t at; (at = message.find(prefix)) != message.npos;) message.erase(at, prefix.size());
  return message;
}

void Folder::clear() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  fs::create_directories(models());
}

}  // namespace sightline::hostile
