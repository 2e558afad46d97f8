// Sightline in a VTK render window: VTK draws its actors, Sightline adds a model when VTK's renderer has finished, into
// the same framebuffer and depth buffer. Both hide one another.
//   vtk_window MODEL [OUT.png]      with OUT.png: one frame, saved; otherwise a window with VTK's mouse bindings
#include <cstdio>
#include <optional>
#include <string>

#include <vtkActor.h>
#include <vtkAutoInit.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPlaneSource.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/gl/external_target.h"
#include "sightline/gl/functions.h"
#include "sightline/importers/import.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkInteractionStyle)

using namespace sightline;

extern "C" gl::Proc glXGetProcAddressARB(const unsigned char* name);  // <GL/glx.h> brings macros that VTK cannot bear

namespace {

glm::dmat4 matrix_of(const vtkMatrix4x4* rows) {
  glm::dmat4 columns;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) columns[column][row] = rows->GetElement(row, column);
  return columns;
}

/// Draws a scene at the end of each frame of a vtkRenderer.
class Model {
 public:
  explicit Model(core::Scene& scene) : scene_(scene) {}

  /// Called with VTK's context current and its framebuffer bound.
  void draw(vtkRenderer& renderer) {
    const auto done = try_to_draw(renderer);
    if (!done && problem.empty()) problem = done.error().message;
  }

  std::string problem;  ///< the first

 private:
  core::Expected<void> try_to_draw(vtkRenderer& renderer) {
    if (!context_) {
      auto adopted = gl::Context::adopt(
          [](const char* name, void*) {
            return gl::Proc(glXGetProcAddressARB(reinterpret_cast<const unsigned char*>(name)));
          },
          nullptr);
      if (!adopted) return tl::unexpected(adopted.error());
      context_ = std::move(*adopted);
      engine::EngineConfig config;
      config.draw = true;
      config.context.application = &*context_;
      auto made = engine::Engine::create(scene_, config);
      if (!made) return tl::unexpected(made.error());
      engine_.emplace(std::move(*made));
    }
    const gl::Functions& gl = context_->functions();
    GLint framebuffer = 0, viewport[4];
    gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    gl.GetIntegerv(GL_VIEWPORT, viewport);
    vtkCamera& camera = *renderer.GetActiveCamera();
    const double aspect = double(viewport[2]) / double(viewport[3]);
    const auto view = core::View::from_matrices(matrix_of(camera.GetViewTransformMatrix()),
                                                matrix_of(camera.GetProjectionTransformMatrix(aspect, -1.0, 1.0)),
                                                core::ClipDepth::kMinusOneToOne);
    if (!view) return tl::unexpected(view.error());
    gl::ExternalTarget target;
    target.framebuffer = std::uint32_t(framebuffer);
    target.x = viewport[0];
    target.y = viewport[1];
    target.width = viewport[2];
    target.height = viewport[3];
    const auto report = engine_->frame(*view, target);
    if (!report) return tl::unexpected(report.error());
    return {};
  }

  core::Scene& scene_;
  std::optional<gl::Context> context_;
  std::optional<engine::Engine> engine_;  // after its context
};

int complain(const std::string& message) {
  std::fprintf(stderr, "vtk_window: %s\n", message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return std::fprintf(stderr, "usage: vtk_window MODEL [OUT.png]\n"), 2;
  core::Scene scene;
  const auto imported = importers::import_file(argv[1], scene, scene.root());
  if (!imported) return complain(imported.error().message);
  const core::AabbD bounds = scene.bounds(scene.root());
  const glm::dvec3 centre = 0.5 * (bounds.min + bounds.max), size = bounds.max - bounds.min;

  // VTK's own scene: a green wall through the middle of the model.
  vtkNew<vtkPlaneSource> wall;
  wall->SetOrigin(-0.5 * size.x, 0.0, -0.5 * size.z);
  wall->SetPoint1(0.5 * size.x, 0.0, -0.5 * size.z);
  wall->SetPoint2(-0.5 * size.x, 0.0, 0.0);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(wall->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->SetPosition(centre.x, centre.y, centre.z);  // points are floats, positions are doubles
  actor->GetProperty()->SetColor(0.2, 0.7, 0.4);
  actor->GetProperty()->SetAmbient(0.4);
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);
  renderer->SetBackground(0.75, 0.82, 0.9);
  renderer->GetActiveCamera()->SetViewUp(0, 0, 1);
  renderer->GetActiveCamera()->SetFocalPoint(centre.x, centre.y, centre.z);
  renderer->GetActiveCamera()->SetPosition(centre.x + 0.9 * size.x, centre.y - 1.1 * size.y, centre.z + 1.3 * size.z);
  // VTK sets near and far to its own actors unless it is told of the model.
  double around[6] = {bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y, bounds.min.z, bounds.max.z};
  renderer->ResetCameraClippingRange(around);

  vtkNew<vtkRenderWindow> window;
  window->SetSize(480, 320);
  window->SetMultiSamples(0);
  window->AddRenderer(renderer);
  Model model(scene);
  vtkNew<vtkCallbackCommand> after;
  after->SetClientData(&model);
  after->SetCallback([](vtkObject* caller, unsigned long, void* data, void*) {
    static_cast<Model*>(data)->draw(*vtkRenderer::SafeDownCast(caller));
  });
  renderer->AddObserver(vtkCommand::EndEvent, after);

  if (argc == 3) {
    window->SetOffScreenRendering(1);
    window->Render();
    vtkNew<vtkWindowToImageFilter> grab;
    grab->SetInput(window);
    grab->ReadFrontBufferOff();
    grab->ShouldRerenderOff();
    vtkNew<vtkPNGWriter> writer;
    writer->SetFileName(argv[2]);
    writer->SetInputConnection(grab->GetOutputPort());
    writer->Write();
  } else {
    vtkNew<vtkRenderWindowInteractor> mouse;
    mouse->SetRenderWindow(window);
    window->Render();
    mouse->Start();
  }
  return model.problem.empty() ? 0 : complain(model.problem);
}
