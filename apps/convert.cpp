// sightline-convert: model files into one RVM, OBJ or glTF file, or into a scene cache.

#include <cctype>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/common/progress.h"
#include "sightline/apps/common/report_json.h"
#include "sightline/importers/gltf/gltf_writer.h"
#include "sightline/importers/json/internal/json.h"
#include "sightline/importers/obj/obj_writer.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/importers/slc/slc_writer.h"

namespace {

using namespace sightline;
using Json = json::Value;
using ItemCounts = std::array<std::uint64_t, core::kKindCount>;

/// Triangles that stand for primitives.
struct Tessellated {
  std::uint64_t triangles = 0, vertices = 0;
  double largest_chord_error = 0.0;
};

/// Report of a written file, in any format.
struct Written {
  ItemCounts items{};
  std::uint64_t left_out = 0, bytes = 0;
  std::optional<Tessellated> triangles;   ///< none in RVM, which keeps primitives
  std::optional<std::uint64_t> analytic;  ///< of glTF
};

std::string extension_of(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

/// The last file is the one to write. The command line cannot separate it: a list of files takes all of them.
core::Expected<std::string> take_output(std::vector<std::string>& files) {
  std::string output = std::move(files.back());
  files.pop_back();
  const std::string extension = extension_of(output);
  if (extension != ".rvm" && extension != ".obj" && extension != ".glb" && extension != ".gltf" && extension != ".slc")
    return core::fail("OUTPUT: expected a name ending in .rvm, .obj, .glb, .gltf or .slc, found \"" + output + "\"");
  for (const std::string& file : files) {
    std::error_code absent;
    if (std::filesystem::equivalent(file, output, absent) && !absent)
      return core::fail("OUTPUT: " + output + " is also a model to read, and would be lost: give it another name");
  }
  return output;
}

/// All items of the scene, and the size of the file.
Written whole(const core::Scene& scene, const std::string& output) {
  Written written;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item)) ++written.items[std::size_t(scene.kind(item))];
  std::error_code ignored;
  written.bytes = std::filesystem::file_size(output, ignored);
  return written;
}

core::Expected<Written> write_as_rvm(const core::Scene& scene, core::NodeId top, const std::string& output) {
  apps::Progress bar("writing");
  if (auto done = importers::write_rvm(scene, top, output, bar.callback()); !done) return tl::unexpected(done.error());
  return whole(scene, output);
}

core::Expected<Written> write_as_slc(const core::Scene& scene, const importers::ImportReport& read,
                                     const std::string& output, bool levels) {
  apps::Progress bar("writing");
  if (auto done = importers::write_slc(scene, output, {.report = &read, .levels = levels, .progress = bar.callback()});
      !done)
    return tl::unexpected(done.error());
  return whole(scene, output);
}

core::Expected<Written> write_as_obj(const core::Scene& scene, core::NodeId top, const std::string& output,
                                     double tolerance) {
  apps::Progress bar("writing");
  const auto report = importers::write_obj(scene, top, output, {.tolerance = tolerance, .progress = bar.callback()});
  if (!report) return tl::unexpected(report.error());
  return Written{report->items,
                 report->left_out,
                 report->bytes,
                 Tessellated{report->triangles, report->vertices, report->largest_chord_error},
                 {}};
}

core::Expected<Written> write_as_gltf(const core::Scene& scene, core::NodeId top, const std::string& output,
                                      double tolerance, bool collections) {
  apps::Progress bar("writing");
  const auto report = importers::write_gltf(
      scene, top, output, {.tolerance = tolerance, .collections = collections, .progress = bar.callback()});
  if (!report) return tl::unexpected(report.error());
  return Written{report->items, report->left_out, report->bytes,
                 Tessellated{report->triangles, report->vertices, report->largest_chord_error}, report->analytic};
}

std::uint64_t total(const ItemCounts& items) {
  std::uint64_t sum = 0;
  for (const std::uint64_t n : items) sum += n;
  return sum;
}

Json to_json(const apps::ModelOptions& options, const importers::ImportReport& read, const std::string& output,
             double tolerance, const Written& written) {
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
          {"analytic", written.analytic ? Json(*written.analytic) : Json()},
          {"recognition", options.import.recognise ? apps::recognition_json(read.recognition) : Json()},
          {"warnings", apps::warnings_json(read.warnings)}};
}

