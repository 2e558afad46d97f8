// Sightline in an OpenSceneGraph viewer: OSG draws its scene graph, Sightline adds a model at the end of each frame,
// into the window that OSG has drawn to. Both hide one another.
//   osg_viewer MODEL [OUT.png]      with OUT.png: one frame, saved; otherwise a window with OSG's mouse bindings
#include <cstdio>
#include <optional>
#include <string>

#include <osg/GLExtensions>
#include <osg/Geode>
#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>
#include <osgGA/TrackballManipulator>
#include <osgViewer/Viewer>

#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/gl/external_target.h"
#include "sightline/importers/import.h"
#include "sightline/render/image/image.h"

using namespace sightline;

namespace {

glm::dmat4 matrix_of(const osg::Matrixd& m) {  // OSG's rows of row vectors are GLM's columns of column vectors
  glm::dmat4 result;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) result[i][j] = m(i, j);
  return result;
}

/// Draws a scene after a camera of OSG's.
class Model : public osg::Camera::DrawCallback {
 public:
  Model(core::Scene& scene, const char* out) : scene_(scene), out_(out) {}

  /// Called by OSG with its context current.
  void operator()(osg::RenderInfo& info) const override {
    const auto done = const_cast<Model*>(this)->draw(*info.getCurrentCamera());
    if (!done && problem_.empty()) problem_ = done.error().message;
  }
  const std::string& problem() const { return problem_; }

 private:
  core::Expected<void> draw(osg::Camera& camera) {
    if (!context_) {
      auto adopted = gl::Context::adopt(
          [](const char* name, void*) { return reinterpret_cast<gl::Proc>(osg::getGLExtensionFuncPtr(name)); },
          nullptr);
      if (!adopted) return tl::unexpected(adopted.error());
      context_ = std::move(*adopted);
      engine::EngineConfig config;
      config.draw = true;
      config.context.application = &*context_;  // OSG tracks its state, so the engine gives it back: GlState::kRestore
      auto made = engine::Engine::create(scene_, config);
      if (!made) return tl::unexpected(made.error());
      engine_.emplace(std::move(*made));
    }
    const auto view = core::View::from_matrices(
        matrix_of(camera.getViewMatrix()), matrix_of(camera.getProjectionMatrix()), core::ClipDepth::kMinusOneToOne);
    if (!view) return tl::unexpected(view.error());
    const osg::Viewport& viewport = *camera.getViewport();
    gl::ExternalTarget target;
    target.x = int(viewport.x());
    target.y = int(viewport.y());
    target.width = int(viewport.width());
    target.height = int(viewport.height());
    if (const auto report = engine_->frame(*view, target); !report) return tl::unexpected(report.error());
    return out_ ? save(target) : core::Expected<void>();
  }

  core::Expected<void> save(const gl::ExternalTarget& target) const {
    const std::size_t row = std::size_t(3 * target.width), rows = std::size_t(target.height);
    image::Image image{target.width, target.height, std::vector<std::uint8_t>(row * rows)};
    std::vector<std::uint8_t> pixels(row * rows);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(target.x, target.y, target.width, target.height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    for (std::size_t y = 0; y < rows; ++y)  // OpenGL's rows begin at the bottom
      std::copy_n(pixels.begin() + std::ptrdiff_t((rows - 1 - y) * row), row,
                  image.pixels.begin() + std::ptrdiff_t(y * row));
    return image::write_png(image, out_);
  }

  core::Scene& scene_;
  const char* out_;
  mutable std::string problem_;
  std::optional<gl::Context> context_;
  std::optional<engine::Engine> engine_;  // after its context
};

int complain(const std::string& message) {
  std::fprintf(stderr, "osg_viewer: %s\n", message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return std::fprintf(stderr, "usage: osg_viewer MODEL [OUT.png]\n"), 2;
  core::Scene scene;
  const auto imported = importers::import_file(argv[1], scene, scene.root());
  if (!imported) return complain(imported.error().message);
  const core::AabbD bounds = scene.bounds(scene.root());
  const glm::dvec3 centre = 0.5 * (bounds.min + bounds.max), size = bounds.max - bounds.min;

  // OSG's own scene: a green wall through the middle of the model.
  osg::ref_ptr<osg::Geode> geode = new osg::Geode;
  osg::ref_ptr<osg::ShapeDrawable> wall = new osg::ShapeDrawable(
      new osg::Box(osg::Vec3(0.0f, 0.0f, float(-0.25 * size.z)), float(size.x), 0.2f, float(0.5 * size.z)));
  wall->setColor(osg::Vec4(0.2f, 0.7f, 0.4f, 1.0f));
  geode->addDrawable(wall);
  osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform;  // of doubles, which points are not
  place->setMatrix(osg::Matrixd::translate(centre.x, centre.y, centre.z));
  place->addChild(geode);

  osgViewer::Viewer viewer;
  viewer.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
  viewer.setUpViewInWindow(0, 0, 480, 320);
  viewer.setSceneData(place);
  osg::Camera& camera = *viewer.getCamera();
  camera.setClearColor(osg::Vec4(0.75f, 0.82f, 0.9f, 1.0f));
  // OSG sets near and far to its own nodes unless they are fixed.
  camera.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
  const double radius = 0.5 * glm::length(size);
  camera.setProjectionMatrixAsPerspective(35.0, 1.5, 0.02 * radius, 10.0 * radius);
  osg::ref_ptr<Model> model = new Model(scene, argc == 3 ? argv[2] : nullptr);
  camera.setFinalDrawCallback(model);

  const osg::Vec3d eye(centre.x + 0.9 * size.x, centre.y - 1.1 * size.y, centre.z + 1.3 * size.z);
  const osg::Vec3d target(centre.x, centre.y, centre.z);
  if (argc == 3) {
    camera.setViewMatrixAsLookAt(eye, target, osg::Vec3d(0, 0, 1));
    viewer.realize();
    if (!viewer.isRealized()) return complain("OpenSceneGraph opens no window");
    viewer.frame();
  } else {
    osg::ref_ptr<osgGA::TrackballManipulator> mouse = new osgGA::TrackballManipulator;
    mouse->setHomePosition(eye, target, osg::Vec3d(0, 0, 1));
    viewer.setCameraManipulator(mouse);
    viewer.run();
  }
  return model->problem().empty() ? 0 : complain(model->problem());
}
