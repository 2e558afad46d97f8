// Sightline in a Qt 6 widget: QOpenGLWidget has a context and a framebuffer of its own, whose name changes when the
// widget is resized. A label of Qt's lies over the image.
//   qt_widget MODEL [OUT.png]      with OUT.png: one frame, saved; otherwise a window that turns about the model
#include <QApplication>
#include <QElapsedTimer>
#include <QLabel>
#include <QOpenGLContext>
#include <QOpenGLWidget>
#include <QSurfaceFormat>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/gl/external_target.h"
#include "sightline/importers/import.h"

using namespace sightline;

namespace {

class ModelWidget : public QOpenGLWidget {
 public:
  ModelWidget(core::Scene& scene, bool turns) : scene_(scene), turns_(turns) { clock_.start(); }
  ~ModelWidget() override {
    makeCurrent();  // the engine frees what it has in the context
    engine_.reset();
    context_.reset();
    doneCurrent();
  }
  std::string problem;  ///< the first

 private:
  void initializeGL() override {
    auto adopted = gl::Context::adopt(
        [](const char* name, void* qt) { return static_cast<QOpenGLContext*>(qt)->getProcAddress(name); }, context());
    if (!adopted) return fail(adopted.error());
    context_ = std::move(*adopted);
    engine::EngineConfig config;
    config.draw = true;
    config.context.application = &*context_;
    auto made = engine::Engine::create(scene_, config);
    if (!made) return fail(made.error());
    engine_.emplace(std::move(*made));
  }

  void paintGL() override {
    if (!engine_) return;
    gl::ExternalTarget target;
    target.framebuffer = defaultFramebufferObject();
    target.width = int(std::lround(width() * devicePixelRatio()));
    target.height = int(std::lround(height() * devicePixelRatio()));
    target.clear_colour = target.clear_depth = true;
    const double turn = turns_ ? 1e-4 * double(clock_.elapsed()) : 0.6;
    const auto view =
        core::View::fit(engine_->snapshot().bounds().fitted_bounds().bounds, {std::cos(turn), std::sin(turn), -0.6},
                        0.7, double(target.width) / double(target.height));
    if (!view) return fail(view.error());
    if (const auto report = engine_->frame(*view, target); !report) return fail(report.error());
    if (turns_) update();
  }

  void fail(const core::Error& error) {
    if (problem.empty()) problem = error.message;
  }

  core::Scene& scene_;
  bool turns_;
  QElapsedTimer clock_;
  std::optional<gl::Context> context_;
  std::optional<engine::Engine> engine_;  // after its context
};

int complain(const std::string& message) {
  std::fprintf(stderr, "qt_widget: %s\n", message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  QSurfaceFormat format;
  format.setVersion(4, 5);
  format.setProfile(QSurfaceFormat::CoreProfile);
  format.setDepthBufferSize(24);
  QSurfaceFormat::setDefaultFormat(format);
  const QApplication application(argc, argv);
  if (argc != 2 && argc != 3) return std::fprintf(stderr, "usage: qt_widget MODEL [OUT.png]\n"), 2;
  core::Scene scene;
  const auto imported = importers::import_file(argv[1], scene, scene.root());
  if (!imported) return complain(imported.error().message);

  ModelWidget widget(scene, argc == 2);
  QLabel label(QString("%1 items").arg(qulonglong(scene.item_count())), &widget);
  label.move(12, 8);
  widget.resize(480, 320);
  widget.show();
  int code = 0;
  if (argc == 3) {
    if (!widget.grabFramebuffer().save(argv[2])) return complain(std::string("cannot write ") + argv[2]);
  } else {
    code = QApplication::exec();
  }
  return widget.problem.empty() ? code : complain(widget.problem);
}
