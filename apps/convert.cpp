// sightline-convert: model files into one RVM, OBJ or glTF file, into a scene cache, or into 3D Tiles.

#include <cstdio>
#include <utility>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/item_copier.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/named_parts.h"
#include "sightline/apps/common/need.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/report_json.h"
#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/common/write_model.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/json/internal/json.h"

namespace {

using namespace sightline;
using apps::need, apps::fail;
using Json = json::Value;
/// Fails unless the file, or the folder of tiles, can be written without loss of one that is read.
core::Expected<void> check(const std::string& output, const std::vector<std::string>& read, bool tiles) {
  const auto done = tiles ? apps::check_tiles_folder(output, read) : apps::check_output(output, read);
  return done ? done : core::fail("OUTPUT: " + done.error().message);
}

/// The parts of a model that are written: those that `only` names, or all where it is empty, without those of `except`.
struct Chosen {
  std::vector<std::string> only, except;
  bool all() const { return only.empty() && except.empty(); }
};

/// Chosen items, with the nodes above them.
core::Scene part_of(const apps::Model& model, const Chosen& chosen) {
  const core::Scene& scene = *model.scene;
  std::vector<bool> items = chosen.only.empty() ? std::vector<bool>(scene.item_slots(), true)
                                                : need(apps::items_named_by(scene, chosen.only, false));
  const std::vector<bool> left_out = need(apps::items_named_by(scene, chosen.except, false));
  bool any = false;
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i] = items[i] && !left_out[i];
    any = any || (items[i] && scene.contains_item(core::ItemId(i)));
  }
  if (!any) fail("--only and --except leave no item to write");
  return need(apps::copy_of_part(scene, model.report.nodes, &items, {}));
}

/// Writes the model, or chosen parts of it. `items` becomes the number of items that were to be written.
importers::WriteReport write(const apps::Model& model, const Chosen& chosen, const std::string& output,
                             importers::WriteOptions options, std::uint64_t& items) {
  apps::Progress bar("writing");
  options.progress = bar.callback();
  const core::Scene& all = *model.scene;
  const std::filesystem::path file = core::platform::path_of(output);
  if (chosen.all()) {
    options.report = &model.report;
    items = all.item_count();
    return need(importers::write_file(all, apps::node_to_write(all, model.report.nodes), file, options));
  }
  const auto part = part_of(model, chosen);
  items = part.item_count();
  return need(
      importers::write_file(part, apps::node_to_write(part, apps::children_of(part, part.root())), file, options));
}

Json tiles_json(const importers::TilesWriteReport& tiles, double tolerance) {
  return {{"tiles", tiles.tiles},
          {"leaves", tiles.leaves},
          {"levels", tiles.levels},
          {"root_error", tiles.root_error},
          {"whole_error", tiles.whole_error},
          {"tolerance", tolerance},
          {"largest_chord_error", tiles.largest_chord_error},
          {"triangles", tiles.triangles},
          {"leaf_triangles", tiles.leaf_triangles},
          {"leaf_bytes", tiles.leaf_bytes},
          {"largest_file", tiles.largest_file},
          {"instances", tiles.instances},
          {"divided", tiles.divided}};
}

Json to_json(const apps::ModelOptions& options, const importers::ImportReport& read, const std::string& output,
             double tolerance, const importers::WriteReport& written) {
  Json tessellation;
  if (written.triangles)
    tessellation = {{"tolerance", tolerance},
                    {"largest_chord_error", written.triangles->largest_chord_error},
                    {"triangles", written.triangles->triangles},
                    {"vertices", written.triangles->vertices}};
  return {{"inputs", options.files},
          {"output", output},
          {"items_in", apps::items_json(read.items)},
          {"items_out", apps::items_json(written.items)},
          {"left_out", written.left_out},
          {"bytes_in", read.bytes},
          {"bytes_out", written.bytes},
          {"tessellation", tessellation},
          {"tiles", written.tiles ? tiles_json(*written.tiles, tolerance) : Json()},
          {"analytic", written.analytic ? Json(*written.analytic) : Json()},
          {"recognition", options.import.recognise ? apps::recognition_json(read.recognition) : Json()},
          {"warnings", apps::warnings_json(read.warnings)}};
}

