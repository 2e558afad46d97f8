// The smallest program that shows VTK data: two blocks as VTK holds them in memory, culled and drawn, saved as an
// image.
//   vtk_import OUT.png
#include "sightline/importers/vtk/vtk_import.h"

#include <cstdio>

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkUnsignedCharArray.h>

#include "sightline/engine/engine.h"
#include "sightline/render/image/image.h"

using namespace sightline;

namespace {

/// A block of cells that become redder from end to end. Its surface is what will be drawn.
vtkSmartPointer<vtkImageData> make_block(double x, int cells) {
  auto block = vtkSmartPointer<vtkImageData>::New();
  block->SetOrigin(x, 0, 0);
  block->SetSpacing(1.0 / cells, 1.0 / cells, 1.0 / cells);
  block->SetDimensions(cells + 1, cells + 1, cells + 1);
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(3);
  for (vtkIdType i = 0; i < block->GetNumberOfCells(); ++i)
    colours->InsertNextTuple3(double(i % cells + 1) * 255 / cells, 120, 60);
  block->GetCellData()->SetScalars(colours);
  return block;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: vtk_import OUT.png\n"), 2;
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, make_block(0.0, 4));
  blocks->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "coarse");
  blocks->SetBlock(1, make_block(1.5, 16));
  blocks->GetMetaData(1u)->Set(vtkCompositeDataSet::NAME(), "fine");

  core::Scene scene;
  auto imported = importers::import_vtk(*blocks, "blocks", scene, scene.root());
  if (!imported) return std::fprintf(stderr, "%s\n", imported.error().message.c_str()), 1;

  engine::EngineConfig config;
  config.draw = true;
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return std::fprintf(stderr, "%s\n", engine.error().message.c_str()), 1;
  auto view = core::View::perspective({{-1, -3, 2.5}, {1.25, 0.5, 0.5}, {0, 0, 1}}, 0.7, 1280.0 / 720.0, 0.1);
  auto report = engine->frame(*view);
  if (!report) return std::fprintf(stderr, "%s\n", report.error().message.c_str()), 1;
  std::printf("%llu items visible, one for each colour of a block\n", (unsigned long long)report->visible);
  auto image = engine->read_colour();
  auto saved = image ? image::write_png(*image, argv[1]) : tl::unexpected(image.error());
  return saved ? 0 : 1;
}
