// Gives an application back the state of its context.
#pragma once

#include <array>

#include "sightline/gl/functions.h"
#include "sightline/gl/internal/pipeline_state.h"

namespace sightline::gl {

/// While it lives, functions of this library may change a context's state. Its destructor brings all that they change
/// back to what it was: capabilities, masks, tests, viewports, framebuffers, programs, vertex array, indirect,
/// parameter and query buffers, transform feedback object, and what is bound to the texture units and indexed buffer
/// bindings below. They change nothing else, but for pending GL errors, which they take.
///
/// Asks GL some 200 times, which costs microseconds, and more where a driver runs calls on a thread of its own. GL can
/// bring back no object that was deleted while it was bound.
class SavedState {
 public:
  explicit SavedState(const Functions& gl);
  SavedState(const SavedState&) = delete;
  SavedState& operator=(const SavedState&) = delete;
  ~SavedState();

  // What shaders of this library may use.
  static constexpr int kUniformBlocks = 4, kStorageBlocks = 6;

 private:
  // What GL 4.5 guarantees, and what drivers have.
  static constexpr int kDrawBuffers = 8, kViewports = 16;
  static constexpr int kMostCapabilities = 32;
  static constexpr int kBlended = 3;  // draw buffers from the first on, which this library may blend

  struct BufferRange {
    GLint buffer;
    GLint64 start, size;
  };
  struct Unit {
    std::array<GLint, 3> textures;  // of kTextureTargets
    GLint sampler;
  };
  struct DrawBuffer {
    std::array<GLboolean, 4> mask;
    GLboolean blends;
  };
  struct ViewportState {
    std::array<GLfloat, 4> viewport;
    std::array<GLdouble, 2> depth_range;
    std::array<GLint, 4> scissor;
    GLboolean scissors;
  };

  GLint get(GLenum name) const;
  void save_bindings();
  void save_rasterisation();
  void restore_bindings() const;
  void restore_rasterisation() const;

  const Functions& gl_;
  std::array<GLboolean, kMostCapabilities> enabled_;
  std::array<GLint, 2> clip_control_;  // origin, depth mode
  GLint depth_func_, front_face_, cull_face_, provoking_vertex_, derivative_hint_;
  std::array<GLint, 2> polygon_mode_;
  GLboolean depth_mask_;
  GLfloat line_width_;
  std::array<DrawBuffer, kDrawBuffers> draw_buffers_;
  std::array<std::array<GLint, 6>, kBlended> blending_;
  std::array<ViewportState, kViewports> viewports_;
  std::array<GLint, 2> framebuffers_;  // to draw to, to read from
  GLint program_, pipeline_, vertex_array_, feedback_, active_texture_;
  std::array<GLint, 5> buffers_;  // of kBufferPoints
  std::array<Unit, kTextureUnits> units_;
  std::array<BufferRange, kUniformBlocks> uniform_blocks_;
  std::array<BufferRange, kStorageBlocks> storage_blocks_;
  std::array<GLint, 2> unpack_skips_;
};

}  // namespace sightline::gl