/// Takes the last file as the output: the command line cannot separate it, since a list of files takes all of them.
core::Expected<void> check(std::string& output, apps::ModelOptions& options, const importers::WriteOptions& writing) {
  output = std::move(options.files.back());
  options.files.pop_back();
  if (auto done = check(output, options.files, writing.tiles); !done) return done;
  const std::string extension = importers::lower_case_extension(core::platform::path_of(output));
  if (!writing.compress && !writing.tiles) return core::fail("--uncompressed: only with --tiles");
  if (writing.collections && !writing.tiles && extension != ".glb" && extension != ".gltf")
    return core::fail("--collections: expected an output ending in .glb or .gltf, found \"" + output + "\"");
  if (writing.levels && extension != ".slc")
    return core::fail("--levels: expected an output ending in .slc, found \"" + output + "\"");
  if (writing.tiles || extension == ".slc") options.import.copies = importers::ImportOptions{}.copies;  // as tools read
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "Reads model files and writes them into one: RVM keeps analytic primitives, OBJ and glTF get triangles, SLC is a "
      "scene cache that every tool starts from fast",
      "sightline-convert",
      "  sightline-convert plant.rvm plant.obj --tolerance 0.005\n"
      "  sightline-convert plant.rvm plant.glb --collections\n"
      "  sightline-convert plant.rvm plant.txt plant-tiles --tiles\n"
      "  sightline-convert plant.rvm plant-tiles --tiles --collections\n"
      "  sightline-convert plant.rvm pumps.glb --only 'PUMP-*' --except PUMP-2\n"
      "  sightline-convert a.rvm b.rvm both.rvm\n"
      "  sightline-convert plant.rvm plant.txt plant.slc\n"
      "  sightline-convert --levels ship.glb ship.slc\n"
      "  sightline-convert --units mm part.stl part.rvm\n"
      "  sightline-convert --recognise triangles.obj primitives.rvm\n"
      "  sightline-convert --lenient damaged.rvm repaired.rvm --json -");
  apps::ModelOptions options;
  std::string output, json_file;
  Chosen chosen;
  importers::WriteOptions writing;
  options.import.copies = importers::MeshCopies::kExact;  // meshes are written as they came
  apps::add_model_options(line, options);
  line.option("MODEL")
      .takes(2, apps::Option::kUnlimited)
      .usage_text("... OUTPUT REQUIRED")
      .described_as(
          "Model files, then the file to write: .rvm, .obj (with .mtl beside it), .glb, .gltf (with .bin beside it), "
          ".stl, .ply or .slc; with --tiles the folder to write");
  line.check([&] { return check(output, options, writing); });
  line.add("--tolerance", writing.tolerance, "Largest distance of triangles from analytic primitives, metres")
      .shows_default()
      .accepted_by(apps::parse_tolerance);
  line.add_flag("--collections", writing.collections,
                "Keep analytic primitives in glTF and 3D Tiles, as rows of parameters for web viewers that know them");
  line.add_flag("--tiles", writing.tiles,
                "Write a folder of 3D Tiles 1.1: a tree of glTF files with proven errors, which web viewers stream");
  line.add_flag("!--uncompressed", writing.compress, "Tiles for viewers without a decoder for EXT_meshopt_compression");
  line.add_flag("--levels", writing.levels,
                "Build levels of detail into a scene cache, so that --lod-error starts fast from it");
  apps::add_part_option(line, "--only", chosen.only, "Write parts alone: " + apps::kPartForms);
  apps::add_part_option(line, "--except", chosen.except, "Write all but these parts, or of --only all but these");
  line.add("--json", json_file, "Write what was read and written as JSON to FILE, or - for stdout");
  return line.run(argc, argv, [&]() -> core::Expected<int> {
    auto model = need(apps::load_model(options));
    core::Scene& scene = *model.scene;
    need(scene.commit());
    if (options.explain) apps::explain(scene);
    need(check(output, apps::files_read(options.files, model.report), writing.tiles));
    std::uint64_t items = 0;
    const auto written = write(model, chosen, output, writing, items);
    if (json_file != "-") std::printf("%s\n", apps::words_of(written, output, items).c_str());
    if (json_file != "-" && options.import.recognise)
      std::printf("%s\n", apps::recognition_words(model.report.recognition).c_str());
    need(apps::write_json(json_file, json::sorted(to_json(options, model.report, output, writing.tolerance, written))));
    return apps::kExitOk;
  });
}
