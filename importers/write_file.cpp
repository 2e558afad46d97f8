#include "sightline/importers/write_file.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "sightline/importers/gltf/gltf_writer.h"
#include "sightline/importers/internal/extension.h"
#include "sightline/importers/obj/obj_writer.h"
#include "sightline/importers/ply/internal/ply_writer.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/importers/slc/slc_writer.h"
#include "sightline/importers/stl/internal/stl_writer.h"

namespace sightline::importers {
namespace {

/// All items below the node, and the size of the file.
core::Expected<WriteReport> whole(const core::Expected<void>& done, const core::Scene& scene, core::NodeId top,
                                  const std::filesystem::path& path) {
  if (!done) return tl::unexpected(done.error());
  WriteReport written;
  scene.for_each_node(top, [&](core::NodeId node, const auto&...) {
    for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item))
      ++written.items[std::size_t(scene.kind(item))];
  });
  std::error_code ignored;
  written.bytes = std::filesystem::file_size(path, ignored);
  return written;
}

template <class Report>
core::Expected<WriteReport> tessellated(const core::Expected<Report>& report) {
  if (!report) return tl::unexpected(report.error());
  WriteReport written{report->items, report->left_out, report->bytes, 0,
                      WriteReport::Tessellated{report->triangles, report->vertices, report->largest_chord_error}};
  if constexpr (requires { report->analytic; }) written.analytic = report->analytic;
  return written;
}

/// Scene caches, glTF and 3D Tiles hold all attributes, RVM those of the file, as "rvm.*", and others none.
std::uint64_t nodes_with_lost_attributes(const core::Scene& scene, core::NodeId top, const std::string& extension) {
  if (extension == ".slc" || extension == ".glb" || extension == ".gltf") return 0;
  const bool rvm = extension == ".rvm";
  std::uint64_t nodes = 0;
  scene.for_each_node(top, [&](core::NodeId node, const auto&...) {
    nodes += std::ranges::any_of(scene.attributes(node),
                                 [&](const auto& one) { return !rvm || !one.first.starts_with("rvm."); });
  });
  return nodes;
}

core::Expected<WriteReport> write_tiles_of(const core::Scene& scene, core::NodeId node,
                                           const std::filesystem::path& folder, const WriteOptions& options) {
  const auto done = write_tiles(scene, node, folder,
                                {.tolerance = options.tolerance,
                                 .collections = options.collections,
                                 .compress = options.compress,
                                 .progress = options.progress});
  if (!done) return tl::unexpected(done.error());
  WriteReport written{done->items, done->left_out, done->bytes};
  written.analytic = done->analytic;
  written.tiles = *done;
  return written;
}

core::Expected<WriteReport> write_as(const std::string& extension, const core::Scene& scene, core::NodeId node,
                                     const std::filesystem::path& path, const WriteOptions& options) {
  const auto& [tolerance, collections, tiles, compress, levels, report, progress] = options;
  if (extension == ".rvm") return whole(write_rvm(scene, node, path, progress), scene, node, path);
  if (extension == ".slc")
    return whole(write_slc(scene, path, {.report = report, .levels = levels, .progress = progress}), scene,
                 scene.root(), path);
  if (extension == ".obj")
    return tessellated(write_obj(scene, node, path, {.tolerance = tolerance, .progress = progress}));
  if (extension == ".glb" || extension == ".gltf")
    return tessellated(
        write_gltf(scene, node, path, {.tolerance = tolerance, .collections = collections, .progress = progress}));
  if (extension == ".stl") return tessellated(write_stl({scene, node, tolerance, progress}, path));
  if (extension == ".ply") return tessellated(write_ply({scene, node, tolerance, progress}, path));
  return core::fail("expected a name ending in .rvm, .obj, .glb, .gltf, .stl, .ply or .slc, found \"" + path.string() +
                    "\"");
}

}  // namespace

core::Expected<WriteReport> write_file(const core::Scene& scene, core::NodeId node, const std::filesystem::path& path,
                                       const WriteOptions& options) {
  if (options.tiles) return write_tiles_of(scene, node, path, options);
  const std::string extension = lower_case_extension(path);
  return write_as(extension, scene, node, path, options).map([&](WriteReport written) {
    written.attributes_lost = nodes_with_lost_attributes(scene, node, extension);
    return written;
  });
}

}  // namespace sightline::importers
