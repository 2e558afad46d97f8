// Sightline in an application's own window: GLFW opens it, the application draws a floor into it with OpenGL, and
// Sightline adds a model. Both share the window's depth buffer, so pipes go through the floor.
//   own_window MODEL [OUT.png]       with OUT.png: one frame, saved; otherwise a window that turns about the model
#include <cstdio>
#include <vector>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/gl/external_target.h"
#include "sightline/gl/functions.h"
#include "sightline/importers/import.h"
#include "sightline/render/image/image.h"

using namespace sightline;

namespace {

/// The application's own drawing: a square from -1 to 1, in x and y.
class Floor {
 public:
  explicit Floor(const gl::Functions& functions) : gl(functions) {
    const char* vertex =
        "#version 450 core\n"
        "layout(location = 0) uniform mat4 clip_from_floor;\n"
        "out vec2 place;\n"
        "void main() {\n"
        "  place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;\n"
        "  gl_Position = clip_from_floor * vec4(place, 0.0, 1.0);\n"
        "}\n";
    const char* fragment =
        "#version 450 core\n"
        "in vec2 place;\n"
        "out vec4 colour;\n"
        "void main() {\n"
        "  ivec2 tile = ivec2(floor(place * 8.0));\n"
        "  colour = vec4(vec3(((tile.x + tile.y) & 1) == 0 ? 0.45 : 0.55), 1.0);\n"
        "}\n";
    program_ = gl.CreateProgram();
    for (const auto& [stage, text] : {std::pair(GL_VERTEX_SHADER, vertex), {GL_FRAGMENT_SHADER, fragment}}) {
      const GLuint shader = gl.CreateShader(GLenum(stage));
      gl.ShaderSource(shader, 1, &text, nullptr);
      gl.CompileShader(shader);
      gl.AttachShader(program_, shader);
      gl.DeleteShader(shader);
    }
    gl.LinkProgram(program_);
    gl.CreateVertexArrays(1, &array_);
  }
  ~Floor() {
    gl.DeleteProgram(program_);
    gl.DeleteVertexArrays(1, &array_);
  }

  void draw(const glm::mat4& clip_from_floor) const {
    gl.ProgramUniformMatrix4fv(program_, 0, 1, GL_FALSE, &clip_from_floor[0][0]);
    gl.UseProgram(program_);
    gl.BindVertexArray(array_);
    gl.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }

 private:
  const gl::Functions& gl;
  GLuint program_ = 0, array_ = 0;
};

int complain(const std::string& message) {
  std::fprintf(stderr, "own_window: %s\n", message.c_str());
  return 1;
}

int show(GLFWwindow* window, core::Scene& scene, const char* out) {
  glfwMakeContextCurrent(window);
  auto context =
      gl::Context::adopt([](const char* name, void*) { return gl::Proc(glfwGetProcAddress(name)); }, nullptr);
  if (!context) return complain(context.error().message);
  const gl::Functions& gl = context->functions();
  const Floor floor(gl);

  engine::EngineConfig config;
  config.draw = true;
  config.context.application = &*context;
  auto engine = engine::Engine::create(scene, config);
  if (!engine) return complain(engine.error().message);

  const core::AabbD bounds = engine->snapshot().bounds().fitted_bounds().bounds;
  const glm::dvec3 centre = 0.5 * (bounds.min + bounds.max);
  const double radius = 0.5 * glm::length(bounds.max - bounds.min);
  while (!glfwWindowShouldClose(window)) {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window, &width, &height);
    if (width == 0 || height == 0) {  // an icon
      glfwWaitEvents();
      continue;
    }
    const double turn = out ? 0.6 : 0.2 * glfwGetTime();
    const glm::dvec3 eye = centre + radius * glm::dvec3(1.4 * std::cos(turn), 1.4 * std::sin(turn), 0.7);
    const glm::dmat4 eye_from_world = glm::lookAt(eye, centre, glm::dvec3(0, 0, 1));
    const glm::dmat4 clip_from_eye =
        glm::perspective(0.8, double(width) / double(height), 0.02 * radius, 10.0 * radius);

    gl.Viewport(0, 0, width, height);
    gl.ClearColor(0.75f, 0.82f, 0.9f, 1.0f);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl.Enable(GL_DEPTH_TEST);
    const double level = glm::mix(bounds.min.z, bounds.max.z, 0.15);
    // In double as far as the eye: models lie far from their origin, and floats do not reach there.
    const glm::dmat4 world_from_floor =
        glm::scale(glm::translate(glm::dmat4(1.0), {centre.x, centre.y, level}), glm::dvec3(1.5 * radius));
    floor.draw(glm::mat4(clip_from_eye * eye_from_world * world_from_floor));

    auto view = core::View::from_matrices(eye_from_world, clip_from_eye, core::ClipDepth::kMinusOneToOne);
    if (!view) return complain(view.error().message);
    gl::ExternalTarget target;  // the window's framebuffer and OpenGL's classic depths
    target.width = width;
    target.height = height;
    const auto report = engine->frame(*view, target);
    if (!report) return complain(report.error().message);

    if (out) {
      image::Image image{width, height, std::vector<std::uint8_t>(std::size_t(3 * width * height))};
      std::vector<std::uint8_t> rows(image.pixels.size());
      gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
      gl.ReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, rows.data());
      const std::size_t row = std::size_t(3 * width);
      for (std::size_t y = 0; y < std::size_t(height); ++y)  // OpenGL's rows begin at the bottom
        std::copy_n(rows.begin() + std::ptrdiff_t((std::size_t(height) - 1 - y) * row), row,
                    image.pixels.begin() + std::ptrdiff_t(y * row));
      const auto saved = image::write_png(image, out);
      return saved ? 0 : complain(saved.error().message);
    }
    glfwSwapBuffers(window);
    glfwPollEvents();
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return std::fprintf(stderr, "usage: own_window MODEL [OUT.png]\n"), 2;
  core::Scene scene;
  const auto imported = importers::import_file(argv[1], scene, scene.root());
  if (!imported) return complain(imported.error().message);

  if (!glfwInit()) return complain("GLFW finds no display");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_DEPTH_BITS, 24);
  GLFWwindow* window = glfwCreateWindow(480, 320, "Sightline in a window of one's own", nullptr, nullptr);
  const int code =
      window ? show(window, scene, argc == 3 ? argv[2] : nullptr) : complain("GLFW opens no window with OpenGL 4.5");
  glfwTerminate();
  return code;
}
