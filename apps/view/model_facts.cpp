#include "sightline/apps/view/model_facts.h"

#include <filesystem>

#include "sightline/core/primitive.h"

namespace sightline::apps {
namespace {

std::string size_of(const FileState& state) {
  return state.there ? bytes_text(state.bytes) : "no longer there";
}

bool without_volume(const core::Scene& scene, core::ItemId item) {
  if (int(scene.kind(item)) < core::kPrimitiveKindCount) return core::is_degenerate(scene.primitive(item));
  const core::MeshId mesh = scene.mesh_of(item);
  return !mesh.valid() || scene.mesh(mesh).indices.empty();
}

void add(std::vector<Finding>& all, const char* one, const char* many, std::vector<core::ItemId> items) {
  if (items.empty()) return;
  const std::string count = grouped(std::int64_t(items.size()));
  all.push_back({count + (items.size() == 1 ? one : many), std::move(items)});
}

}  // namespace

std::vector<Fact> model_facts(const std::vector<std::string>& files, FileStates& states, const core::Scene& scene,
                              const core::AabbD& bounds, const LengthFormat& lengths) {
  std::vector<Fact> facts;
  for (const std::string& file : files)
    facts.push_back({std::filesystem::path(file).filename().string(), size_of(states.of(file))});
  facts.push_back({"items", grouped(std::int64_t(scene.item_count()))});
  if (bounds.empty()) return facts;
  for (int axis = 0; axis < 3; ++axis)
    facts.push_back({std::string("along ") + "XYZ"[axis], lengths.text(bounds.size()[axis])});
  facts.push_back({"from", lengths.text(bounds.min)});
  facts.push_back({"to", lengths.text(bounds.max)});
  return facts;
}

std::vector<Finding> findings(const core::Scene& scene, const core::FittedBounds& fitted) {
  std::vector<core::ItemId> far, flat;
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    if (!scene.contains_item(item)) continue;
    if (without_volume(scene, item)) flat.push_back(item);
    if (fitted.outliers == 0) continue;
    const core::AabbD box = scene.bounds_under(item, scene.state(item).world_from_item);
    const core::dvec3 centre = box.empty() ? fitted.bounds.centre() : box.centre();
    if (glm::any(glm::lessThan(centre, fitted.bounds.min)) || glm::any(glm::greaterThan(centre, fitted.bounds.max)))
      far.push_back(item);
  }
  std::vector<Finding> all;
  add(all, " item lies too far from all others: fitted views leave it out",
      " items lie too far from all others: fitted views leave them out", std::move(far));
  add(all, " item has no volume", " items have no volume", std::move(flat));
  return all;
}

}  // namespace sightline::apps