void print(const importers::ImportReport& read, const std::string& output, const Written& written) {
  std::printf("%s: %llu of %llu items, %llu bytes", output.c_str(), (unsigned long long)total(written.items),
              (unsigned long long)total(read.items), (unsigned long long)written.bytes);
  if (written.triangles)
    std::printf(", %llu triangles, at most %.3g m from the primitives they stand for",
                (unsigned long long)written.triangles->triangles, written.triangles->largest_chord_error);
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line(
      "Reads model files and writes them into one: RVM keeps analytic primitives, OBJ and glTF get triangles, SLC is a "
      "scene cache that every tool starts from fast",
      "sightline-convert",
      "  sightline-convert plant.rvm plant.obj --tolerance 0.005\n"
      "  sightline-convert plant.rvm plant.glb --collections\n"
      "  sightline-convert a.rvm b.rvm both.rvm\n"
      "  sightline-convert plant.rvm plant.txt plant.slc\n"
      "  sightline-convert --levels ship.glb ship.slc\n"
      "  sightline-convert --units mm part.stl part.rvm\n"
      "  sightline-convert --recognise triangles.obj primitives.rvm\n"
      "  sightline-convert --lenient damaged.rvm repaired.rvm --json -");
  apps::ModelOptions options;
  std::string output, json_file;
  double tolerance = importers::ObjWriteOptions{}.tolerance;
  bool collections = false, levels = false;
  options.import.copies = importers::MeshCopies::kExact;  // meshes are written as they came
  apps::add_model_options(line, options);
  line.option("MODEL")
      .takes(2, apps::Option::kUnlimited)
      .usage_text("... OUTPUT REQUIRED")
      .described_as(
          "Model files, then the file to write: .rvm, .obj (with .mtl beside it), .glb, .gltf (with .bin beside it) or "
          ".slc");
  line.check([&]() -> core::Expected<void> {
    auto taken = take_output(options.files);
    if (!taken) return tl::unexpected(taken.error());
    output = std::move(*taken);
    if (collections && extension_of(output) != ".glb" && extension_of(output) != ".gltf")
      return core::fail("--collections: expected an output ending in .glb or .gltf, found \"" + output + "\"");
    if (levels && extension_of(output) != ".slc")
      return core::fail("--levels: expected an output ending in .slc, found \"" + output + "\"");
    if (extension_of(output) == ".slc") options.import.copies = importers::ImportOptions{}.copies;  // as tools read
    return {};
  });
  line.add("--tolerance", tolerance, "Largest distance of OBJ and glTF triangles from analytic primitives, metres")
      .shows_default()
      .accepted_by(apps::parse_tolerance);
  line.add_flag("--collections", collections,
                "Keep analytic primitives in glTF, as rows of parameters for web viewers that know them");
  line.add_flag("--levels", levels,
                "Build levels of detail into a scene cache, so that --lod-error starts fast from it");
  line.add("--json", json_file, "Write what was read and written as JSON to FILE, or - for stdout");
  return line.run(argc, argv, [&]() -> core::Expected<int> {
    auto model = apps::load_model(options);
    if (!model) return tl::unexpected(model.error());
    core::Scene& scene = *model->scene;
    if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
    if (options.explain) apps::explain(scene);
    // One input file is written as itself; several become the groups of one file.
    const core::NodeId top = model->report.nodes.size() == 1 ? model->report.nodes[0] : scene.root();
    const std::string extension = extension_of(output);
    const auto written = extension == ".rvm"   ? write_as_rvm(scene, top, output)
                         : extension == ".slc" ? write_as_slc(scene, model->report, output, levels)
                         : extension == ".obj" ? write_as_obj(scene, top, output, tolerance)
                                               : write_as_gltf(scene, top, output, tolerance, collections);
    if (!written) return tl::unexpected(written.error());
    if (json_file != "-") print(model->report, output, *written);
    if (json_file != "-" && options.import.recognise)
      std::printf("%s\n", apps::recognition_words(model->report.recognition).c_str());
    if (json_file.empty()) return apps::kExitOk;
    if (auto done = apps::write_text(
            json_file, apps::to_text(json::sorted(to_json(options, model->report, output, tolerance, *written))));
        !done)
      return tl::unexpected(done.error());
    return apps::kExitOk;
  });
}
