#include "sightline/tests/fuzz/fuzz_target.h"

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/tests/fuzz/allocated_memory.h"
#include "sightline/tests/fuzz/side_files_in_memory.h"
#include "sightline/tests/support/scene_texts.h"

namespace sightline::fuzz {
namespace {

using Bytes = std::span<const std::byte>;

/// The model, then its side files.
std::vector<Bytes> split(Bytes input) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  std::vector<Bytes> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(kSideFileSeparator, begin);
    parts.push_back(input.subspan(begin, (end == text.npos ? input.size() : end) - begin));
    if (end == text.npos) return parts;
    begin = end + kSideFileSeparator.size();
  }
}

struct Counts {
  std::size_t nodes, items, item_slots, meshes, materials;
  explicit Counts(const core::Scene& scene)
      : nodes(scene.node_count()),
        items(scene.item_count()),
        item_slots(scene.item_slots()),
        meshes(scene.mesh_slots()),
        materials(scene.material_slots()) {}
  friend bool operator==(const Counts&, const Counts&) = default;
};

void check_mesh(const core::Mesh& mesh) {
  require(mesh.indices.size() % 3 == 0, "three indices for each triangle");
  for (const std::uint32_t index : mesh.indices) require(index < mesh.positions.size(), "indices of vertices");
  require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(), "a normal for each vertex, or none");
  for (const core::vec3& p : mesh.positions) require(core::is_finite(core::dvec3(p)), "finite positions");
  for (const core::vec3& n : mesh.normals) require(core::is_finite(core::dvec3(n)), "finite normals");
  std::size_t contours = 0, vertices = 0;
  for (const std::uint32_t count : mesh.polygon_contours) contours += count;
  for (const std::uint32_t count : mesh.contour_sizes) vertices += count;
  require(contours == mesh.contour_sizes.size(), "contours that belong to polygons");
  require(!mesh.is_facet_group() || vertices == mesh.positions.size(), "contours that cover all vertices");
}

void check_success(core::Scene& scene, const importers::ImportReport& report, const Counts& before) {
  require(report.nodes.size() == 1 && scene.parent(report.nodes[0]) != scene.root(), "one node below the given parent");
  require(report.warnings.size() <= importers::kMaxWarnings + 1, "a bounded number of warnings");
  std::uint64_t found = 0;
  for (const std::uint64_t of_kind : report.items) found += of_kind;
  const std::size_t items = scene.item_count() - before.items;
  require(items <= found, "no more items than the report says");
  require(items == found || !report.warnings.empty(), "a warning about items that were dropped");
  for (std::size_t i = 0; i < scene.mesh_slots(); ++i) check_mesh(scene.mesh(scene.mesh_at(i)));
  for (std::size_t i = 0; i < scene.material_slots(); ++i) {
    const core::Material& m = scene.material(scene.material_at(i));
    for (int k = 0; k < 3; ++k) require(m.colour[k] >= 0.0f && m.colour[k] <= 1.0f, "colours from 0 to 1");
    require(m.alpha >= 0.0f && m.alpha <= 1.0f, "alpha from 0 to 1");
  }
  const std::string bytes = tests::text_that_is_not_utf8(scene, report);
  require(bytes.empty(), "UTF-8, found " + bytes);
  require(items > 0 || report.attributed > 0 || !report.warnings.empty(), "a warning about nothing to draw");
  const auto delta = scene.commit();
  require(delta.has_value(), delta ? "" : delta.error().message);
  const core::Snapshot snapshot(scene);
  require(snapshot.size() <= scene.item_slots(), "a slot for each item");
}

struct Attempt {
  bool imported = false;
  std::size_t items = 0, warnings = 0;
};

Attempt attempt(Reader read, std::string_view file, Bytes input, const MemoryBound& bound,
                const importers::ImportOptions& options,
                void (*also)(const core::Scene&, const importers::ImportReport&)) {
  const std::vector<Bytes> parts = split(input);
  set_side_files(std::span(parts).subspan(1));
  // A copy of exactly the model's size, so that one byte too many is caught.
  const std::vector<std::byte> model(parts[0].begin(), parts[0].end());
  core::Scene scene;
  const core::NodeId parent = scene.add_node(scene.root(), "kept");
  scene.add_primitive(parent, core::Sphere{1.0f});
  const Counts before(scene);
  const PeakMemory peak;
  const auto report = read(model, std::filesystem::path(file), scene, parent, options);
  const std::size_t used = peak.bytes();
  require(used <= bound.factor * input.size() + bound.constant,
          "memory within the bound, found " + std::to_string(used) + " bytes");
  if (!report) {
    require(Counts(scene) == before, "the scene as it was");
    const std::string& message = report.error().message;
    require(message == importers::kCancelled || message.find(file) != message.npos, "an error that names the file");
    return {};
  }
  const Attempt done{true, scene.item_count(), report->warnings.size()};
  check_success(scene, *report, before);
  if (also) also(scene, *report);
  return done;
}

}  // namespace

void require(bool holds, std::string_view expected) {
  if (holds) return;
  std::fprintf(stderr, "expected %.*s\n", int(expected.size()), expected.data());
  std::abort();
}

void check_reader(Reader read, std::string_view file, Bytes input, const MemoryBound& bound) {
  check_reader(read, file, input, bound, nullptr);
}

void check_reader(Reader read, std::string_view file, Bytes input, const MemoryBound& bound,
                  void (*also)(const core::Scene&, const importers::ImportReport&)) {
  importers::ImportOptions options;
  const Attempt strict = attempt(read, file, input, bound, options, also);
  options.lenient = true;
  const Attempt lenient = attempt(read, file, input, bound, options, also);
  if (strict.imported)
    require(lenient.imported && lenient.items == strict.items && lenient.warnings >= strict.warnings,
            "the same from lenient reading where there is no damage");
  bool cancelled = false;
  options.progress = [&](double share) {
    cancelled = cancelled || (share > 0.0 && share < 1.0);  // at the ends there is nothing left to cancel
    return !cancelled;
  };
  const Attempt last = attempt(read, file, input, bound, options, nullptr);
  require(!(cancelled && last.imported), "nothing from a cancelled import");
}

}  // namespace sightline::fuzz
