#include "sightline/importers/vtk/vtk_import.h"

#include <vtkDataObject.h>

#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/vtk/internal/vtk_quiet.h"
#include "sightline/importers/vtk/internal/vtk_scene_builder.h"

namespace sightline::importers {

core::Expected<ImportReport> import_vtk(vtkDataObject& data, std::string_view name, core::Scene& scene,
                                        core::NodeId parent, const ImportOptions& options) {
  return run_import(name, scene, parent, options, frame_with_z_up(options), [&](ImportJob& job) {
    const VtkQuiet quiet;
    auto done = VtkSceneBuilder(job).add(job.file_node(), data, Share{job});
    if (!done) return core::Expected<void>(tl::unexpected(done.error()));
    return core::Expected<void>{};
  });
}

}  // namespace sightline::importers
