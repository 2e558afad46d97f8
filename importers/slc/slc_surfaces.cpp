#include "sightline/importers/slc/internal/slc_surfaces.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace sightline::importers {
namespace {

using core::MeshSurface;

bool is_sound(const MeshSurface& surface) {
  return surface.kind <= MeshSurface::Kind::kTorus && core::is_finite(surface.origin) &&
         core::is_finite(surface.axis) && std::isfinite(surface.radius) && std::isfinite(surface.tube_radius) &&
         std::isfinite(surface.slope) && std::isfinite(surface.gap);
}

bool rise(std::span<const MeshSurface> surfaces) {
  return std::is_sorted(surfaces.begin(), surfaces.end(),
                        [](const MeshSurface& a, const MeshSurface& b) { return a.end_triangle < b.end_triangle; });
}

}  // namespace

void write_surfaces(const core::Scene& scene, SlcWriter& out) {
  std::vector<std::uint64_t> ends;
  std::vector<MeshSurface> all;
  for (std::size_t i = 0; i < scene.mesh_slots(); ++i) {
    if (const core::MeshId id = scene.mesh_at(i); id.valid()) {
      const auto some = core::surfaces_stored_with(scene.mesh(id));
      all.insert(all.end(), some.begin(), some.end());
    }
    ends.push_back(all.size());
  }
  if (all.empty()) return;
  out.add(kSlcSurfaceEnds, ends);
  out.add(kSlcSurfaces, all);
}

SlcExpected<std::vector<SlcSurfaces>> read_surfaces(const SlcFile& file, const SlcFile::Mapping& mapping,
                                                    std::size_t mesh_count) {
  core::LargeArray<std::uint64_t> ends;
  core::LargeArray<MeshSurface> all;
  if (!file.adopt(mapping, kSlcSurfaceEnds, ends) || !file.adopt(mapping, kSlcSurfaces, all))
    return damaged("the surfaces of its meshes have another size");
  std::vector<SlcSurfaces> made;
  if (ends.size() == 0 && all.size() == 0) return made;
  if (ends.size() != mesh_count || !std::all_of(all.begin(), all.end(), is_sound))
    return damaged("the surfaces of its meshes are inconsistent");
  std::uint64_t begin = 0;
  for (const std::uint64_t end : ends) {
    if (end < begin || end > all.size()) return damaged("the surfaces of its meshes are inconsistent");
    const std::span<const MeshSurface> some(all.data() + begin, std::size_t(end - begin));
    if (!rise(some)) return damaged("the surfaces of its meshes are inconsistent");
    made.push_back(some.empty() ? nullptr : std::make_shared<const std::vector<MeshSurface>>(some.begin(), some.end()));
    begin = end;
  }
  return made;
}

}  // namespace sightline::importers
