// Exact cylinders in a renderer of your own: plain OpenGL 4.5 in a context of EGL, without a window. The library gives
// the shaders, the records and the numbers of the view (sightline/render/ray_cast.h), and makes no GL calls.
//   own_renderer OUT.png
#define EGL_NO_PLATFORM_SPECIFIC_TYPES
#define GL_GLEXT_PROTOTYPES
#include <cstdio>
#include <string>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include "sightline/render/image/image.h"
#include "sightline/render/ray_cast.h"

using namespace sightline;

namespace {

constexpr int kWidth = 480, kHeight = 320;

int complain(const std::string& message) {
  std::fprintf(stderr, "own_renderer: %s\n", message.c_str());
  return 1;
}

bool make_context() {
  EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (!eglInitialize(display, nullptr, nullptr)) {
    display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
    if (!eglInitialize(display, nullptr, nullptr)) return false;
  }
  const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5, EGL_NONE};
  if (!eglBindAPI(EGL_OPENGL_API)) return false;
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
  return context != EGL_NO_CONTEXT && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
}

/// A linked program; 0 after a complaint.
GLuint link(const render::RayCastProgram& from) {
  const GLuint program = glCreateProgram();
  for (const auto& [stage, text] : {std::pair(GL_VERTEX_SHADER, &from.vertex), {GL_FRAGMENT_SHADER, &from.fragment}}) {
    const GLuint shader = glCreateShader(stage);
    const char* lines = text->c_str();
    glShaderSource(shader, 1, &lines, nullptr);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(program);
  GLint linked = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked) return program;
  char log[2000] = "";
  glGetProgramInfoLog(program, sizeof log, nullptr, log);
  return complain(log), 0;
}

template <class T>
GLuint make_buffer(const std::vector<T>& values) {
  GLuint buffer = 0;
  glCreateBuffers(1, &buffer);
  glNamedBufferStorage(buffer, GLsizeiptr(values.size() * sizeof(T)), values.data(), GL_DYNAMIC_STORAGE_BIT);
  return buffer;
}

template <class T>
void bind_texels(GLuint unit, GLenum format, const std::vector<T>& values) {
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture);
  glTextureBuffer(texture, format, make_buffer(values));
  glBindTextureUnit(unit, texture);
}

GLuint make_target() {
  GLuint target = 0, colour = 0, depth = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &colour);
  glTextureStorage2D(colour, 1, GL_RGBA8, kWidth, kHeight);
  glCreateTextures(GL_TEXTURE_2D, 1, &depth);
  glTextureStorage2D(depth, 1, GL_DEPTH_COMPONENT32F, kWidth, kHeight);
  glCreateFramebuffers(1, &target);
  glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, colour, 0);
  glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, depth, 0);
  const float white[] = {1.0f, 1.0f, 1.0f, 1.0f}, far_away = 0.0f;
  glClearNamedFramebufferfv(target, GL_COLOR, 0, white);
  glClearNamedFramebufferfv(target, GL_DEPTH, 0, &far_away);
  return target;
}

/// A lattice: columns along z, and rows along x and y that cross them. The material is the axis.
std::vector<std::uint32_t> make_records(std::uint32_t& count) {
  std::vector<std::uint32_t> records;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j) {
        core::Placement placement;  // a cylinder lies along its own z
        const int next = (axis + 1) % 3, after = (axis + 2) % 3;
        placement.linear = core::mat3(0.0f);
        placement.linear[0][next] = placement.linear[1][after] = placement.linear[2][axis] = 1.0f;
        placement.origin[next] = 3.0f * float(i);
        placement.origin[after] = 3.0f * float(j);
        render::append_ray_cast_record(core::Cylinder{0.3f + 0.2f * float(axis), 14.0f}, placement, count++,
                                       std::uint32_t(axis), records);
      }
  return records;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: own_renderer OUT.png\n"), 2;
  if (!make_context()) return complain("no OpenGL 4.5 without a window");
  const auto shaders = render::ray_cast_program(core::Kind::kCylinder);
  if (!shaders) return complain(shaders.error().message);
  const GLuint program = link(*shaders);
  if (program == 0) return 1;

  // Far from the world's origin, as sites are.
  const core::dvec3 origin(4.5e5, 5.6e6, 120.0);
  const auto view =
      core::View::perspective({origin + core::dvec3(-19.0, -26.0, 17.0), origin}, 0.7, double(kWidth) / kHeight, 0.1);
  const auto block = view.and_then([](const core::View& of) { return render::ray_cast_view(of, kWidth, kHeight); });
  if (!block) return complain(block.error().message);

  std::uint32_t count = 0;
  const std::vector<std::uint32_t> records = make_records(count);
  const std::vector<std::uint32_t> indices = render::ray_cast_indices(count);
  const std::vector<glm::vec4> colours = {
      {0.80f, 0.32f, 0.24f, 1.0f}, {0.27f, 0.55f, 0.36f, 1.0f}, {0.25f, 0.42f, 0.72f, 1.0f}};
  bind_texels(0, GL_RGBA32UI, records);
  bind_texels(1, GL_RGBA32F, render::ray_cast_origins(*view, {&origin, 1}));
  bind_texels(2, GL_RGBA32F, colours);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, make_buffer(*block));
  glProgramUniform1ui(program, 0, count);
  glProgramUniform1ui(program, 1, shaders->kind);
  glProgramUniform1i(program, 2, shaders->texels_per_record);

  GLuint vertices = 0;  // has no attributes
  glCreateVertexArrays(1, &vertices);
  glVertexArrayElementBuffer(vertices, make_buffer(indices));
  glBindVertexArray(vertices);
  glBindFramebuffer(GL_FRAMEBUFFER, make_target());
  glViewport(0, 0, kWidth, kHeight);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDepthFunc(GL_GREATER);
  for (const GLenum state : {GL_DEPTH_TEST, GL_DEPTH_CLAMP, GL_CULL_FACE}) glEnable(state);
  glUseProgram(program);
  glDrawElements(GL_TRIANGLES, GLsizei(indices.size()), GL_UNSIGNED_INT, nullptr);

  constexpr std::size_t kRow = 3 * kWidth;
  std::vector<std::uint8_t> from_below(kRow * kHeight);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, kWidth, kHeight, GL_RGB, GL_UNSIGNED_BYTE, from_below.data());
  if (const GLenum error = glGetError()) return complain("OpenGL error " + std::to_string(error));
  image::Image image{kWidth, kHeight, {}};
  for (std::size_t y = kHeight; y-- > 0;)
    image.pixels.insert(image.pixels.end(), &from_below[y * kRow], &from_below[y * kRow] + kRow);
  if (const auto saved = image::write_png(image, argv[1]); !saved) return complain(saved.error().message);
  return 0;
}
