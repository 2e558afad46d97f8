#include "sightline/importers/internal/import_job.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/internal/crease_normals.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/up_axis.h"

namespace sightline::importers {
namespace {

core::Affine scene_from_file(const FileFrame& frame) {
  core::Affine map;
  map.linear = frame.metres_per_unit * core::dmat3(1.0);
  if (frame.up == UpAxis::kY)  // x stays, y becomes z, z becomes -y
    map.linear = frame.metres_per_unit * core::dmat3(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
  return map;
}

/// Whether the map stretches so little that what reaches kLargestCoordinate can still be committed.
bool is_tame(const core::Affine& map) {
  constexpr double kLargestEntry = 2.0;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      if (!(std::abs(map.linear[column][row]) <= kLargestEntry)) return false;
  return glm::all(glm::lessThanEqual(glm::abs(map.origin), core::dvec3(kLargestCoordinate)));
}

/// An upper bound of what the map multiplies any length by (the linear part's Frobenius norm).
double largest_stretch(const core::Affine& map) {
  double squares = 0.0;
  for (int column = 0; column < 3; ++column) squares += glm::dot(map.linear[column], map.linear[column]);
  return std::sqrt(squares);
}

}  // namespace

ImportJob::ImportJob(std::string_view file, core::Scene& scene, core::NodeId parent, const ImportOptions& options,
                     const FileFrame& frame)
    : scene_(scene),
      options_(options),
      file_(utf8_by_guess(file)),
      frame_(frame),
      file_node_(scene.add_node(parent, file_, scene_from_file(frame))),
      sharing_(scene, options.copies) {
  report_.nodes.push_back(file_node_);
  report_.metres_per_unit = frame.metres_per_unit;
}

void ImportJob::warn(std::uint64_t offset, std::string message) {
  if (report_.warnings.size() < kMaxWarnings)
    report_.warnings.push_back({file_, offset, utf8_by_guess(message)});
  else
    ++unlisted_;
}

core::Expected<void> ImportJob::damage(std::uint64_t offset, std::string message) {
  if (!options_.lenient) return core::fail(fmt::format("{}: {}", file_, message));
  warn(offset, std::move(message));
  return {};
}

void ImportJob::state_up(UpAxis up) {
  if (frame_.up != UpAxis::kAutomatic) return;
  frame_.up = up;
  scene_.set_transform(file_node_, scene_from_file(frame_));
}

core::Expected<void> ImportJob::progress(double share) {
  if (!refused_) return refused_;
  constexpr double kStep = 1.0 / 256.0;
  if (!options_.progress || share < shown_ + kStep) return {};
  shown_ = share;
  if (!options_.progress(share)) return core::fail(std::string(kCancelled));
  return {};
}

bool ImportJob::add_mesh(core::NodeId node, core::Mesh mesh, const core::Affine& placement, core::MaterialId material,
                         core::Kind found) {
  ++report_.items[std::size_t(found)];
  if (mesh.indices.empty()) ++report_.degenerate;
  const auto use = sharing_.add(std::move(mesh));
  if (!use) {
    if (auto told = damage(0, fmt::format("{}: item dropped: {}", scene_.path(node), use.error().message)); !told)
      refused_ = std::move(told);
    return false;
  }
  if (use->shared) ++report_.shared_meshes;
  const core::Affine node_from_mesh = placement * use->added_from_mesh;
  scene_.add_mesh_instance(node, use->mesh, node_from_mesh, material);
  if (use->error > 0.0)
    report_.sharing_error =
        std::max(report_.sharing_error, use->error * largest_stretch(scene_.world_from_node(node) * placement));
  return true;
}

bool ImportJob::add_mesh(core::NodeId node, const PolygonMesh& polygons, std::string_view name,
                         const core::Affine& placement, core::MaterialId material, std::uint64_t offset) {
  CentredMesh centred_mesh = centred(polygons);
  const std::string called = name.empty() || name == file_ ? std::string() : fmt::format("{}: ", name);
  if (centred_mesh.dropped > 0)
    warn(offset, fmt::format("{}{} faces dropped: fewer than 3 corners, or a corner not finite or beyond {:g}", called,
                             centred_mesh.dropped, kLargestCoordinate));
  if (centred_mesh.flat > 0)
    warn(offset,
         fmt::format("{}{} faces of more than 3 corners have no area and are left out", called, centred_mesh.flat));
  if (centred_mesh.mended_normals > 0)
    warn(offset, fmt::format("{}{} normals that are not finite become those of the faces", called,
                             centred_mesh.mended_normals));
  centred_mesh.mesh.name = name;
  if (options_.crease_angle > 0.0 && centred_mesh.mesh.normals.empty())
    add_crease_normals(centred_mesh.mesh, options_.crease_angle);
  return add_mesh(node, std::move(centred_mesh.mesh), placement * core::translation(centred_mesh.centre), material);
}

void ImportJob::add_instance(core::NodeId node, core::MeshId mesh, const core::Affine& placement,
                             core::MaterialId material, bool first) {
  ++report_.items[std::size_t(core::Kind::kMesh)];
  if (scene_.mesh(mesh).indices.empty()) ++report_.degenerate;
  if (!first) ++report_.shared_meshes;
  scene_.add_mesh_instance(node, mesh, placement, material);
}

void ImportJob::add_primitive(core::NodeId node, const core::Primitive& primitive, const core::Affine& placement,
                              core::MaterialId material) {
  ++report_.items[std::size_t(core::kind_of(primitive))];
  if (core::is_degenerate(primitive)) ++report_.degenerate;
  scene_.add_primitive(node, primitive, placement, material);
}

void ImportJob::turn_if_y_seems_up() {
  if (frame_.up != UpAxis::kAutomatic || !seems_to_have_y_up(scene_, file_node_)) return;
  state_up(UpAxis::kY);
  warn(0, std::string(kSeemsYUp));
}

/// Readers refuse bad numbers, but the product of several nodes' transforms may be bad all the same.
void ImportJob::drop_what_cannot_be_committed(core::ItemId first) {
  if (reach_promised_ && is_tame(scene_.world_from_node(file_node_))) return;
  std::vector<core::ItemId> added;
  for (core::ItemId item = first; to_index(item) < scene_.item_slots(); ++item) added.push_back(item);
  std::vector<core::ItemId> bad;
  scene_.for_each_state(added, [&](core::ItemId item, const core::Scene::ItemState& state) {
    if (!scene_.can_commit(item, state.world_from_item)) bad.push_back(item);
  });
  for (const core::ItemId item : bad) {
    if (report_.warnings.size() < kMaxWarnings)  // else skip making the node's full name, as long as the tree is deep
      warn(0, fmt::format("{}: item dropped: its place or size is not finite or beyond any site",
                          scene_.path(scene_.node_of(item))));
    else
      ++unlisted_;
    scene_.remove_item(item);
  }
}

void ImportJob::say_if_nothing_is_drawn() {
  const std::uint64_t found = std::accumulate(report_.items.begin(), report_.items.end(), std::uint64_t{0});
  if (found > report_.degenerate || report_.attributed > 0) return;
  warn(0, found == 0 ? "nothing to draw: the file has no items"
                     : fmt::format("nothing to draw: none of the {} items has a volume or an area", found));
}

core::Expected<void> ImportJob::finish(core::ItemId first) {
  if (!refused_) return refused_;
  drop_what_cannot_be_committed(first);
  turn_if_y_seems_up();
  say_if_nothing_is_drawn();
  if (unlisted_ > 0)
    report_.warnings.push_back({file_, report_.bytes, fmt::format("{} further warnings are not listed", unlisted_)});
  return {};
}

core::Expected<ImportReport> run_import(std::string_view file, core::Scene& scene, core::NodeId parent,
                                        const ImportOptions& options, const FileFrame& frame,
                                        const std::function<core::Expected<void>(ImportJob&)>& read) {
  if (!(options.metres_per_unit > 0.0 && std::isfinite(options.metres_per_unit)))
    return core::fail(
        fmt::format("{}: metres_per_unit: expected a finite number above 0, found {}", file, options.metres_per_unit));
  if (!(options.crease_angle >= 0.0 && options.crease_angle <= std::numbers::pi))
    return core::fail(fmt::format("{}: crease_angle: expected 0 to pi, found {}", file, options.crease_angle));
  const core::Scene::Mark mark = scene.mark();
  ImportJob job(file, scene, parent, options, frame);
  core::Error error;
  try {
    auto done = job.progress(0.0);
    if (done) done = read(job);
    if (done) done = job.finish(core::ItemId(mark.items));
    if (done) {
      (void)job.progress(1.0);
      return std::move(job.report_);
    }
    error = std::move(done.error());
  } catch (ImportFault& fault) {
    error = std::move(fault.error);
  } catch (const std::bad_alloc&) {
    error.message = fmt::format("{}: not enough memory", file);
  } catch (const std::exception& thrown) {
    error.message = fmt::format("{}: {}", file, thrown.what());
  }
  scene.take_back(mark, job.report_.nodes);
  error.message = utf8_by_guess(error.message);
  if (error.message.starts_with(job.file_)) error.message.replace(0, job.file_.size(), file);  // as the caller has it
  return tl::unexpected(std::move(error));
}

core::Expected<ImportReport> with_whole_path(core::Expected<ImportReport> report, const std::filesystem::path& path) {
  if (!report && path.has_parent_path() && report.error().message.starts_with(path.filename().string()))
    report.error().message.insert(0, (path.parent_path() / "").string());
  return report;
}

}  // namespace sightline::importers
